"""A unit that leans is turned level, and nothing else is turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from parsers.checks.leaning_units import LEANS
from parsers.drive import Drive, Signal
from pipelines.prepare.level_unit import turned_up, with_level_unit
from pipelines.results import FloatArray
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.simulation.manoeuvres.base import Options
from pipelines.vehicles.vehicle import Quantity, Vehicle

ACCELS, GYROS = ("accel_x", "accel_y", "accel_z"), ("roll_rate", "pitch_rate", "yaw_rate")
G = 9.80665


@pytest.fixture(scope="module")
def straight() -> Drive:
    choice = Choice("mixed_minute", preset("sedan"), (), Options(duration_s=90.0), "deflection", seed=3)
    return drive_of(simulate_log(choice).log)


def leaning(drive: Drive, pitch_deg: float, roll_deg: float) -> Drive:
    """What a unit would have read that is turned by these angles against the body: + nose down, + left side up."""
    into = Rotation.from_euler("YX", [pitch_deg, roll_deg], degrees=True).as_matrix().T
    signals = dict(drive.signals)
    for names in (ACCELS, GYROS):
        read = into @ np.stack([signals[name].values for name in names])
        signals |= {n: replace(signals[n], values=v) for n, v in zip(names, read, strict=True)}
    return replace(drive, signals=signals)


def triad(drive: Drive, names: tuple[str, ...]) -> FloatArray:
    return np.stack([drive.signals[name].values for name in names])


@pytest.mark.parametrize(("pitch", "roll"), [(8.0, 0.0), (-12.0, 0.0), (0.0, 7.0), (9.0, -6.0), (20.0, 3.0)])
def test_a_unit_that_leans_reads_as_a_level_one(straight: Drive, pitch: float, roll: float) -> None:
    tilted = leaning(straight, pitch, roll)
    level = with_level_unit(tilted, Vehicle())
    (said,) = [d for d in level.record.decisions if d.kind == "mount"]
    assert said.applied
    assert ("nose down" in said.found) == (pitch > 0)
    assert ("left side up" in said.found) == (roll > 0)
    for names, size in ((ACCELS, G), (GYROS, 0.5)):
        off = np.abs(triad(level, names) - triad(straight, names)).max(axis=1) / size
        before = np.abs(triad(tilted, names) - triad(straight, names)).max(axis=1) / size
        # a road that slopes in the mean, and a body that leans at rest, are left in: a degree
        assert off.max() < 0.25 * before.max()
    assert np.allclose(
        np.linalg.norm(triad(level, ACCELS), axis=0), np.linalg.norm(triad(tilted, ACCELS), axis=0)
    )


def test_what_is_not_touched(straight: Drive) -> None:
    tilted = leaning(straight, 8.0, 0.0)
    assert with_level_unit(straight, Vehicle()) is straight
    assert (
        with_level_unit(leaning(straight, 2.0, 0.0), Vehicle()).record.decisions == straight.record.decisions
    )
    stated = Vehicle(sensors={"imu_pitch_deg": Quantity(8.0, 0.2, "vehicle file")})
    assert with_level_unit(tilted, stated) is tilted
    assert with_level_unit(tilted, Vehicle(), fix=False) is tilted
    two = replace(tilted, signals={n: s for n, s in tilted.signals.items() if n != "accel_z"})
    assert with_level_unit(two, Vehicle()) is two


def test_an_offset_is_no_lean(straight: Drive) -> None:
    """Its vertical axis reads all of gravity."""
    signals = dict(straight.signals)
    signals["accel_x"] = replace(signals["accel_x"], values=signals["accel_x"].values + 2.0)
    off = replace(straight, signals=signals)
    assert with_level_unit(off, Vehicle()) is off


def test_accelerations_alone_are_turned_alone(straight: Drive) -> None:
    tilted = leaning(straight, 10.0, 0.0)
    signals: dict[str, Signal] = {n: s for n, s in tilted.signals.items() if n != "pitch_rate"}
    level = with_level_unit(replace(tilted, signals=signals), Vehicle())
    (said,) = [d for d in level.record.decisions if d.kind == "mount"]
    assert "rates are not all there" in said.action
    assert level.signals["yaw_rate"] is signals["yaw_rate"]
    assert not any(LEANS in d.found for d in level.record.decisions)


def test_the_shortest_turn_brings_up_up_and_keeps_the_heading() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        up = rng.standard_normal(3)
        up[2] = abs(up[2]) + 0.5
        up /= np.linalg.norm(up)
        turn = turned_up(up)
        assert turn @ up == pytest.approx([0, 0, 1])
        assert turn @ turn.T == pytest.approx(np.eye(3))
        assert Rotation.from_matrix(turn).as_rotvec()[2] == pytest.approx(0, abs=1e-12)
