"""Each sensor error does what it says, on a run whose motion is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.errors import SettingsError
from parsers.signals import SIGNALS
from pipelines.results import FloatArray
from pipelines.simulation.records import GRAVITY, RUN_COLUMNS, PlantRun
from pipelines.simulation.sensors.errors import SensorModel
from pipelines.simulation.sensors.filter import biquad, first_order, low_pass, wander
from pipelines.simulation.sensors.sets import SENSOR_SETS, sensor_set
from pipelines.simulation.sensors.truth import Fit, Mount, rotation
from pipelines.simulation.sensors.units import SensorLog, SensorSet, SensorUnit, apply

RATE = 500.0
CG = (1.3, 0.05, 0.7)


def make_run(duration_s: float = 40.0, **given: FloatArray) -> PlantRun:
    """A run at 500 Hz: everything 0 and at rest but what is given."""
    time_s = np.arange(round(duration_s * RATE) + 1) / RATE
    columns = {name: np.zeros_like(time_s) for name in RUN_COLUMNS}
    columns["accel_z_mps2"] += GRAVITY
    columns |= given
    return PlantRun(RATE, time_s, columns, {}, CG)


def times(duration_s: float = 40.0) -> FloatArray:
    return np.asarray(np.arange(round(duration_s * RATE) + 1) / RATE)


def measured(run: PlantRun, *sensors: SensorModel, rate_hz: float = 100.0, seed: int = 1) -> SensorLog:
    unit = SensorUnit("box", rate_hz, sensors)
    return apply(run, SensorSet("test", "", (unit,)), np.random.default_rng(seed))


def one(run: PlantRun, sensor: SensorModel, rate_hz: float = 100.0, seed: int = 1) -> FloatArray:
    return measured(run, sensor, rate_hz=rate_hz, seed=seed).signals[sensor.signal]


SWAY = np.sin(2 * np.pi * 0.5 * times()) + 0.3 * np.sin(2 * np.pi * 1.7 * times() + 1)


def test_without_errors_the_truth_comes_out_at_the_rate() -> None:
    log = measured(make_run(accel_y_mps2=SWAY), SensorModel("accel_y"), rate_hz=50.0)
    (group,) = log.groups
    assert len(group.time_ns) == 40 * 50 + 1
    assert set(np.diff(group.time_ns)) == {20_000_000}
    np.testing.assert_allclose(group.columns["accel_y"], SWAY[::10], atol=1e-12)


@pytest.mark.parametrize("rate_hz", [7.0, 33.3, 200.0])
def test_rates_that_divide_nothing(rate_hz: float) -> None:
    (group,) = measured(make_run(accel_y_mps2=SWAY), SensorModel("accel_y"), rate_hz=rate_hz).groups
    seconds = group.time_ns / 1e9
    np.testing.assert_allclose(np.diff(seconds), 1 / rate_hz, atol=2e-9)
    expected = np.sin(np.pi * seconds) + 0.3 * np.sin(2 * np.pi * 1.7 * seconds + 1)
    np.testing.assert_allclose(group.columns["accel_y"], expected, atol=2e-4)


def test_noise_offset_and_scale() -> None:
    run = make_run(accel_y_mps2=SWAY)
    values = one(run, SensorModel("accel_y", noise=0.05, offset=-0.1, scale_error=0.02), rate_hz=500)
    slope, offset = np.polyfit(SWAY, values, 1)
    residual = values - slope * SWAY - offset
    assert slope == pytest.approx(1.02, abs=0.002)
    assert offset == pytest.approx(-0.1, abs=0.002)
    assert residual.std() == pytest.approx(0.05, rel=0.02)
    white = np.corrcoef(residual[1:], residual[:-1])[0, 1]
    assert abs(white) < 4 / np.sqrt(len(values))


def test_drawn_constants_have_their_spread_and_are_told() -> None:
    run = make_run(1.0)
    sensor = SensorModel("accel_y", offset=0.5, offset_std=0.08, scale_std=0.01)
    drawn = [measured(run, sensor, seed=seed).drawn["accel_y"] for seed in range(400)]
    offsets, scales = np.array([(d.offset, d.scale_error) for d in drawn]).T
    assert offsets.mean() == pytest.approx(0.5, abs=4 * 0.08 / 20)
    assert offsets.std() == pytest.approx(0.08, rel=0.15)
    assert scales.std() == pytest.approx(0.01, rel=0.15)
    values = one(run, sensor, seed=3)
    np.testing.assert_allclose(values, drawn[3].offset, atol=1e-12)


@pytest.mark.parametrize("delay_s", [0.0, 0.01, 0.15])
def test_delay_by_cross_correlation(delay_s: float) -> None:
    run = make_run(accel_y_mps2=SWAY)
    late = one(run, SensorModel("accel_y", delay_s=delay_s), rate_hz=500)
    lags = np.arange(-100, 101)
    inner = slice(200, -200)
    match = [np.dot(late[inner], np.roll(SWAY, lag)[inner]) for lag in lags]
    assert lags[int(np.argmax(match))] / RATE == pytest.approx(delay_s, abs=1e-9)


def test_quantisation_saturation_and_the_crawl_that_reads_zero() -> None:
    run = make_run(accel_y_mps2=SWAY, wheel_spin_fl_radps=SWAY)
    values = one(run, SensorModel("accel_y", step=0.05, low=-0.6, high=0.9))
    np.testing.assert_allclose(values / 0.05, np.round(values / 0.05), atol=1e-9)
    assert values.min() == pytest.approx(-0.6)
    assert values.max() == pytest.approx(0.9)
    inside = (SWAY[::5] > -0.6) & (SWAY[::5] < 0.9)
    assert np.abs(values - SWAY[::5])[inside].max() <= 0.025 + 1e-9
    speed = one(run, SensorModel("wheel_speed_fl", noise=0.01, offset=0.2, zero_below=0.1))
    crawl = np.abs(SWAY[::5] * Fit().rolling_radius_front_m) < 0.1
    assert (speed[crawl] == 0).all()
    assert (speed[~crawl] != 0).all()


def test_low_pass_takes_amplitude_and_adds_phase_as_a_butterworth_does() -> None:
    t = times()
    for hz in (1.0, 10.0, 30.0):
        out = low_pass(np.sin(2 * np.pi * hz * t), 10.0, RATE)[5000:15000]
        wave = np.exp(2j * np.pi * hz * t[5000:15000])
        response = 2 * np.mean(out * wave.conj()) * 1j
        # the bilinear transform matches the analogue filter at the cut-off and warps beyond it
        s = 1j * np.tan(np.pi * hz / RATE) / np.tan(np.pi * 10 / RATE)
        assert response == pytest.approx(1 / (s * s + np.sqrt(2) * s + 1), abs=2e-3)
    np.testing.assert_allclose(low_pass(np.full(50, 9.81), 10.0, RATE), 9.81, rtol=1e-12)
    assert np.array_equal(low_pass(t, 230.0, RATE), t)


def test_kernels_equal_plain_python() -> None:
    rng = np.random.default_rng(0)
    x = rng.standard_normal(300)
    b, a = np.array([0.2, 0.3, 0.1]), np.array([1.0, -0.7, 0.3])
    y = [0.0] * len(x)
    settled = x[0] * b.sum() / a.sum()
    for i in range(len(x)):
        past = [(x[i - k] if i >= k else x[0], y[i - k] if i >= k else settled) for k in (1, 2)]
        y[i] = b[0] * x[i] + sum(b[k + 1] * p[0] - a[k + 1] * p[1] for k, p in enumerate(past))
    np.testing.assert_allclose(biquad(x, b, a), y, atol=1e-12)
    z = [x[0]]
    for value in x[1:]:
        z.append(0.9 * z[-1] + value)
    np.testing.assert_allclose(first_order(x, 0.9), z, atol=1e-12)


def test_wander_keeps_its_size_and_its_memory() -> None:
    paths = np.array([wander(2000, 2.0, 5.0, 0.01, np.random.default_rng(seed)) for seed in range(300)])
    assert paths[:, 0].std() == pytest.approx(2.0, rel=0.15)
    assert paths[:, -1].std() == pytest.approx(2.0, rel=0.15)
    after = np.mean(paths[:, 1000] * paths[:, 1500]) / np.mean(paths[:, 1000] ** 2)
    assert after == pytest.approx(np.exp(-1), abs=0.15)


def test_dropouts_leave_gaps_of_their_length_and_no_values() -> None:
    run = make_run(40.0, accel_y_mps2=SWAY)
    sensor = SensorModel("accel_y", dropouts_per_s=0.25, dropout_s=0.8)
    shares, spans = [], []
    for seed in range(40):
        values = one(run, sensor, seed=seed)
        gone = np.isnan(values)
        np.testing.assert_allclose(values[~gone], SWAY[::5][~gone], atol=1e-12)
        shares.append(gone.mean())
        spans.append(np.count_nonzero(np.diff(gone.astype(int)) == 1))
    # spans begin as a Poisson process and last exponentially: free for exp(-rate x mean)
    assert np.mean(shares) == pytest.approx(1 - np.exp(-0.2), abs=0.03)
    assert np.mean(spans) == pytest.approx(0.25 * 40 * np.exp(-0.2), rel=0.15)


def test_a_lost_message_takes_all_its_signals() -> None:
    unit = SensorUnit(
        "box", 100.0, (SensorModel("accel_x"), SensorModel("accel_y")), dropouts_per_s=0.5, dropout_s=0.5
    )
    log = apply(make_run(), SensorSet("test", "", (unit,)), np.random.default_rng(2))
    x, y = log.signals["accel_x"], log.signals["accel_y"]
    assert 0.05 < np.isnan(x).mean() < 0.5
    assert np.array_equal(np.isnan(x), np.isnan(y))


def test_outliers_have_their_share_and_size() -> None:
    values = one(make_run(), SensorModel("accel_y", outlier_share=0.02, outlier=10.0), rate_hz=500)
    wild = values[values != 0]
    assert len(wild) / len(values) == pytest.approx(0.02, rel=0.2)
    assert wild.std() == pytest.approx(10.0, rel=0.15)


def test_misalignment_is_a_rotation() -> None:
    t = times()
    run = make_run(
        accel_x_mps2=2 * np.sin(t),
        accel_y_mps2=SWAY,
        yaw_rate_radps=0.4 * np.cos(t),
        roll_rate_radps=0.1 * SWAY,
    )
    angles = (0.02, -0.03, 0.05)
    mount = Mount(CG[0], CG[1], CG[2], misalignment_rad=angles)
    names = ("accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch")
    unit = SensorUnit("imu", RATE, tuple(SensorModel(n) for n in names), mount)
    s = apply(run, SensorSet("test", "", (unit,)), np.random.default_rng(0)).signals
    sensed = np.stack([s["accel_x"], s["accel_y"], s["accel_z"]])
    c = run.columns
    true = np.stack([c["accel_x_mps2"], c["accel_y_mps2"], c["accel_z_mps2"]])
    np.testing.assert_allclose(np.linalg.norm(sensed, axis=0), np.linalg.norm(true, axis=0), rtol=1e-12)
    # small angles: a unit rolled right side down sees gravity on its left axis
    small = true - np.cross(np.array(angles)[:, None], true, axis=0)
    np.testing.assert_allclose(sensed, small, atol=0.03)
    np.testing.assert_allclose(rotation(*angles) @ sensed, true, atol=1e-12)
    # on level ground at rest the unit's own angles are those by which it is askew
    assert s["roll"][0] == pytest.approx(angles[0], abs=1e-12)
    assert s["pitch"][0] == pytest.approx(angles[1], abs=1e-12)
    assert s["roll_rate"][0] != pytest.approx(c["roll_rate_radps"][0], abs=1e-3)


def test_lever_arm_against_a_rigid_body_computation() -> None:
    """A point of a body that rolls and yaws: its place over time, differentiated twice, turned into the body's axes."""
    t = times(10.0)
    roll, yaw = 0.2 * np.sin(2 * np.pi * 0.8 * t), 0.5 * np.sin(2 * np.pi * 0.3 * t)
    roll_rate, yaw_rate = np.gradient(roll, t), np.gradient(yaw, t)
    # yaw about the vertical, then roll about the body's x: rates in body axes
    omega = np.stack([roll_rate, yaw_rate * np.sin(roll), yaw_rate * np.cos(roll)])
    alpha = np.gradient(omega, t, axis=1)
    run = make_run(
        10.0, roll_rate_radps=omega[0], pitch_rate_radps=omega[1], yaw_rate_radps=omega[2],
        roll_acceleration_radps2=alpha[0], pitch_acceleration_radps2=alpha[1], yaw_acceleration_radps2=alpha[2],
        roll_rad=roll, accel_x_mps2=np.zeros_like(t), accel_y_mps2=GRAVITY * np.sin(roll),
        accel_z_mps2=GRAVITY * np.cos(roll),
    )  # fmt: skip
    place = (0.4, -0.3, 1.6)
    arm = np.array([CG[0] - place[0], place[1] - CG[1], place[2] - CG[2]])
    turns = [rotation(r, 0.0, y) for r, y in zip(roll, yaw, strict=True)]
    path = np.stack([turn @ arm for turn in turns], axis=1)
    acceleration = np.gradient(np.gradient(path, t, axis=1), t, axis=1)
    acceleration[2] += GRAVITY
    expected = np.stack([turn.T @ a for turn, a in zip(turns, acceleration.T, strict=True)], axis=1)
    unit = SensorUnit("imu", RATE, tuple(SensorModel(f"accel_{a}") for a in "xyz"), Mount(*place))
    s = apply(run, SensorSet("test", "", (unit,)), np.random.default_rng(0)).signals
    inner = slice(10, -10)
    for row, axis in enumerate("xyz"):
        # two differences of 2 ms each are good to a few mm/s²
        np.testing.assert_allclose(s[f"accel_{axis}"][inner], expected[row][inner], atol=0.01)
    assert np.abs(expected[1] - run.columns["accel_y_mps2"]).max() > 1


def test_gyros_feel_no_acceleration() -> None:
    still, pushed = make_run(), make_run(accel_x_mps2=5 * SWAY)
    sensor = SensorModel("yaw_rate", noise=0.01)
    assert np.array_equal(one(still, sensor), one(pushed, sensor))


def test_sums_and_derived_signals() -> None:
    wheels = {
        f"tire_normal_force_{w}_n": np.full(20001, f)
        for w, f in zip(("fl", "fr", "rl", "rr"), (1.0, 2, 4, 8), strict=True)
    }
    brakes = {f"brake_torque_{w}_nm": np.full(20001, 10.0) for w in ("fl", "fr", "rl", "rr")}
    run = make_run(
        **wheels, **brakes, wheel_spin_rl_radps=np.full(20001, 30.0), x_m=times() * 20, speed_mps=np.full(20001, 20.0),
        road_grade_rad=np.full(20001, 0.1),
    )  # fmt: skip
    names = (
        "axle_load_front",
        "axle_load_rear",
        "brake_torque",
        "wheel_speed_rl",
        "longitude",
        "gps_speed_2d",
    )
    log = measured(run, *(SensorModel(n) for n in names)).signals
    assert (log["axle_load_front"] == 3).all()
    assert (log["axle_load_rear"] == 12).all()
    assert (log["brake_torque"] == 40).all()
    np.testing.assert_allclose(log["wheel_speed_rl"], 30 * Fit().rolling_radius_rear_m)
    np.testing.assert_allclose(log["gps_speed_2d"], 20 * np.cos(0.1))
    metres = np.radians(log["longitude"][-1] - log["longitude"][0]) * 6_371_000 * np.cos(np.radians(48.137))
    assert metres == pytest.approx(800, rel=0.005)


@pytest.mark.parametrize("name", SENSOR_SETS)
def test_every_set_measures_and_repeats(name: str) -> None:
    sensors = sensor_set(name)
    assert len(set(sensors.signals)) == len(sensors.signals)
    assert set(sensors.signals) <= set(SIGNALS)
    run = make_run(5.0)
    first = apply(run, sensors, np.random.default_rng(5))
    again = apply(run, sensors, np.random.default_rng(5))
    other = apply(run, sensors, np.random.default_rng(6))
    for signal, values in first.signals.items():
        assert np.array_equal(values, again.signals[signal], equal_nan=True)
    same = [np.array_equal(values, other.signals[s], equal_nan=True) for s, values in first.signals.items()]
    assert all(same) == (name == "perfect")
    assert set(first.drawn) == set(sensors.signals)


def test_everything_is_every_signal_and_perfect_is_the_truth() -> None:
    assert set(sensor_set("everything").signals) == set(SIGNALS) == set(sensor_set("perfect").signals)
    run = make_run(5.0, accel_y_mps2=SWAY[:2501])
    log = apply(run, sensor_set("perfect", Mount(*CG)), np.random.default_rng(0)).signals
    np.testing.assert_allclose(log["accel_y"], SWAY[:2501:5], atol=1e-12)
    assert all(np.isfinite(values).all() for values in log.values())


def test_errors_scale_and_other_sensors_do_not_change_the_noise() -> None:
    run = make_run(5.0)
    sensor = SensorModel("accel_y", noise=0.05, offset_std=0.1)
    whole = one(run, sensor)
    np.testing.assert_allclose(one(run, sensor.scaled(0.5)), 0.5 * whole, atol=1e-12)
    assert (one(run, sensor.scaled(0)) == 0).all()
    beside = measured(run, SensorModel("accel_x", noise=1.0), sensor).signals["accel_y"]
    assert np.array_equal(beside, whole)
    none = sensor_set("production").scaled(0)
    assert {u.mount.misalignment_std_rad for u in none.units if u.mount} == {0.0}
    spoiled = sensor_set("production").spoiled(0.1, 0.01)
    log = apply(make_run(20.0), spoiled, np.random.default_rng(0)).signals
    assert 0.005 < np.isnan(log["accel_y"]).mean() < 0.3
    assert np.nanmax(np.abs(log["accel_y"])) > 5


def test_one_rate_for_all() -> None:
    log = apply(make_run(2.0), sensor_set("everything").at_rate(20.0), np.random.default_rng(0))
    assert {group.rate_hz for group in log.groups} == {20.0}
    assert {len(values) for values in log.signals.values()} == {41}


def test_wrong_names_are_told() -> None:
    with pytest.raises(SettingsError, match="did you mean 'deflection'"):
        sensor_set("deflections")
    with pytest.raises(ValueError, match="no signal 'acel_y'"):
        one(make_run(1.0), SensorModel("acel_y"))
    unit = SensorUnit("box", 0.0, (SensorModel("accel_y"),))
    with pytest.raises(ValueError, match="'box' is 0 Hz"):
        apply(make_run(1.0), SensorSet("test", "", (unit,)), np.random.default_rng(0))


def test_the_rate_of_a_unit_can_be_changed_alone() -> None:
    sensors = sensor_set("ins")
    units = tuple(replace(u, rate_hz=25.0) if u.name == "ins" else u for u in sensors.units)
    log = apply(make_run(4.0), replace(sensors, units=units), np.random.default_rng(0))
    assert {g.name: len(g.time_ns) for g in log.groups}["ins"] == 101
    assert {g.name: len(g.time_ns) for g in log.groups}["gps"] == 41
