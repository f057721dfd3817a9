"""A simulated drive with known truth: standstill, slalom, sine with dwell, braking.

Richer than the roll estimator's model: unsprung mass, tyres in series with the suspension, a stiffening spring, an
IMU off the roll axis, sensor noise, offsets and a mounting angle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.jit import kernel
from parsers.signals import WHEELS
from pipelines.results import FloatArray

G = 9.80665
STEPS = 20
"""Integration steps a sample."""


@dataclass(frozen=True)
class RollVehicle:
    """The simulated vehicle as loaded: SI. roll_stiffness is the suspension's, without tyres; sprung_roll_inertia is
    that of the sprung mass about its own CG."""

    mass_kg: float = 1850.0
    unsprung_mass_kg: float = 190.0
    unsprung_height_m: float = 0.34
    sprung_cg_height_m: float = 0.735
    roll_axis_height_m: float = 0.11
    sprung_roll_inertia_kgm2: float = 600.0
    roll_stiffness_nmprad: float = 95_000.0
    stiffening: float = 2.0
    roll_damping_nmsprad: float = 8_060.0
    rebound_ratio: float = 1.0
    tire_vertical_rate_npm: float = 250_000.0
    track_m: float = 1.60
    wheelbase_m: float = 2.78
    cg_to_front_axle_m: float = 1.31
    steering_ratio: float = 16.0
    understeer_radps2pm: float = 0.0024
    imu_above_ground_m: float = 0.62

    @property
    def sprung_mass_kg(self) -> float:
        """Mass that rolls."""
        return self.mass_kg - self.unsprung_mass_kg

    @property
    def cg_height_m(self) -> float:
        """CG height of the whole vehicle."""
        moment = (
            self.sprung_mass_kg * self.sprung_cg_height_m + self.unsprung_mass_kg * self.unsprung_height_m
        )
        return moment / self.mass_kg

    @property
    def roll_arm_m(self) -> float:
        """Height of the sprung CG above the roll axis."""
        return self.sprung_cg_height_m - self.roll_axis_height_m

    @property
    def tire_roll_stiffness_nmprad(self) -> float:
        """Roll stiffness of the four tyres: 2 axles of k t² / 2."""
        return self.tire_vertical_rate_npm * self.track_m**2

    @property
    def roll_inertia_kgm2(self) -> float:
        """Roll inertia of the whole vehicle about its CG, as on data sheets: the unsprung mass sits at half the track."""
        height = self.cg_height_m
        body = self.sprung_roll_inertia_kgm2 + self.sprung_mass_kg * (self.sprung_cg_height_m - height) ** 2
        hubs = self.unsprung_mass_kg * ((self.track_m / 2) ** 2 + (self.unsprung_height_m - height) ** 2)
        return body + hubs

    @property
    def road_stiffness_nmprad(self) -> float:
        """Suspension and tyres in series, as this plant has them (no mass rolls between the two)."""
        soft, hard = self.roll_stiffness_nmprad, self.tire_roll_stiffness_nmprad
        return soft * hard / (soft + hard)

    @property
    def roll_gradient_degpg(self) -> float:
        """Steady roll against the horizon per g of sensed lateral acceleration, small angles, tyres included."""
        return float(np.degrees(G * self.sprung_mass_kg * self.roll_arm_m / self.road_stiffness_nmprad))

    @property
    def roll_natural_frequency_hz(self) -> float:
        """sqrt(K/J)/2π of small motions on springs and tyres, J about the roll axis, without gravity's part."""
        about_axis = self.sprung_roll_inertia_kgm2 + self.sprung_mass_kg * self.roll_arm_m**2
        return float(np.sqrt(self.road_stiffness_nmprad / about_axis) / (2 * np.pi))


@dataclass(frozen=True)
class SensorErrors:
    """What the sensors add: standard deviations of white noise, and constant offsets, by signal (SI)."""

    noise: dict[str, float] = field(
        default_factory=lambda: {
            "accel_x": 0.04, "accel_y": 0.04, "accel_z": 0.06, "roll_rate": 0.003, "pitch_rate": 0.003, "yaw_rate": 0.003,
            "roll": 0.0008, "pitch": 0.0008, "speed": 0.02, "steering_wheel_angle": 0.003, "suspension_deflection": 0.0003,
        }
    )  # fmt: skip
    offset: dict[str, float] = field(
        default_factory=lambda: {"accel_y": 0.06, "roll_rate": 0.004, "yaw_rate": -0.002, "roll": 0.006}
    )


@dataclass(frozen=True)
class SimulatedDrive:
    """time_s (n,), signals name -> (n,) as the sensors give them, truth by parameter name."""

    time_s: FloatArray
    signals: dict[str, FloatArray]
    truth: dict[str, float]


def steering(time_s: FloatArray) -> FloatArray:
    """Steering-wheel angle [rad] over 32 s: slalom from 6 s, sine with dwell (0.7 Hz, 500 ms) at 16 s and 21 s."""
    t = np.asarray(time_s)
    angle = np.zeros_like(t)
    slalom = (t >= 6) & (t < 15)
    # a sweep from 0.25 to 0.7 Hz, eased in and out
    sweep = np.sin(2 * np.pi * (0.25 * (t - 6) + 0.025 * (t - 6) ** 2))
    angle += np.where(slalom, 0.55 * sweep * np.sin(np.pi * np.clip((t - 6) / 9, 0, 1)) ** 0.5, 0.0)
    for start, amplitude in ((16.0, 1.15), (21.0, -1.35)):
        x = t - start
        quarter = 0.75 / 0.7
        rise = (x >= 0) & (x < quarter)
        dwell = (x >= quarter) & (x < quarter + 0.5)
        end = (x >= quarter + 0.5) & (x < 1 / 0.7 + 0.5)
        angle += amplitude * np.where(rise, np.sin(2 * np.pi * 0.7 * x), 0.0)
        angle += amplitude * np.where(dwell, -1.0, 0.0)
        angle += amplitude * np.where(end, np.sin(2 * np.pi * 0.7 * (x - 0.5)), 0.0)
    return angle


def speed_profile(time_s: FloatArray) -> FloatArray:
    """Speed [m/s]: stands for 2 s, reaches 17 m/s by 6 s, brakes to a stop from 26 s to 30 s."""
    t = np.asarray(time_s)
    up = 17 * 0.5 * (1 - np.cos(np.pi * np.clip((t - 2) / 4, 0, 1)))
    down = 0.5 * (1 + np.cos(np.pi * np.clip((t - 26) / 4, 0, 1)))
    return np.asarray(up * down)


@kernel
def _integrate(lateral: FloatArray, dt: float, p: FloatArray) -> FloatArray:
    """Roll of the body over fine steps (semi-implicit Euler). lateral: (n,) acceleration at the roll axis.

    p: sprung mass times arm, inertia about the roll axis, suspension stiffness, cubic share, damping, rebound ratio,
    tyre stiffness. Returns (n, 4): body roll, its rate, its acceleration, suspension roll.
    """
    mh, inertia, stiffness, cubic, damping, rebound, tire = p
    out = np.empty((len(lateral), 4))
    roll, rate, suspension = 0.0, 0.0, 0.0
    for i in range(len(lateral)):
        spring = stiffness * suspension * (1 + cubic * suspension * suspension)
        through = tire * (roll - suspension)
        force = through - spring
        slope = damping * (rebound if force * suspension < 0 else 1.0)
        suspension += dt * force / slope
        moment = mh * (lateral[i] * np.cos(roll) + 9.80665 * np.sin(roll))
        acceleration = (moment - through) / inertia
        rate += dt * acceleration
        roll += dt * rate
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = roll, rate, acceleration, suspension
    return out


def _lateral(vehicle: RollVehicle, time_s: FloatArray, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Yaw rate and lateral acceleration at the roll axis: a steady bicycle behind a short lag."""
    road_wheel = steering(time_s - 0.08) / vehicle.steering_ratio
    yaw = (
        speed
        * road_wheel
        / (vehicle.wheelbase_m + vehicle.understeer_radps2pm * speed**2 * vehicle.wheelbase_m)
    )
    width = max(int(0.12 / (time_s[1] - time_s[0])), 1)
    window = np.hanning(width + 2)[1:-1]
    yaw = np.convolve(yaw, window / window.sum(), mode="same")
    limit = 8.0
    accel = limit * np.tanh(speed * yaw / limit)
    return np.divide(accel, np.maximum(speed, 0.5)), accel


def _kernel_figures(vehicle: RollVehicle) -> FloatArray:
    """The vehicle as `_integrate` takes it."""
    arm = vehicle.roll_arm_m
    mh = vehicle.sprung_mass_kg * arm
    return np.array(
        [
            mh,
            vehicle.sprung_roll_inertia_kgm2 + mh * arm,
            vehicle.roll_stiffness_nmprad,
            vehicle.stiffening,
            vehicle.roll_damping_nmsprad,
            vehicle.rebound_ratio,
            vehicle.tire_roll_stiffness_nmprad,
        ]
    )


def _motion(vehicle: RollVehicle, rate_hz: float, n: int) -> dict[str, FloatArray]:
    """What perfect sensors would read, name -> (n,)."""
    dt = 1 / rate_hz / STEPS
    fine = np.asarray(np.arange(n * STEPS) * dt, dtype=np.float64)
    speed = speed_profile(fine)
    yaw, lateral = _lateral(vehicle, fine, speed)
    state = _integrate(lateral, dt, _kernel_figures(vehicle))
    pick = slice(0, None, STEPS)
    roll, rate, acceleration, suspension = (state[pick, k] for k in range(4))
    forward = np.gradient(speed, dt)[pick]
    pitch = 0.006 * -forward
    above = vehicle.imu_above_ground_m - vehicle.roll_axis_height_m
    clean = {
        "accel_x": forward - G * np.sin(pitch),
        "accel_y": lateral[pick] * np.cos(roll) + G * np.sin(roll) - above * acceleration,
        "accel_z": G * np.cos(roll) * np.cos(pitch) - lateral[pick] * np.sin(roll),
        "roll_rate": rate,
        "pitch_rate": np.gradient(pitch, 1 / rate_hz),
        "yaw_rate": yaw[pick],
        "roll": roll,
        "pitch": pitch,
        "speed": speed[pick],
        "steering_wheel_angle": steering(fine[pick]),
    }
    side = {"fl": -1.0, "fr": 1.0, "rl": -1.0, "rr": 1.0}
    for w in WHEELS:
        clean[f"suspension_deflection_{w}"] = side[w] * suspension * vehicle.track_m / 2
    return clean


def _sensed(
    clean: dict[str, FloatArray], errors: SensorErrors, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """The same with the sensors' noise and offsets."""
    signals = {}
    for name, values in clean.items():
        kind = "suspension_deflection" if name.startswith("suspension_deflection") else name
        noise = errors.noise.get(kind, 0.0) * rng.standard_normal(len(values))
        signals[name] = values + noise + errors.offset.get(kind, 0.0)
    # a wheel-speed based speed reads zero at rest
    signals["speed"] = np.where(clean["speed"] < 0.05, 0.0, signals["speed"])
    return signals


def simulate_roll_drive(
    rng: np.random.Generator,
    vehicle: RollVehicle | None = None,
    errors: SensorErrors | None = None,
    rate_hz: float = 40.0,
    duration_s: float = 32.0,
) -> SimulatedDrive:
    """Simulate the drive. rate_hz: of all signals; rng: the sensors' noise."""
    vehicle, errors = vehicle or RollVehicle(), errors or SensorErrors()
    n = round(duration_s * rate_hz)
    signals = _sensed(_motion(vehicle, rate_hz, n), errors, rng)
    truth = {
        "cg_height_m": vehicle.cg_height_m,
        "mass_kg": vehicle.mass_kg,
        "sprung_mass_kg": vehicle.sprung_mass_kg,
        "sprung_cg_height_m": vehicle.sprung_cg_height_m,
        "roll_arm_m": vehicle.roll_arm_m,
        "roll_stiffness_nmprad": vehicle.roll_stiffness_nmprad,
        "roll_inertia_kgm2": vehicle.roll_inertia_kgm2,
        "roll_gradient_degpg": vehicle.roll_gradient_degpg,
        "roll_natural_frequency_hz": vehicle.roll_natural_frequency_hz,
        "cg_to_front_axle_m": vehicle.cg_to_front_axle_m,
    }
    return SimulatedDrive(np.arange(n) / rate_hz, signals, truth)
