"""Angular rates by one letter: taken where all three axes stand side by side, left where one stands alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.load import load_drive
from parsers.mapping.triads import triads


def columns(*names: str, group: str = "table") -> list[ChannelInfo]:
    """Columns of a table, without units."""
    return [ChannelInfo(name, group, family="table", tags={"column": name}) for name in names]


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("t", "p", "q", "r"), {"p", "q", "r"}),
        (("P", "Q", "R [deg/s]"), {"P", "Q", "R [deg/s]"}),
        (("body.w_x", "body.w_y", "body.w_z"), {"body.w_x", "body.w_y", "body.w_z"}),
        (("p", "q", "x"), set()),
        (("a.p", "a.q", "b.r"), set()),
        (("gx", "gy", "gz"), set()),
        (("gx", "gy", "gz", "acc_x", "acc_y"), {"gx", "gy", "gz"}),
    ],
)
def test_three_axes_side_by_side(names: tuple[str, ...], found: set[str]) -> None:
    assert triads(columns(*names)) == found


def test_another_tables_columns_do_not_count() -> None:
    assert triads([*columns("p", "q", group="1"), *columns("r", group="2")]) == frozenset()


@pytest.mark.parametrize("degrees", [False, True])
def test_a_simulation_with_p_q_r(tmp_path: Path, degrees: bool) -> None:
    """Rates in either unit are found, and physics says in which they are."""
    t = np.arange(6000) / 100
    yaw_rate = 0.25 * np.sin(0.6 * t)
    lateral = 15 * yaw_rate
    roll = 0.01 * lateral
    roll_rate = np.gradient(roll, t)
    unit = 180 / np.pi if degrees else 1.0
    table = np.column_stack(
        [t, 15 + 0 * t, lateral, roll, unit * roll_rate, unit * 0.01 * np.cos(t), unit * yaw_rate]
    )
    path = tmp_path / "sim.csv"
    np.savetxt(path, table, delimiter=",", header="t,v,ay,phi,p,q,r", comments="", fmt="%.9g")
    drive = load_drive((path,))
    assert drive.signals["yaw_rate"].values == pytest.approx(yaw_rate, abs=1e-6)
    assert drive.signals["roll_rate"].values == pytest.approx(roll_rate, abs=1e-6)
    assert "pitch_rate" in drive.signals
