"""Wheels that are in their bump stops for a fifth of a drive leave heights and arms as unsure as a stop's force is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.stops_pressed import MAKES, StopsPressed, stops_pressed, with_stops_said
from pipelines.results import ParameterEstimate, Prior
from pipelines.vehicles.vehicle import Quantity, Vehicle

STATED = Vehicle(
    quantities={
        "bump_stop_clearance_front_m": Quantity(0.06, 0.003, "vehicle file"),
        "bump_stop_clearance_rear_m": Quantity(0.07, 0.003, "vehicle file"),
    }
)


def _drive(pressed: float, *, standing: float = 0.0) -> Drive:
    """Four minutes; the left rear wheel is 9 mm into its stop for the share `pressed` of the time that it drives. standing: share at rest."""
    n = 2400
    t = np.arange(n)
    speed = np.where(t < standing * n, 0.0, 12.0)
    into = ((t * 7919) // 20 % 100) < 100 * pressed
    deep = np.where(np.repeat(into[::20], 20)[:n], 0.079, 0.03)
    columns = {"speed": speed, "suspension_deflection_rl": deep}
    columns |= {f"suspension_deflection_{wheel}": np.full(n, 0.02) for wheel in ("fl", "fr", "rr")}
    stamps = (t * 1e8).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", n, {}, (), "t", None, 240.0, ())
    return Drive({k: Signal(k, stamps, v, k) for k, v in columns.items()}, record)


def _told(name: str, value: float, std: float) -> ParameterEstimate:
    prior = Prior(value, 5 * std, "vehicle file")
    return ParameterEstimate(
        name, value, std, value - 2 * std, value + 2 * std, "identified", "from the log", prior
    )


VERDICT = {name: _told(name, 0.6, 0.01) for name in MAKES} | {"mass_kg": _told("mass_kg", 1700.0, 10.0)}


@pytest.mark.parametrize(("pressed", "share"), [(0.3, 1.0), (0.15, 0.75)])
def test_heights_and_arms_hold_what_a_stop_may_make(pressed: float, share: float) -> None:
    drive = _drive(pressed)
    found = stops_pressed(drive, STATED)
    assert found is not None
    assert found.share == pytest.approx(pressed, abs=0.05)
    told = found.widened(VERDICT)
    assert told["mass_kg"] is VERDICT["mass_kg"]
    for name, makes in MAKES.items():
        assert told[name].status == "weak"
        assert told[name].std == pytest.approx(np.hypot(0.01, 0.6 * makes * share), rel=0.15)
        assert "bump stops" in told[name].reason
    (said,) = with_stops_said(drive, found).record.decisions
    assert not said.applied


def test_seldom_or_unstated_stops_change_nothing() -> None:
    assert stops_pressed(_drive(0.04), STATED) is None
    assert stops_pressed(_drive(0.5), Vehicle()) is None
    # at rest nothing is learned of heights by the way
    assert stops_pressed(_drive(0.5, standing=1.0), STATED) is None
    lacking = _drive(0.5)
    without = Drive({n: s for n, s in lacking.signals.items() if "deflection" not in n}, lacking.record)
    assert stops_pressed(without, STATED) is None
    assert with_stops_said(lacking, None) is lacking


def test_what_is_kept_for_other_drives_is_no_surer() -> None:
    none = np.zeros(0)
    kept = KeptRelations(
        (),
        none,
        none,
        none,
        np.zeros((0, 0)),
        none,
        (),
        (),
        (),
        {},
        {},
        1.0,
        True,
        {"cg_height_m": (0.6, 0.01)},
    )
    wider = StopsPressed(0.5).kept(kept)
    assert wider is not None
    assert wider.told["cg_height_m"][1] == pytest.approx(np.hypot(0.01, 0.6 * MAKES["cg_height_m"]))
    assert StopsPressed(0.5).kept(None) is None
