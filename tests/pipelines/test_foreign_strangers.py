"""The second lot of simulators and recorders: balances that hold, ISO signs, and logs that are what they say."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))

import foreign_parts as fp
from foreign_car import G, draw_car
from foreign_course import Course
from foreign_logs import Case
from foreign_recorders import SPARSE, STRANGERS, Recorder, make_stranger, plain_car

CAR = draw_car(np.random.default_rng(8))
SPEED = np.concatenate([np.full(600, 15.0), np.linspace(15, 7, 200), np.full(300, 7.0)])


def _rows(style: str, steer: float) -> tuple[np.ndarray, object]:
    simulator, choices, plain = STRANGERS[style]
    car = plain_car(CAR) if plain else CAR
    angle = np.concatenate([np.zeros(100), np.full(len(SPEED) - 100, steer)])
    level = np.zeros(len(SPEED))
    return np.asarray(simulator.run(car, Course(SPEED, angle, level, level), choices)), car


@pytest.mark.parametrize("style", list(STRANGERS))
def test_signs_are_those_of_iso_8855_and_the_wheels_carry_the_weight(style: str) -> None:
    turning, braking = (
        _rows(style, 0.02)[0][900:1190].mean(axis=0),
        _rows(style, 0.0)[0][1260:1560].mean(axis=0),
    )
    assert turning[fp.FY] > 0.2
    assert turning[fp.R] > 0.02
    assert turning[fp.ROLL] > 0
    assert turning[fp.DEFLECTION + 1] > turning[fp.DEFLECTION]
    assert braking[fp.FX] < -2
    assert braking[fp.PITCH] > 0
    assert braking[fp.DEFLECTION] > braking[fp.DEFLECTION + 2]
    assert braking[fp.NORMAL : fp.NORMAL + 4].sum() == pytest.approx(CAR.mass * G, rel=0.02)


@pytest.mark.parametrize("style", ["algebra", "bicycle", "bicycle, axis in the ground", "rig"])
def test_load_goes_forward_by_the_moment_of_braking(style: str) -> None:
    rows, _ = _rows(style, 0.0)
    still, braking = rows[800:1190].mean(axis=0), rows[1300:1560].mean(axis=0)
    load = fp.NORMAL
    moved = braking[load : load + 2].sum() - still[load : load + 2].sum()
    assert moved * CAR.wheelbase == pytest.approx(-CAR.mass * CAR.height * braking[fp.FLAT_X], rel=0.03)


def test_the_level_author_leaves_gravity_out() -> None:
    tipped, level = _rows("algebra", 0.02)[0][1000], _rows("algebra, level", 0.02)[0][1000]
    assert level[fp.FY] == pytest.approx(level[fp.V] * level[fp.R], rel=1e-6)
    assert tipped[fp.FY] - level[fp.FY] == pytest.approx(G * level[fp.ROLL], rel=1e-6)


def test_a_recorder_counts_is_late_and_keeps_the_mean() -> None:
    rec = Recorder(np.random.default_rng(1))
    rec.rate, rec.late, rec.counts, rec.drift = 50.0, 5.0, True, 0.0
    wave = np.sin(2 * np.pi * 0.3 * np.arange(8000) / fp.LOG_HZ)
    read = rec.read(wave, "accel", 0.0)
    assert len(read) == 2000
    assert np.abs(read / 0.01 - np.round(read / 0.01)).max() < 1e-6
    late = np.argmax([np.corrcoef(read[k:], wave[1::4][: 2000 - k])[0, 1] for k in range(8)]) / 50.0
    assert late == pytest.approx(2 / (2 * np.pi * 5.0), abs=0.02)


def test_a_sparse_file_holds_hardly_anything() -> None:
    log = make_stranger(Case("algebra", "dwell", "deflection", "sparse", 4))
    head = log.vehicle.split("[reference]")[0]
    keys = {line.split(" = ")[0] for line in head.splitlines() if " = " in line} - {"name", "body"}
    assert all(key.startswith(SPARSE) for key in keys)
    assert log.truth["roll_arm_m"] == pytest.approx(log.truth["cg_height_m"], rel=1e-3)
    assert make_stranger(Case("algebra", "dwell", "deflection", "sparse", 4)).frame.equals(log.frame)
