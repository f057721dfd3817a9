"""Columns with a number in few rows: kept small, and told as they were read."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.channels import ChannelInfo
from parsers.intake import Group, Intake
from parsers.load import load_drive
from parsers.sparse_column import Kept, Packed, joined_pieces, packed, whole

NAMES = ("often", "seldom", "hardly")


def _chunks(seed: int, sizes: list[int], shares: tuple[float, float, float]) -> list[dict[str, np.ndarray]]:
    """Chunks of columns that are views of one block each, as readers give them."""
    rng = np.random.default_rng(seed)
    chunks = []
    for size in sizes:
        block = rng.normal(size=(len(NAMES), size))
        for row, share in zip(block, shares, strict=True):
            row[rng.random(size) > share] = np.nan
        chunks.append(dict(zip(NAMES, block, strict=True)))
    return chunks


def _group(chunks: list[dict[str, np.ndarray]], step_ns: int = 1000) -> Group:
    rows = Intake().begin([ChannelInfo(name, "g") for name in NAMES], frozenset(NAMES))
    at = 0
    for chunk in chunks:
        n = len(chunk["often"])
        rows.add("g", (at + np.arange(n)) * step_ns, chunk)
        at += n
    return rows.groups()["g"]


@settings(deadline=None, max_examples=60)
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(1, 5000), min_size=1, max_size=5),
    st.tuples(*(st.sampled_from([0.0, 0.01, 0.2, 0.39, 0.41, 0.9, 1.0]) for _ in NAMES)),
)
def test_columns_are_told_as_they_were_read(
    seed: int, sizes: list[int], shares: tuple[float, float, float]
) -> None:
    chunks = _chunks(seed, sizes, shares)
    expected = {name: np.concatenate([chunk[name] for chunk in chunks]) for name in NAMES}
    columns = _group([{name: values.copy() for name, values in chunk.items()} for chunk in chunks]).columns
    assert set(columns) == set(NAMES)
    assert len(columns) == len(NAMES)
    for name in (*NAMES, *reversed(NAMES)):
        assert name in columns
        np.testing.assert_array_equal(columns[name], expected[name])


def test_late_rows_are_put_in_order_in_packed_columns_too() -> None:
    rng = np.random.default_rng(5)
    n = 4000
    values = np.full(n, np.nan)
    values[::10] = rng.normal(size=n // 10)
    stamps = np.arange(n) * 1000
    shuffled = np.arange(n)
    shuffled[1000:1100] = shuffled[1000:1100][::-1]
    rows = Intake().begin([ChannelInfo("seldom", "g")], frozenset({"seldom"}))
    rows.add("g", stamps[shuffled], {"seldom": values[shuffled]})
    group = rows.groups()["g"]
    np.testing.assert_array_equal(group.time_ns, stamps)
    np.testing.assert_array_equal(group.columns["seldom"], values)


def kept_bytes(piece: Kept) -> int:
    return piece.at.nbytes + piece.values.nbytes if isinstance(piece, Packed) else piece.nbytes


def test_few_numbers_take_few_bytes() -> None:
    (chunk,) = _chunks(1, [100_000], (1.0, 0.1, 0.001))
    kept = packed(chunk)
    assert not isinstance(kept["often"], Packed)
    # a view would keep the whole block in memory
    assert kept["often"].base is None
    dense = 100_000 * 8
    assert kept_bytes(kept["seldom"]) < 0.17 * dense
    assert kept_bytes(kept["hardly"]) < 0.005 * dense
    for name, piece in kept.items():
        np.testing.assert_array_equal(whole(piece), chunk[name])


def test_dense_columns_stay_views() -> None:
    (chunk,) = _chunks(2, [5000], (1.0, 0.9, 0.8))
    kept = packed(chunk)
    assert all(kept[name] is chunk[name] for name in NAMES)


def test_infinite_numbers_are_kept() -> None:
    values = np.full(5000, np.nan)
    values[[7, 2000]] = np.inf, -np.inf
    piece = packed({"x": values})["x"]
    assert isinstance(piece, Packed)
    np.testing.assert_array_equal(joined_pieces([piece, values]), np.concatenate([values, values]))


def test_a_table_of_several_rates_is_read_as_its_signals(tmp_path: Path) -> None:
    """More rows than a block: a value in one row of 40 for one channel, in one of 4 for the other."""
    n = 120_000
    time = np.arange(n) * 0.001
    slow, quick = np.sin(time[::40]), 0.1 * np.cos(time[::4])
    cells = [["", ""] for _ in range(n)]
    for k, value in enumerate(slow):
        cells[40 * k][0] = f"{value:.6f}"
    for k, value in enumerate(quick):
        cells[4 * k][1] = f"{value:.6f}"
    log = tmp_path / "log.csv"
    lines = (f"{t:.3f},{a},{b}" for t, (a, b) in zip(time, cells, strict=True))
    log.write_text("time_s,accel_x_mps2,yaw_rate_radps\n" + "\n".join(lines) + "\n", encoding="utf-8")
    signals = load_drive([log]).signals
    assert signals["accel_x"].values == pytest.approx(slow, abs=1e-6)
    assert signals["yaw_rate"].values == pytest.approx(quick, abs=1e-6)
    assert np.array_equal(
        signals["accel_x"].time_ns - signals["accel_x"].time_ns[0], np.arange(n)[::40] * 1_000_000
    )


def test_a_sparse_table_takes_the_memory_of_its_numbers() -> None:
    """Twenty channels, one of them in each row in turn, in chunks whose columns share a block as readers give them."""
    names, n, chunks = [f"c{k}" for k in range(20)], 60_000, 20
    rows = Intake().begin([ChannelInfo(name, "g") for name in names], frozenset(names))
    tracemalloc.start()
    for number in range(chunks):
        block = np.full((len(names), n), np.nan)
        block[np.arange(n) % len(names), np.arange(n)] = 1.0
        rows.add("g", (number * n + np.arange(n)) * 1000, dict(zip(names, block, strict=True)))
    del block
    group = rows.groups()["g"]
    for name in names:
        assert np.count_nonzero(np.isfinite(group.columns[name])) == n * chunks // len(names)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.5 * len(names) * n * chunks * 8
