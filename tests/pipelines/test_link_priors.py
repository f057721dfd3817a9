"""What links do to the body's height, before the log: it follows from the heights that the vehicle file gives."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.load_balance.relations import pitch_terms
from pipelines.joint.vehicle.body import body_of
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.poles import pitch_centres
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.vehicles.usual import CAMBER, ROLL_CENTER
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


def test_roll_centres_that_are_higher_behind_lift_the_tail_in_bends() -> None:
    lengths = {"track_front_m": (1.6, 0.0), "track_rear_m": (1.6, 0.0), "cg_height_m": (0.7, 0.01)}

    def bend(front: float, rear: float) -> tuple[float, float]:
        centres = {
            "roll_center_height_front_m": (front, 0.01),
            "roll_center_height_rear_m": (rear, 0.01),
        }
        return row(known(**centres, **lengths), "jack_bend")

    mean, std = bend(0.04, 0.16)
    # each axle's share of the body, lifted by 4 h h_rc / (g t²) at its distance from the CG: nose down is minus
    lever = BEHIND * (LENGTH - BEHIND) / LENGTH
    assert mean == pytest.approx(lever * 4 * 0.7 * (0.04 - 0.16) / (9.80665 * 1.6**2))
    assert 0 < std < 2 * abs(mean)
    assert bend(0.1, 0.1)[0] == 0.0


def test_the_pitch_balance_in_bends_is_short_of_what_the_links_lift() -> None:
    """Springs that the links relieve at the tail carry that moment less: the balance closes with it added."""
    of = known()
    p = of.at(np.zeros(len(of.names))) | {"jack_bend": -0.006}
    terms = pitch_terms("suspension", of, None)(p)
    body, across = body_of(p, None), 4.0
    tail = 0.006 * body.sprung * across**2 / (p["wheelbase"] - body.x)
    moment = terms["suspension_rl"] * -0.5 * tail + terms["suspension_rr"] * -0.5 * tail
    assert moment + terms["fy2"] * across**2 == pytest.approx(0.0, abs=1e-6)


def test_a_load_behind_moves_the_cg_between_the_lifting_links() -> None:
    """What each axle's links lift stays where it is; its moment about the loaded CG makes the pitch centre there."""
    of = known(drive_front_share=(0.0, 0.0))
    p = of.at(np.zeros(len(of.names)))
    p |= {
        "empty_mass": 2000.0,
        "load": 300.0,
        "load_x": 2.8,
        "jack_brake": 0.02,
        "jack_drive": 0.12,
        "poles_sink": 0.0,
    }
    body = body_of(p, None)
    sprung = 2000.0 - p["unsprung_front"] - p["unsprung_rear"]
    empty = (2000.0 * p["empty_x"] - p["unsprung_rear"] * LENGTH) / sprung
    for mode, centre in zip(("brake", "drive"), pitch_centres(p, body), strict=True):
        # two lifts (+ up, for 1 m/s² ahead) that make the empty body's pitch moment and together the jacking force
        whole = body.sprung * p[f"jack_{mode}"]
        front = (whole * (LENGTH - empty) - body.mass * p[f"pitch_center_{mode}"]) / LENGTH
        rear = whole - front
        nose_up = body.x * front - (LENGTH - body.x) * rear
        assert nose_up == pytest.approx(-body.mass * centre)
    assert body.x > empty + 0.1
    assert pitch_centres(p, body)[1] < p["pitch_center_drive"] - 0.01
    found = outputs_of({n: np.asarray(v) for n, v in p.items()}, {})["pitch_arm_m"]
    assert float(found) == pytest.approx(body.h - pitch_centres(p, body)[0])


def test_a_rig_tells_how_upright_the_wheels_stay() -> None:
    silent, told = row(known(), "camber"), row(known(camber_compensation=(0.5, 0.06)), "camber")
    assert silent == CAMBER[True]
    assert told == (0.5, 0.06)
    # a figure without a spread of its own is no better than rigs are
    assert row(known(camber_compensation=(1.0, 0.0)), "camber") == (1.0, 0.05)


def test_where_nobody_says_live_axles_hold_their_wheels_more_upright() -> None:
    live = row(known(), "camber")
    other = before_the_log(Vehicle("test", "Sedan", {"mass_kg": Quantity(1500.0, 20.0, "test")}))
    independent = row(other, "camber")
    assert independent[0] < live[0] < 1.0
    # one of the two axles stays upright, and is all that is known better
    assert 0.5 * independent[1] < live[1] < independent[1]


@pytest.mark.parametrize(
    ("body", "base", "rigid"),
    [
        ("Utility", None, False),
        ("Utility", 1.1, True),
        ("Utility", 1.58, False),
        ("Pickup", None, True),
        ("Pickup", 1.58, True),
    ],
)
def test_springs_well_inside_the_track_stand_on_a_rigid_axle_of_any_body(
    body: str, base: float | None, rigid: bool
) -> None:
    told = {"mass_kg": (2000.0, 20.0), "track_rear_m": (1.6, 0.01), "drive_front_share": (0.0, 0.0)}
    if base is not None:
        told["spring_base_rear_m"] = (base, 0.01)
    vehicle = Vehicle("test", body, {k: Quantity(v, s, "test") for k, (v, s) in told.items()})
    of = before_the_log(vehicle)
    assert row(of, "camber") == CAMBER[rigid]
    assert row(of, "roll_center_rear") == ROLL_CENTER[rigid]
    assert row(of, "roll_center_front") == ROLL_CENTER[False]
    assert (row(of, "shaft_roll")[1] > 0.01) is rigid
    assert (row(of, "friction_rear")[0] > 1.5 * row(of, "friction_front")[0]) is rigid
    assert (row(of, "force_base_rear")[0] < 1.0) is (rigid and base is None)
