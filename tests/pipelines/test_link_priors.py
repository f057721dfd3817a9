"""What links do to the body's height, before the log: it follows from the heights that the vehicle file gives."""

from __future__ import annotations

import pytest

from pipelines.joint.unknowns import Known, before_the_log
from pipelines.vehicles.vehicle import Quantity, Vehicle

LENGTH, BEHIND = 3.0, 1.2


def known(**figures: tuple[float, float]) -> Known:
    told = {
        "mass_kg": (2000.0, 20.0),
        "wheelbase_m": (LENGTH, 0.0),
        "cg_to_front_axle_m": (BEHIND, 0.01),
        **figures,
    }
    return before_the_log(
        Vehicle("test", "Pickup", {k: Quantity(v, s, "test") for k, (v, s) in told.items()})
    )


def row(of: Known, name: str) -> tuple[float, float]:
    return float(of.mean[of.index(name)]), float(of.std[of.index(name)])


def test_a_driven_rear_axle_lifts_the_body_by_what_its_links_carry() -> None:
    drive = {"pitch_center_height_drive_m": (0.45, 0.01)}
    mean, std = row(known(**drive, drive_front_share=(0.0, 0.0)), "jack_drive")
    assert mean == pytest.approx(0.45 / (LENGTH - BEHIND))
    assert 0.03 <= std < 0.04
    front, _ = row(known(**drive, drive_front_share=(1.0, 0.0)), "jack_drive")
    assert front == pytest.approx(-0.45 / BEHIND)


def test_where_the_driven_axle_is_not_known_either_may_lift() -> None:
    drive = {"pitch_center_height_drive_m": (0.3, 0.02)}
    unknown, told = known(**drive), known(**drive, drive_front_share=(0.0, 0.0))
    mean, std = row(unknown, "jack_drive")
    assert abs(mean - row(told, "jack_drive")[0]) < 2 * std
    assert abs(mean + 0.3 / BEHIND) < 2 * std
    # links of unknown height are as unsure as they are
    assert row(known(drive_front_share=(0.0, 0.0)), "jack_drive")[1] > 0.05


def test_roll_centres_lift_the_body_in_bends() -> None:
    centres = {"roll_center_height_front_m": (0.1, 0.01), "roll_center_height_rear_m": (0.1, 0.01)}
    lengths = {"track_front_m": (1.6, 0.0), "track_rear_m": (1.6, 0.0), "cg_height_m": (0.7, 0.01)}
    mean, std = row(known(**centres, **lengths), "jack_side")
    # 4 h h_rc / (g t²)
    assert mean == pytest.approx(4 * 0.7 * 0.1 / (9.80665 * 1.6**2))
    assert mean - std > 0
    flat, _ = row(
        known(roll_center_height_front_m=(0.0, 0.01), roll_center_height_rear_m=(0.0, 0.01)), "jack_side"
    )
    assert flat == 0.0
