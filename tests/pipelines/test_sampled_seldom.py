"""Rows that come too seldom for any motion: every method says so, none fails on its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.errors import VehicleError
from pipelines.analyze import Request, analyze
from pipelines.vehicles.vehicle_file import parse_vehicle

HEAD = (
    "Time [s],AccX [m/s2],AccY [m/s2],AccZ [m/s2],RollRate [deg/s],YawRate [deg/s],Roll [deg],Speed [km/h]\n"
)


@pytest.mark.parametrize(("step", "ran"), [(20.0, False), (0.02, True)])
def test_rows_that_come_seldom_show_no_motion(step, ran, tmp_path):
    rng = np.random.default_rng(2)
    t = np.arange(2000) * step
    side = 3 * np.sin(2 * np.pi * np.arange(2000) / 150)
    rows = np.column_stack(
        [
            t,
            0.1 * rng.standard_normal(2000),
            side,
            9.81 + 0 * t,
            np.gradient(side, step),
            side * 5,
            side * 0.6,
            50 + 0 * t,
        ]
    )
    log = tmp_path / "drive.csv"
    log.write_text(HEAD + "".join(",".join(f"{v:.5f}" for v in row) + "\n" for row in rows))
    (tmp_path / "vehicle.toml").write_text("[vehicle]\nmass_kg = 1500\nroll_stiffness_nmprad = 60000\n")
    results = analyze(Request(logs=(log,), vehicle=tmp_path / "vehicle.toml", estimators="roll_map"))
    (estimate,) = results.estimates
    assert estimate.status == ("ran" if ran else "skipped")
    assert ("rows come every 20 s" in estimate.reason) is not ran


def test_a_reference_that_no_vehicle_has_is_refused(tmp_path):
    with pytest.raises(VehicleError, match=r"\[reference\] cg_height_m.*found -1, expected more than 0"):
        parse_vehicle("[reference]\ncg_height_m = -1\n", tmp_path / "v.toml")
