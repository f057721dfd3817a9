"""The pitch balance by a pitch gyro: what of its sum is turning, and what dry friction takes of a gentle nod."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.load_balance.attitude import attitude_terms, leans, nod
from pipelines.estimators.load_balance.nodding import GENTLE_MPS2, QUICK, nodding_columns
from pipelines.estimators.load_balance.smoothing import Smoother
from pipelines.joint.vehicle.unknowns import NOD_STUCK, before_the_log, body_of
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import vehicle

RATE = 50.0
N = round(200 * RATE)
TIME = np.arange(N) / RATE
LEAN = 0.008
"""rad a m/s²."""


def columns_of(push: float, **signals: FloatArray) -> dict[str, FloatArray]:
    """The balance's columns of a drive at walking pace whose force along goes up and down by `push`, m/s²; no row is missing in the middle."""
    base = {"accel_x": np.zeros(N), **signals}
    prepared = Prepared(
        RATE, 15.0, TIME, base, (Segment(0, N),), {}, frozenset(base), np.zeros(N, dtype=bool)
    )
    smooth = Smoother(prepared, 2.0)
    wave = push * np.sqrt(4 / 3) * np.sin(2 * np.pi * 0.4 * TIME[smooth.rows])
    nothing = np.zeros(len(smooth.rows))
    found = dict.fromkeys((*QUICK, "on", "yaw"), nothing) | {
        "vdot": wave,
        "v": nothing + 2,
        "fx_brake": np.minimum(wave, 0),
        "fx_drive": np.maximum(wave, 0),
    }
    return nodding_columns(prepared, found, smooth, np.full(N, 2.0))


def middle(column: FloatArray) -> FloatArray:
    return column[len(column) // 4 : 3 * len(column) // 4]


def test_a_leaning_body_that_turns_is_taken_off_its_pitch_gyro() -> None:
    """A car that weaves and never pitches: its gyro turns about the body's own axis, and the vehicle's yaw is part of that."""
    yaw = 0.3 * np.sin(2 * np.pi * 0.15 * TIME)
    aside = 12.0 * yaw
    made = columns_of(1.0, pitch_rate=yaw * LEAN * aside, yaw_rate=yaw, accel_y=aside)
    assert np.std(middle(made["tip"])) > 1e-3
    assert middle(made["tip"]) == pytest.approx(LEAN * middle(made["quick_turned"]), abs=1e-6)


def test_a_logged_angle_and_a_drive_without_yaw() -> None:
    zero = np.zeros(N)
    logged = columns_of(0.2, pitch=zero, pitch_rate=zero, yaw_rate=zero, accel_y=zero)
    for name in ("quick_turned", "stuck_brake", "stuck_drive"):
        assert not logged[name].any()
    # a gyro alone does not say what of it is turning
    alone = columns_of(0.2, pitch_rate=zero)
    assert not alone["quick_turned"].any()
    assert alone["stuck_brake"].any()


@pytest.mark.parametrize(("push", "share"), [(0.2, 1.0), (GENTLE_MPS2, 0.5), (2.5, 0.0)])
def test_friction_takes_a_share_of_gentle_nods_alone(push: float, share: float) -> None:
    zero = np.zeros(N)
    made = columns_of(push, pitch_rate=zero, yaw_rate=zero, accel_y=zero)
    for mode in ("brake", "drive"):
        whole = middle(made[f"quick_fx_{mode}"])
        assert np.std(middle(made[f"stuck_{mode}"])) == pytest.approx(share * np.std(whole), abs=0.05 * push)


def test_a_drive_that_stands_has_no_nod() -> None:
    zero = np.zeros(N)
    made = columns_of(0.0, pitch_rate=zero, yaw_rate=zero, accel_y=zero)
    assert np.isfinite(middle(made["stuck_brake"])).all()


def test_the_balance_holds_both() -> None:
    known = before_the_log(vehicle(tire_vertical_rate_npm=(250e3, 12e3)))
    p = known.at(np.zeros(len(known.names)))
    terms = attitude_terms(None)(p)
    for mode in ("brake", "drive"):
        assert terms[f"stuck_{mode}"] == pytest.approx(NOD_STUCK[0] * nod(p, mode, None))
    body = body_of(p, None)
    # springs and bars, and the tyres under all of it, by hand
    share = body.x / p["wheelbase"]
    axis = (1 - share) * 0.07 + share * 0.12
    springs = 0.5 * (35e3 + 38e3) * 1.6**2 + p["bar_front"] + p["bar_rear"]
    angle = body.sprung * (body.h - axis) / springs + body.moment / (250e3 * 1.6**2)
    assert leans(p, body) == pytest.approx(angle, rel=0.02)
    assert terms["quick_turned"] == pytest.approx(-terms["tip"] * leans(p, body))
