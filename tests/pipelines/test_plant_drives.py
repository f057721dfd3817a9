"""The plant driven: load transfer, steps, understeer, standstill, friction, lift-off, the driver, and wrong inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_plant import clock, demand, sine_with_dwell

from benchmarks.vehicle_data import paths
from parsers.signals import WHEELS
from pipelines.simulation.loads import Load
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.records import GRAVITY, RUN_COLUMNS, Demand, Road, straight_road

SUV = PRESETS["suv"]
FREE = straight_road(800)


def _axle(run_columns: dict[str, np.ndarray], name: str, unit: str) -> np.ndarray:
    """(4, n) of a wheel's columns."""
    return np.array([run_columns[f"{name}_{w}_{unit}"] for w in WHEELS])


def test_every_column_is_there_and_finite() -> None:
    run = simulate(SUV, demand(2.0, speed=10.0), FREE, rate_hz=50)
    assert tuple(run.columns) == RUN_COLUMNS
    assert len(run.time_s) == 101
    assert all(values.shape == (101,) and np.isfinite(values).all() for values in run.columns.values())
    assert run.columns["speed_mps"] == pytest.approx(10.0, abs=0.05)


@pytest.mark.parametrize("loads", [(), (Load(150, 1.8, 0.0, 1.9),)])
def test_cornering_load_transfer_closes(loads: tuple[Load, ...]) -> None:
    """Moments about the ground line: normal forces times their arms equal m a h, the body's shift included."""
    vehicle = replace(SUV, camber_stiffness_prad=0.0, friction_n=0.0)
    run = simulate(vehicle, demand(12.0, steer=1.0, speed=15.0), FREE, loads=loads)
    c, known = {k: v[-1] for k, v in run.columns.items()}, run.truth
    normal, lateral = _axle(c, "tire_normal_force", "n"), _axle(c, "tire_lateral_force", "n")
    steer, long = _axle(c, "wheel_steer", "rad"), _axle(c, "tire_longitudinal_force", "n")
    across = float((lateral * np.cos(steer) + long * np.sin(steer)).sum())
    assert across / known["mass_kg"] > 3.5
    tracks = np.array([vehicle.track_front_m] * 2 + [vehicle.track_rear_m] * 2)
    transfer = float((normal * np.array([-1, 1, -1, 1]) * tracks / 2).sum())
    lean = c["roll_against_road_rad"]
    # the sprung CG swings out about the roll axis, which the tyres tilt about the ground; the hubs as their camber lets them
    squash = normal / 250_000
    tilt = float((squash * np.array([-1, 1, -1, 1]) / tracks).sum()) / 2
    arm, height, axis = known["roll_arm_m"], known["cg_height_m"], known["roll_center_height_m"]
    shift = known["sprung_mass_kg"] * (arm * lean + axis * tilt) + 190 * 0.34 * (0.4 * lean + 0.6 * tilt)
    height += c["heave_m"] * known["sprung_mass_kg"] / known["mass_kg"]
    # at rest it stands off the middle
    rest = known["mass_kg"] * known["cg_lateral_offset_m"] * GRAVITY
    gyro = float((np.array([1.5] * 4) / 0.345).sum()) * across / known["mass_kg"]
    assert transfer == pytest.approx(across * height + shift * GRAVITY - rest + gyro, rel=0.005)
    assert normal.sum() == pytest.approx(known["mass_kg"] * GRAVITY, rel=1e-3)


def test_braking_load_transfer_closes() -> None:
    """Front axle's gain: sum of longitudinal forces times height, drag at the sprung CG, wheel spin, pitched body."""
    vehicle = replace(SUV, rolling_resistance=0.0)
    t = clock(5.0)
    drive = demand(5.0, speed=np.where(t < 1, 28.0, np.nan), brake=np.where(t >= 1, 3.5e6, 0.0))
    run = simulate(vehicle, drive, FREE)
    at = 350
    c, known = {k: v[at] for k, v in run.columns.items()}, run.truth
    normal, long = _axle(c, "tire_normal_force", "n"), _axle(c, "tire_longitudinal_force", "n")
    assert c["accel_x_mps2"] < -3.5
    drag = 0.6 * 0.85 * c["speed_mps"] ** 2
    slowing = (float(long.sum()) - drag) / known["mass_kg"]
    moment = -float(long.sum()) * known["cg_height_m"]
    moment += drag * (known["sprung_cg_height_m"] - known["cg_height_m"])
    moment -= 4 * 1.5 / 0.352 * slowing
    # braked tyres' patches lag behind the axles, and the loads with them
    squash = normal / 250_000
    moment -= float(np.sum(long * squash * 2 / 3))
    # the body pitches over wheels that stay under their hubs, along the links' slopes, and heaves: its CG goes forward and down
    path, pitch = paths(vehicle)["patch_path_pitch_mprad"][0], c["pitch_against_road_rad"]
    arm = known["sprung_cg_height_m"] - path
    moment += known["sprung_mass_kg"] * (GRAVITY * arm * pitch + c["heave_m"] * -slowing)
    front = known["mass_kg"] * (1 - known["cg_to_front_axle_m"] / vehicle.wheelbase_m) * GRAVITY
    assert normal[:2].sum() - front == pytest.approx(moment / vehicle.wheelbase_m, rel=0.015)


def test_links_carry_their_part_of_braking_and_driving() -> None:
    """Steadily braked or driven, spring and tyre differ by the longitudinal force times the slope of the wheel's path."""
    t = clock(5.0)
    vehicle = replace(SUV, friction_n=0.0)
    cases = (
        (
            demand(5.0, speed=np.where(t < 1, 28.0, np.nan), brake=np.where(t >= 1, 4e6, 0.0)),
            "side_slope",
            -1,
        ),
        (
            demand(5.0, speed=np.where(t < 1, 8.0, np.nan), torque=np.where(t >= 1, 2500.0, 0.0)),
            "side_slope_drive",
            1,
        ),
    )
    for drive, name, sign in cases:
        c = {k: v[300] for k, v in simulate(vehicle, drive, FREE).columns.items()}
        assert c["accel_x_mps2"] * sign > 2.5
        slopes = np.repeat([getattr(vehicle, f"{name}_{axle}") for axle in ("front", "rear")], 2)
        unsprung = np.array([48.0, 48.0, 47.0, 47.0]) * GRAVITY
        force, normal = _axle(c, "suspension_force", "n"), _axle(c, "tire_normal_force", "n")
        long = _axle(c, "tire_longitudinal_force", "n")
        # the guides pitch with the body
        pushing = normal + long * c["pitch_against_road_rad"] - unsprung
        carried = long * slopes
        assert force - pushing == pytest.approx(carried, abs=0.1 * np.abs(carried).max())


@pytest.mark.parametrize("kind", ["dwell", "braking"])
def test_half_the_step_changes_roll_by_less_than_a_thousandth(kind: str) -> None:
    t = clock(6.0)
    drive = sine_with_dwell(2.0, 22.2)
    if kind == "braking":
        drive = demand(6.0, speed=np.where(t < 1, 20.0, np.nan), brake=np.where(t >= 1, 4e6, 0.0), steer=0.2)
    # to here the vehicle still moves: what rocks after a stop is not what this is about
    coarse, fine = (simulate(SUV, drive, FREE, step_s=h).columns for h in (0.001, 0.0005))
    for name in ("roll_rad", "pitch_rad", "accel_y_mps2", "tire_normal_force_fl_n"):
        change = np.abs(coarse[name] - fine[name]).max()
        assert change < 1e-3 * np.abs(fine[name] - fine[name][0]).max()


def test_understeer_needs_more_steer_the_faster() -> None:
    gains = []
    for speed in (8.0, 25.0):
        c = simulate(SUV, demand(6.0, steer=0.1, speed=speed), FREE).columns
        curvature = c["yaw_rate_radps"][-1] / c["speed_mps"][-1]
        gains.append((0.1 / SUV.steering_ratio - SUV.wheelbase_m * curvature) / c["accel_y_mps2"][-1])
    assert all(gain > 0.001 for gain in gains)
    assert gains[1] == pytest.approx(SUV.understeer_radps2pm, rel=0.4)


def test_signs_are_iso_8855() -> None:
    c = simulate(SUV, demand(4.0, steer=0.5, speed=15.0), FREE).columns
    assert c["accel_y_mps2"][-1] > 1
    assert c["yaw_rate_radps"][-1] > 0
    assert c["roll_rad"][-1] > 0
    assert c["suspension_deflection_fr_m"][-1] > 0 > c["suspension_deflection_fl_m"][-1]
    braked = simulate(SUV, demand(2.0, speed=20.0 - 4 * clock(2.0)), FREE).columns
    assert braked["accel_x_mps2"][-1] < -3
    assert braked["pitch_rad"][-1] > 0.01


def test_straight_line_stays_straight() -> None:
    vehicle = replace(SUV, sprung_cg_left_m=0.0)
    c = simulate(vehicle, demand(10.0, speed=5.0 + 2 * clock(10.0)), FREE).columns
    for name in ("y_m", "roll_rad", "yaw_rate_radps", "accel_y_mps2"):
        assert np.abs(c[name]).max() < 1e-9


@pytest.mark.parametrize("grade", [0.0, 0.12, -0.12])
def test_stands_still_without_creeping(grade: float) -> None:
    road = replace(straight_road(100), grade_rad=np.full(102, grade), bank_rad=np.full(102, 0.03))
    c = simulate(SUV, demand(30.0), road).columns
    assert np.abs(c["distance_m"]).max() < 2e-3
    assert np.abs(c["y_m"]).max() < 2e-3
    assert np.abs(c["velocity_x_mps"][1000:]).max() < 1e-5
    for wheel in WHEELS:
        assert np.abs(c[f"wheel_spin_{wheel}_radps"]).max() < 1e-4
    # sensed at rest: gravity alone
    assert np.hypot(np.hypot(c["accel_x_mps2"], c["accel_y_mps2"]), c["accel_z_mps2"])[-1] == pytest.approx(
        GRAVITY, abs=1e-3
    )
    assert c["pitch_rad"][-1] == pytest.approx(-grade, abs=0.02)
    assert c["roll_rad"][-1] == pytest.approx(0.03, abs=0.02)


@pytest.mark.parametrize("name", list(PRESETS))
def test_starts_on_a_hill_follows_its_speed_and_stops(name: str) -> None:
    t = clock(25.0)
    target = np.interp(t, [2, 10, 15, 20], [0, 9, 9, 0])
    road = replace(straight_road(300), grade_rad=np.full(302, 0.06))
    c = simulate(PRESETS[name], demand(25.0, speed=target), road).columns
    assert c["velocity_x_mps"].min() > -0.15
    assert np.abs(c["velocity_x_mps"] - target).max() < 0.8
    assert np.abs(c["velocity_x_mps"][-100:]).max() < 0.01


def test_follows_a_road_and_sees_it_with_every_wheel() -> None:
    s = np.arange(0, 400, 0.5)
    bend = np.where((s > 60) & (s < 160), 0.02, 0.0)
    bump = np.where((s >= 20) & (s <= 20.5), 0.01, 0.0)
    zero, grip = np.zeros(len(s)), np.full(len(s), 0.9)
    road = Road(0.5, np.convolve(bend, np.ones(20) / 20, "same"), zero, zero, bump, zero, grip, grip)
    c = simulate(SUV, demand(30.0, speed=10.0), road, rate_hz=200).columns
    assert c["heading_rad"][-1] == pytest.approx(2.0, abs=0.02)
    front, rear = (c["distance_m"][np.argmax(c[f"road_{w}_m"])] for w in ("fl", "rl"))
    assert rear - front == pytest.approx(SUV.wheelbase_m, abs=0.06)
    assert np.abs(c["road_fr_m"]).max() == 0
    assert np.ptp(c["tire_normal_force_fl_n"]) > 2 * np.ptp(c["tire_normal_force_fr_n"]) / 3


def test_gradual_grade_presses_into_the_dip() -> None:
    """A road that bends upward lifts the vehicle: v² times its curvature on top of gravity."""
    s = np.arange(0, 302.0)
    grade = np.interp(s, [0, 60, 160, 301], [0, 0, 0.1, 0.1])
    road = replace(straight_road(300), grade_rad=grade)
    c = simulate(SUV, demand(10.0, speed=15.0), road).columns
    inside = (c["distance_m"] > 90) & (c["distance_m"] < 140)
    lift = c["accel_z_mps2"] - GRAVITY * np.cos(c["pitch_rad"]) * np.cos(c["roll_rad"])
    assert lift[inside].mean() == pytest.approx(15.0**2 * 0.1 / 100, rel=0.05)


def test_dry_friction_holds_either_way() -> None:
    """Pushed down and pulled up slowly through the same deflection, the forces differ by twice the friction."""
    t = clock(24.0)
    wave = 0.02 * np.sin(2 * np.pi * t / 12)
    vehicle = replace(
        SUV, friction_n=200.0, spring_stiffening_pm2=0.0,
        **{f"damper_{w}_{a}_nspm": 1.0 for w in ("compression", "extension") for a in ("front", "rear")},
    )  # fmt: skip
    # a steering wave slow enough to be quasi-static
    c = simulate(vehicle, demand(24.0, steer=40 * wave, speed=12.0), FREE).columns
    d, v, force = (
        c[f"suspension_{n}_fl_{u}"] for n, u in (("deflection", "m"), ("velocity", "mps"), ("force", "n"))
    )
    spring = 29_000 * d + 25_000 / 1.6**2 * (d - c["suspension_deflection_fr_m"])
    dry = force - vehicle.preloads_n[0] - spring
    moving = np.abs(v) > 0.3 * np.abs(v).max()
    late = t > 12
    down, up = dry[moving & late & (v > 0)], dry[moving & late & (v < 0)]
    assert np.median(down) - np.median(up) == pytest.approx(400, rel=0.1)
    assert np.median(down) == pytest.approx(200, abs=25)


def test_tall_and_hard_driven_lifts_wheels_and_lives_or_falls() -> None:
    tall = Load(500.0, 1.6, 0.0, 2.6)
    run = simulate(PRESETS["van"], sine_with_dwell(3.5, 25.0, 5.0), straight_road(300, 1.1), loads=[tall])
    c = run.columns
    lifted = min(c[f"tire_normal_force_{w}_n"].min() for w in WHEELS)
    assert lifted == 0
    assert all(np.isfinite(values).all() for values in c.values())
    fallen = len(run.time_s) < 501
    assert np.abs(c["roll_against_road_rad"]).max() > (1.0 if fallen else 0.1)


def test_hard_braking_on_ice_keeps_the_wheels_turning_until_the_stop() -> None:
    t = clock(12.0)
    drive = demand(12.0, speed=np.where(t < 1, 10.0, np.nan), brake=np.where(t >= 1, 6e6, 0.0))
    c = simulate(SUV, drive, straight_road(200, 0.2)).columns
    fast = c["speed_mps"] > 3
    assert min(c[f"wheel_spin_{w}_radps"][fast].min() for w in WHEELS) > 1
    assert -2.0 < c["accel_x_mps2"][fast].min() < -1.2
    assert np.abs(c["velocity_x_mps"][-1]) < 0.01


def _broken(**change: object) -> Demand:
    return replace(demand(2.0), **change)  # type: ignore[arg-type]


def test_wrong_inputs_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"demand\.brake_pressure_pa"):
        simulate(SUV, _broken(brake_pressure_pa=np.zeros(5)), FREE)
    with pytest.raises(ValueError, match=r"demand\.steering_wheel_angle_rad"):
        simulate(SUV, _broken(steering_wheel_angle_rad=np.full(201, np.nan)), FREE)
    with pytest.raises(ValueError, match=r"demand\.step_s"):
        simulate(SUV, _broken(step_s=0.0), FREE)
    with pytest.raises(ValueError, match=r"road\.left_m"):
        simulate(SUV, demand(2.0), replace(FREE, left_m=np.full(802, np.inf)))
    with pytest.raises(ValueError, match=r"road\.friction_left"):
        simulate(SUV, demand(2.0), replace(FREE, friction_left=np.full(802, -0.1)))
    with pytest.raises(ValueError, match="step_s"):
        simulate(SUV, demand(2.0), FREE, step_s=0.0)
    with pytest.raises(ValueError, match="rate_hz"):
        simulate(SUV, demand(2.0), FREE, rate_hz=float("nan"))


@pytest.mark.parametrize("name", list(PRESETS))
def test_rough_handling_stays_finite_and_bounded(name: str) -> None:
    """Hard steering, braking and driving by foot over rough ground with a different grip on each side."""
    rng = np.random.default_rng(11)
    t, s = clock(12.0), np.arange(0, 500, 0.1)
    rough = np.cumsum(rng.standard_normal((2, len(s))), axis=1)
    rough = 0.03 * (rough - np.linspace(0, 1, len(s)) * rough[:, -1:]) / rough.std(axis=1, keepdims=True)
    grip = np.full(len(s), 1.0)
    wave = np.sin(s / 40)
    road = Road(0.1, 0.01 * wave, 0.1 * wave, 0.05 * wave, rough[0], rough[1], 0.3 * grip, grip)
    drive = demand(
        12.0, steer=2 * np.sin(3 * t), speed=np.where(t < 6, 18.0, np.nan),
        brake=np.where((t > 7) & (t < 9), 1e7, 0.0), torque=np.where(t > 9, 20_000.0, 0.0),
    )  # fmt: skip
    c = simulate(PRESETS[name], drive, road).columns
    assert all(np.isfinite(values).all() for values in c.values())
    assert np.abs(c["accel_z_mps2"]).max() < 60
    assert max(np.abs(c[f"wheel_spin_{w}_radps"]).max() for w in WHEELS) < 200


def test_no_power_comes_from_nowhere() -> None:
    """What the driven wheels give the vehicle is what the torque puts in, less what slip eats and the wheels' spin holds."""
    vehicle = replace(SUV, rolling_resistance=0.0)
    t = clock(6.0)
    drive = demand(6.0, speed=np.where(t < 1, 10.0, np.nan), torque=np.where(t < 1, 0.0, 1800.0))
    run = simulate(vehicle, drive, FREE)
    c = run.columns
    steady = slice(200, 550)
    put_in, taken, held = np.zeros(350), np.zeros(350), np.zeros(350)
    for wheel in WHEELS:
        spin = c[f"wheel_spin_{wheel}_radps"]
        put_in += (c[f"drive_torque_{wheel}_nm"] * spin)[steady]
        taken += (c[f"tire_longitudinal_force_{wheel}_n"] * c["velocity_x_mps"])[steady]
        held += np.gradient(0.5 * 1.5 * spin**2, 1 / run.rate_hz)[steady]
    lost = (put_in - held - taken) / put_in
    assert np.all(lost > 0)
    assert np.all(lost < 0.03)
