"""`cogest reproduce gpc_regression`: what its tables and claims must show."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.reproduce.base import Reproduction
from pipelines.reproduce.registry import paper


@pytest.fixture(scope="module")
def found() -> Reproduction:
    return paper("gpc_regression").reproduce(6, np.random.default_rng(0), lambda _what, _share: None)


def test_all_tables_and_figures_are_there(found: Reproduction) -> None:
    assert [table.place for table in found.tables] == ["Table 3.8", "Table 3.9", "Table 3.10"]
    names = " ".join(trace.name for trace in found.traces)
    assert all(f"Fig 3.{number}" in names for number in range(32, 40))
    for table in found.tables:
        assert all(len(row) == len(table.columns) for row in table.rows)


def test_points_are_a_multiple_of_the_terms(found: Reproduction) -> None:
    rows = {str(row[0]): [abs(float(v or 0)) for v in row[1:]] for row in found.tables[0].rows}
    assert max(max(v) for k, v in rows.items() if k.startswith("4 ")) > 3
    assert max(max(v) for k, v in rows.items() if "x S" in k) < 0.01


def test_input_noise_biases_the_height_only_until_it_is_taken_out(found: Reproduction) -> None:
    for row in found.study:
        if row.setup == "noise on all channels" and row.parameter == "CG height":
            bias = 100 * row.bias / row.truth
            assert abs(bias) < 2 if "taken out" in row.method else bias < -6


def test_batch_and_square_root_reach_the_bound(found: Reproduction) -> None:
    ratios = [row.ratio for row in found.study if row.target is not None and row.ratio is not None]
    assert len(ratios) == 16
    assert float(np.median(ratios)) == pytest.approx(1.0, abs=0.35)
    assert not [claim for claim in found.claims if claim.place == "3.9" and claim.agreement == "differs"]
