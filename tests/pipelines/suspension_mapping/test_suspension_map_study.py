"""The study's vehicles and figures: what goes past the struts, and how errors become rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.reproduce.suspension_map.drives import Fitted, drive, fit_out
from pipelines.reproduce.suspension_map.study import Judgement, ratios, study_rows, study_table
from pipelines.simulation.manoeuvres.base import Options


def _read(fitted: Fitted, signal: str) -> np.ndarray:
    rng = np.random.default_rng(3)
    made = drive(fitted, "slalom", fitted.other, rng, Options(duration_s=20.0))
    return made.drive.signals[signal].values


def test_what_goes_past_the_struts() -> None:
    fitted = fit_out(np.random.default_rng(1), "suv")
    whole = _read(replace(fitted, past=0.0, bar_past=False), "suspension_force_fl")
    less = _read(replace(fitted, past=1.0, bar_past=False), "suspension_force_fl")
    most = fitted.vehicle.friction_n
    gone = whole - less
    assert np.abs(gone).max() <= 1.05 * most
    assert np.std(gone) > 0.2 * most
    bar = whole - _read(replace(fitted, past=0.0, bar_past=True), "suspension_force_fl")
    assert np.std(bar) > 100


def test_instruments_stay_with_the_vehicle() -> None:
    fitted = fit_out(np.random.default_rng(2), "sedan")
    sensors = {s.signal: s for unit in fitted.sensors.units for s in unit.sensors}
    struts = sensors["suspension_force_rl"]
    assert struts.scale_error != 0
    assert struts.scale_std <= 0.001
    assert sensors["accel_y"].scale_std == 0
    assert 0 < sensors["accel_y"].offset_std < 0.03


def _judgement(vehicle: int, measured: float, training: float, inside: float) -> Judgement:
    return Judgement(
        "struts", "friction", "slalom", vehicle, measured**2, (2 * measured) ** 2, training**2, 1.0, inside
    )


def test_rows_and_ratios_by_hand() -> None:
    found = [_judgement(0, 30.0, 20.0, 0.9), _judgement(1, 40.0, 40.0, 1.0)]
    found += [replace(j, part="springs") for j in found]
    assert ratios(found, "struts") == pytest.approx([1.5, 1.0])
    aim, row, *_ = study_rows(found)
    assert aim.ratio == pytest.approx(np.sqrt(1.25))
    assert aim.target == 1.3
    assert (row.rmse, row.coverage, row.bias) == pytest.approx((2 * np.sqrt(1250), 0.95, 1.0))
    first = study_table(found).rows[0]
    assert first[2:5] == pytest.approx((np.sqrt(1000), np.sqrt(1250), np.sqrt(1.25)))
