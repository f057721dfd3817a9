"""roll_plane, pitch_plane and the published witness: planted truth, noise, friction, wrong signs, what a drive lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from plane_ride import Faults, Push, Rigid, as_drive, logged, ride, truth, vehicle_file

from parsers.drive import Drive, Signal
from pipelines.estimators.base import Estimator
from pipelines.estimators.roll_pitch_plane.fit import Column, fit
from pipelines.estimators.roll_pitch_plane.pitch import PitchPlane
from pipelines.estimators.roll_pitch_plane.published import GpcRollPlane
from pipelines.estimators.roll_pitch_plane.roll import RollPlane
from pipelines.models.pitch_plane import pitch_acceleration, pitch_moment_needed, strut_pitch_moment
from pipelines.models.roll_plane import roll_acceleration, roll_moment_needed, strut_roll_moment
from pipelines.results import Estimate, FloatArray
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

BODY = Rigid()
QUIET = Faults(0.0, 0.0, 0.0, 0.0)
ROLL, PITCH, WITNESS = RollPlane(), PitchPlane(), GpcRollPlane()
CORNERS = tuple(f"accel_z_sprung_{w}" for w in ("fl", "fr", "rl", "rr"))


def run(
    estimator: Estimator, drive: Drive, vehicle: Vehicle, settings: Mapping[str, float] | None = None
) -> Estimate:
    chosen = settings or {}
    return estimator.estimate(estimator.prepare(drive, chosen), vehicle, chosen, np.random.default_rng(0))


def made(push: Push | None = None, faults: Faults | None = None, seed: int = 0, body: Rigid = BODY) -> Drive:
    rng = np.random.default_rng(seed)
    return logged(ride(body, push or Push(), rng), faults or Faults(), rng)


def without(drive: Drive, *names: str) -> Drive:
    return replace(drive, signals={k: s for k, s in drive.signals.items() if k not in names})


def turned(drive: Drive, *names: str) -> Drive:
    signals = {k: replace(s, values=-s.values) if k in names else s for k, s in drive.signals.items()}
    return replace(drive, signals=signals)


def missed(estimate: Estimate) -> list[str]:
    """Answers that are silent, whose interval leaves the truth out, or whose reference is another one."""
    wrong = []
    for name, entry in estimate.parameters.items():
        true = truth(BODY)[name]
        if entry.low is None or entry.high is None:
            wrong.append(f"{name} silent: {entry.reason}")
        elif not entry.low <= true <= entry.high:
            wrong.append(f"{name} {true} outside {entry.low} to {entry.high}")
        elif entry.reference != true:
            wrong.append(f"{name} has the reference {entry.reference}")
    return wrong


def test_signs_of_the_balances() -> None:
    """Braking loads the front, a left turn the right side; a CG behind and to the left loads rear and left."""
    zero = np.zeros(1)
    g = np.array([9.81])
    forces = np.array([[1000.0, 2000.0, 3000.0, 5000.0]])
    assert strut_roll_moment(forces, (1.5, 1.6))[0] == pytest.approx(0.75 * -1000 + 0.8 * -2000)
    assert strut_pitch_moment(forces, 3.0)[0] == pytest.approx(1.5 * (8000 - 3000))
    assert roll_moment_needed(zero, np.array([4.0]), g, 600, 900, 0)[0] < 0
    assert roll_moment_needed(zero, zero, g, 600, 900, 30)[0] > 0
    assert pitch_moment_needed(zero, np.array([-4.0]), g, 2500, 900, 0)[0] < 0
    assert pitch_moment_needed(zero, zero, g, 2500, 900, 30)[0] > 0


def test_corner_accelerations_give_the_planted_angular_accelerations() -> None:
    x, y = np.array([1.3, 1.3, -1.5, -1.5]), np.array([0.8, -0.8, 0.75, -0.75])
    corners = 0.3 + 0.7 * y[None, :] - (-0.4) * x[None, :]
    assert roll_acceleration(corners, (1.6, 1.5))[0] == pytest.approx(0.7)
    assert pitch_acceleration(corners, 2.8)[0] == pytest.approx(-0.4)


def test_fit_is_least_squares_and_takes_known_noise_out() -> None:
    rng = np.random.default_rng(0)
    x = rng.standard_normal((4000, 2))
    y = x @ np.array([3.0, -1.0]) + 0.1 * rng.standard_normal(4000)
    block = np.arange(4000) // 100
    plain = fit(y, (Column("a", x[:, 0]), Column("b", x[:, 1])), block)
    assert plain is not None
    assert np.allclose(plain.values, np.linalg.lstsq(x, y, rcond=None)[0], rtol=1e-9)
    assert plain.std("a") == pytest.approx(0.1 / 4000**0.5, rel=0.4)
    seen = x[:, 0] + 0.6 * rng.standard_normal(4000)
    low = fit(y, (Column("a", seen), Column("b", x[:, 1])), block)
    right = fit(y, (Column("a", seen, noise=0.36), Column("b", x[:, 1])), block)
    assert low is not None
    assert right is not None
    assert low.value("a") == pytest.approx(3 / 1.36, rel=0.05)
    assert abs(right.value("a") - 3) < 3 * right.std("a") < 0.5
    assert right.told[0] == pytest.approx(1 / 1.36, abs=0.05)
    assert fit(y[:300], (Column("a", x[:300, 0]),), block[:300]) is None


@pytest.mark.parametrize("estimator", [ROLL, PITCH])
def test_planted_body_comes_back_exactly_without_noise(estimator: Estimator) -> None:
    found = run(estimator, made(faults=QUIET), vehicle_file(BODY))
    for name, entry in found.parameters.items():
        assert entry.value is not None
        close = 0.004 if name.endswith("offset_m") else 0.02 * truth(BODY)[name]
        assert entry.value == pytest.approx(truth(BODY)[name], abs=close), name
    assert missed(found) == []
    assert found.used_fraction == 1.0
    assert not found.witness
    assert len(found.tracks) == 2
    for track in found.tracks:
        end = found.parameters[track.parameter]
        assert track.value[-1] == pytest.approx(end.value)
        assert track.high[0] - track.low[0] > 0.99 * (track.high[-1] - track.low[-1])


@pytest.mark.parametrize("seed", [1, 2])
def test_intervals_hold_with_noise(seed: int) -> None:
    drive = made(seed=seed)
    for estimator in (ROLL, PITCH):
        assert missed(run(estimator, drive, vehicle_file(BODY))) == []


def test_gyros_serve_where_there_are_no_body_accelerometers() -> None:
    drive = without(made(), *CORNERS)
    found = run(ROLL, drive, vehicle_file(BODY))
    assert missed(found) == []
    assert missed(run(PITCH, drive, vehicle_file(BODY))) == []
    assert any("roll_rate" in a.value for a in found.assumptions)


def test_noisy_acceleration_does_not_pull_the_inertia_down() -> None:
    """Noise as large as half the motion, without which least squares is 20 % low."""
    loud = replace(Faults(), corner=0.9)
    values = [
        run(ROLL, made(Push(roll=0.25), loud, seed), vehicle_file(BODY)).parameters["roll_inertia_kgm2"].value
        for seed in range(4)
    ]
    assert all(v is not None for v in values)
    assert float(np.mean([v for v in values if v])) == pytest.approx(BODY.roll_inertia, rel=0.06)


def test_friction_that_the_sensors_miss_stays_inside_the_intervals() -> None:
    drive = made(faults=replace(Faults(), friction=120.0))
    for estimator in (ROLL, PITCH):
        found = run(estimator, drive, vehicle_file(BODY))
        assert missed(found) == []
    wide = run(
        ROLL,
        without(drive, *(f"suspension_deflection_{w}" for w in ("fl", "fr", "rl", "rr"))),
        vehicle_file(BODY),
    )
    assert missed(wide) == []


def test_huge_friction_is_said_and_not_estimated() -> None:
    drive = made(Push(lateral=0.5, roll=0.1), faults=replace(Faults(), friction=2500.0))
    entry = run(ROLL, drive, vehicle_file(BODY)).parameters["roll_inertia_kgm2"]
    assert entry.status == "not_identifiable"
    assert "friction" in entry.reason


def test_straight_and_smooth_drives_say_what_they_lack() -> None:
    smooth = Push(lateral=0.02, longitudinal=0.02, roll=0.003, pitch=0.003)
    roll = run(ROLL, made(smooth), vehicle_file(BODY)).parameters
    pitch = run(PITCH, made(smooth), vehicle_file(BODY)).parameters
    for entry in (
        roll["roll_arm_m"],
        roll["roll_inertia_kgm2"],
        pitch["pitch_arm_m"],
        pitch["pitch_inertia_kgm2"],
    ):
        assert entry.status == "not_identifiable"
        assert entry.reason
    assert "needed" in roll["roll_arm_m"].reason
    assert roll["sprung_mass_kg"].value == pytest.approx(BODY.mass, rel=0.03)


def test_turned_signs_are_refused() -> None:
    lateral = run(ROLL, turned(made(), "accel_y"), vehicle_file(BODY)).parameters["roll_arm_m"]
    assert lateral.status == "not_identifiable"
    assert "sign" in lateral.reason
    forces = tuple(f"suspension_force_{w}" for w in ("fl", "fr", "rl", "rr"))
    for estimator in (ROLL, PITCH, WITNESS):
        found = run(estimator, turned(made(), *forces), vehicle_file(BODY))
        assert all(p.status == "not_identifiable" for p in found.parameters.values())


def test_missing_signals_and_short_drives_end_in_words() -> None:
    few = made(Push(seconds=10.0))
    for estimator, names in ((ROLL, ("roll_rate", *CORNERS)), (PITCH, ("pitch_rate", *CORNERS))):
        for drive in (
            few,
            without(made(), *names),
            without(made(), "suspension_force_rl"),
            as_drive({"speed": np.ones(500)}),
        ):
            found = run(estimator, drive, vehicle_file(BODY))
            assert found.status == "ran"
            assert all(p.status == "not_identifiable" and p.reason for p in found.parameters.values())


def test_unknown_height_of_the_sensor_widens_the_inertia() -> None:
    drive, told = made(), vehicle_file(BODY)
    silent = replace(
        told, sensors={}, quantities={k: q for k, q in told.quantities.items() if "center" not in k}
    )
    for estimator, name in ((ROLL, "roll_inertia_kgm2"), (PITCH, "pitch_inertia_kgm2")):
        sure = run(estimator, drive, told).parameters[name].std
        unsure = run(estimator, drive, silent).parameters[name].std
        assert sure is not None
        assert unsure is not None
        assert unsure > 1.3 * sure


def test_outliers_gaps_and_other_rates_are_survived() -> None:
    drive = made(seed=4)
    rng = np.random.default_rng(0)
    signals = dict(drive.signals)
    for name, signal in drive.signals.items():
        values: FloatArray = signal.values.copy()
        if name.startswith("suspension_force"):
            values[rng.integers(0, len(values), 5)] += 8000.0
        keep = np.ones(len(values), dtype=bool)
        keep[3000:3400] = False
        if name == "speed":
            keep[1::2] = False
        signals[name] = Signal(name, signal.time_ns[keep], values[keep], "made")
    spoiled = replace(drive, signals=signals)
    for estimator in (ROLL, PITCH):
        assert missed(run(estimator, spoiled, vehicle_file(BODY))) == []


def test_witness_follows_and_its_interval_holds() -> None:
    found = run(WITNESS, made(), vehicle_file(BODY))
    assert found.witness
    assert missed(found) == []
    assert {t.parameter for t in found.tracks} == set(WITNESS.parameters)
    for track in found.tracks:
        assert len(track.time_s) == len(track.value) > 100
        assert np.all(track.low <= track.high)


def test_full_plant_with_every_sensor() -> None:
    made_log = simulate_log(Choice("rural", preset("suv"), seed=11, sensors="everything"))
    drive = drive_of(made_log.log)
    vehicle = parse_vehicle(made_log.sheet, Path("suv.toml"))
    for estimator in (ROLL, PITCH, WITNESS):
        found = run(estimator, drive, vehicle)
        for name, entry in found.parameters.items():
            true = made_log.run.truth[name]
            assert entry.low is not None, entry.reason
            assert entry.high is not None
            assert entry.low <= true <= entry.high, name
            if not found.witness and name in (
                "roll_inertia_kgm2",
                "pitch_inertia_kgm2",
                "roll_arm_m",
                "pitch_arm_m",
            ):
                assert entry.value == pytest.approx(true, rel=0.1)
