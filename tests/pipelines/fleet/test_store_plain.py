"""Records as JSON and back: the same record, and anything else refused with its place."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import StoreError
from pipelines.fleet.plain import from_plain, json_bytes, read_json, to_plain
from pipelines.fleet.rows import DriveRows, rows_bytes, rows_from, rows_of
from pipelines.hierarchy.records import VehicleKnowledge
from pipelines.results import ParameterEstimate, Prior
from tests.pipelines.fleet.stored_drives import join_plainly, results_of_drive
from tests.reports.sample_results import bare, hostile


@dataclass(frozen=True)
class Inner:
    number: float
    pair: tuple[float, int] = (0.0, 0)


@dataclass(frozen=True)
class Outer:
    text: str
    kind: Literal["a", "b"]
    whole: int
    yes: bool
    maybe: Inner | None
    many: tuple[Inner, ...]
    table: dict[str, float] = field(default_factory=dict)


inner = st.builds(Inner, st.floats(allow_nan=False), st.tuples(st.floats(allow_nan=False), st.integers()))
outer = st.builds(
    Outer, st.text(), st.sampled_from(["a", "b"]), st.integers(), st.booleans(), st.none() | inner,
    st.lists(inner, max_size=3).map(tuple), st.dictionaries(st.text(), st.floats(allow_nan=False), max_size=3),
)  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(outer)
def test_round_trip(record: Outer) -> None:
    content = json_bytes(record)
    assert content.isascii()
    again = from_plain(Outer, read_json(content))
    assert again == record
    assert json_bytes(again) == content


def test_nan_and_the_sign_of_nought_survive() -> None:
    again = from_plain(Inner, read_json(json_bytes(Inner(math.nan, (-0.0, 1)))))
    assert math.isnan(again.number)
    assert math.copysign(1, again.pair[0]) == -1
    assert to_plain({"a": np.float64(0.5), "b": np.int64(3), "c": (None, True)}) == {
        "a": 0.5,
        "b": 3,
        "c": [None, True],
    }
    with pytest.raises(TypeError):
        to_plain(object())


GOOD: dict[str, Any] = {
    "text": "t", "kind": "a", "whole": 1, "yes": True, "maybe": None, "many": [{"number": 1.0}], "table": {"x": 1},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"text": 5}, "text: found '5', expected str"),
        ({"kind": "c"}, "kind: found 'c', expected a or b"),
        ({"kind": ["a"]}, "kind: found"),
        ({"whole": True}, "whole: found 'True', expected int"),
        ({"whole": 1.5}, "whole: found '1.5'"),
        ({"yes": 1}, "yes: found '1', expected bool"),
        ({"maybe": []}, "maybe: found"),
        ({"many": [{"number": 1.0}, {"number": "x"}]}, r"many\[1\].number: found 'x', expected a number"),
        ({"many": [{"number": 1.0, "pair": [1.0]}]}, r"many\[0\].pair: found"),
        ({"many": [{}]}, r"many\[0\].number: is missing"),
        ({"many": {}}, "many: found"),
        ({"table": {"x": True}}, "table.x: found 'True', expected a number"),
        ({"table": {"x": 10**400}}, "table.x: found"),
        ({"table": [1]}, "table: found"),
    ],
    ids=str,
)
def test_what_is_wrong_is_said_with_its_place(change: dict[str, Any], told: str) -> None:
    assert from_plain(Outer, GOOD).table == {"x": 1.0}
    with pytest.raises(StoreError, match=told):
        from_plain(Outer, {**GOOD, **change})


def test_a_later_cogests_fields_are_passed_over() -> None:
    assert from_plain(Inner, {"number": 1, "new": [1, 2]}) == Inner(1.0)


@pytest.mark.parametrize("results", [results_of_drive(3), results_of_drive(4, None), bare(), hostile()])
def test_rows_of_results(results: Any) -> None:
    rows = rows_of(results)
    assert rows_from(rows_bytes(rows)) == rows
    assert isinstance(rows, DriveRows)
    assert list(rows.verdict) == list(results.verdict)
    assert rows.start_utc == results.record.start_utc


def test_rows_hold_nothing_of_when_and_where() -> None:
    content = rows_bytes(rows_of(results_of_drive(1))).decode()
    assert "runtime" not in content
    assert "created" not in content


def test_what_was_joined_survives() -> None:
    estimate = ParameterEstimate(
        "mass_kg", 1 / 3, 0.1, 0.0, 1.0, "weak", "r", Prior(1.0, 2.0, "p"), None, ("a",)
    )
    from pipelines.hierarchy.records import DriveTold

    told = [DriveTold(f"d{n}", None, {"mass_kg": estimate}, None) for n in range(3)]
    knowledge = join_plainly("v", told)
    assert from_plain(VehicleKnowledge, read_json(json_bytes(knowledge))) == knowledge
