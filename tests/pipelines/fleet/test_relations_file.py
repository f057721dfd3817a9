"""relations.parquet: what is read back is what was written, to the bit; and what is none is refused, whatever its size."""

from __future__ import annotations

import io
from dataclasses import fields, replace
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from parsers.errors import StoreError
from pipelines.fleet import relations_file
from pipelines.fleet.relations_file import SCHEMA, relations_bytes, relations_from
from pipelines.joint.kept import KeptRelations
from tests.pipelines.fleet.stored_drives import kept_of_drive

FIGURE = st.one_of(st.floats(), st.sampled_from([0.0, -0.0, 1.0, np.inf, np.nan]))
NAME = st.text(st.characters(exclude_categories=("Cs",)), max_size=12)


@st.composite
def relations(draw: Any) -> KeptRelations:
    m, k = draw(st.integers(0, 6)), draw(st.integers(0, 5))

    def vector(n: int) -> Any:
        return draw(arrays(np.float64, n, elements=FIGURE))

    def names(n: int) -> tuple[str, ...]:
        return tuple(draw(st.lists(NAME, min_size=n, max_size=n)))

    table = st.dictionaries(NAME, FIGURE, max_size=3)
    pairs = st.dictionaries(NAME, st.tuples(FIGURE, FIGURE), max_size=3)
    return KeptRelations(
        names(k), vector(k), vector(k), vector(k), draw(arrays(np.float64, (m, k), elements=FIGURE)), vector(m), names(m),
        names(m), names(m), draw(table), draw(table), draw(FIGURE), draw(st.booleans()), draw(pairs), draw(pairs),
    )  # fmt: skip


def bits(value: Any) -> Any:
    """A value in a form in which NaN equals NaN and 0 is not -0."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if isinstance(value, dict):
        return [(name, np.array(figure, dtype=np.float64).tobytes()) for name, figure in value.items()]
    return np.float64(value).tobytes() if isinstance(value, float) else value


def equal(a: KeptRelations, b: KeptRelations) -> bool:
    return all(bits(getattr(a, f.name)) == bits(getattr(b, f.name)) for f in fields(KeptRelations))


@settings(max_examples=60, deadline=None)
@given(relations())
def test_round_trip_to_the_bit(kept: KeptRelations) -> None:
    content = relations_bytes(kept)
    assert equal(relations_from(content), kept)
    assert relations_bytes(relations_from(content)) == content


def test_an_ordinary_drive_is_small() -> None:
    kept = kept_of_drive(1, unknowns=40, relations=60)
    assert len(relations_bytes(kept)) < 20_000
    assert equal(relations_from(relations_bytes(kept)), kept)


def test_a_file_of_before_doubts_were_kept_is_read() -> None:
    kept = replace(
        kept_of_drive(1), told={"mass_kg": (1900.0, 40.0)}, empty={"empty_mass_kg": (1800.0, 20.0)}
    )
    assert equal(relations_from(relations_bytes(kept)), kept)
    table = pl.read_parquet(io.BytesIO(relations_bytes(kept))).filter(
        ~pl.col("entry").is_in(["told", "empty"])
    )
    content = io.BytesIO()
    table.write_parquet(content)
    assert equal(relations_from(content.getvalue()), replace(kept, told={}, empty={}))


def test_others_can_read_it() -> None:
    kept = kept_of_drive(4)
    table = pl.read_parquet(io.BytesIO(relations_bytes(kept)))
    slopes = table.filter(pl.col("entry") == "slope")
    assert slopes.height == np.count_nonzero(kept.rows)
    at = slopes.select("row", "name", "value").row(0)
    assert kept.rows[at[0], kept.names.index(at[1])] == at[2]


def _changed(**columns: pl.Expr) -> bytes:
    table = pl.read_parquet(io.BytesIO(relations_bytes(kept_of_drive(1))))
    content = io.BytesIO()
    table.with_columns(**columns).select(list(SCHEMA)).write_parquet(content)
    return content.getvalue()


def _when(entry: str, column: str, value: object) -> pl.Expr:
    return (
        pl.when(pl.col("entry") == entry).then(pl.lit(value, dtype=SCHEMA[column])).otherwise(pl.col(column))
    )


BROKEN = {
    "empty": b"",
    "no parquet": b"PAR1" + bytes(40) + b"PAR1",
    "truncated": relations_bytes(kept_of_drive(1))[:-30],
    "row beyond": _changed(row=_when("slope", "row", 99)),
    "negative row": _changed(row=_when("slope", "row", -1)),
    "no row": _changed(row=_when("slope", "row", None)),
    "column beyond": _changed(column=_when("slope", "column", 6)),
    "unknowns twice": _changed(column=_when("unknown", "column", 0)),
    "no name": _changed(name=_when("relation", "name", None)),
    "no figure": _changed(value=_when("relation", "value", None)),
    "two inflations": _changed(entry=pl.when(pl.col("entry") == "normal").then(pl.lit("inflation")).otherwise("entry")),
    "others' columns": (lambda c: (pl.DataFrame({"a": [1]}).write_parquet(c), c.getvalue())[1])(io.BytesIO()),
}  # fmt: skip


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_none_is_refused(kind: str) -> None:
    with pytest.raises(StoreError):
        relations_from(BROKEN[kind])


def test_a_small_file_of_too_many_entries_is_refused_unread(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = 5_000_000
    columns = {name: pl.repeat(None, rows, dtype=kind, eager=True) for name, kind in SCHEMA.items()}
    content = io.BytesIO()
    pl.DataFrame(columns).with_columns(entry=pl.lit("slope")).write_parquet(content)
    assert len(content.getvalue()) < 200_000

    def read(*_: object, **__: object) -> None:
        raise AssertionError("was unpacked")

    monkeypatch.setattr(relations_file.pl, "read_parquet", read)
    with pytest.raises(StoreError, match="entries, a drive's relations have at most"):
        relations_from(content.getvalue())
