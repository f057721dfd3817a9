"""A car in roll that is richer than any estimator's model: the judge of the roll estimators.

Body and axles roll apart (tyres under the axles, both with damping), springs stiffen with the cube of the angle,
dampers have two slopes, the road banks, the accelerometer sits off the roll axis, sensors have coloured noise,
offsets, a delay and steps of quantisation. Integrated with Runge-Kutta at 500 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from parsers.drive import Drive, ImportRecord, Signal
from parsers.jit import kernel
from pipelines.vehicles.vehicle import Quantity, Vehicle

Array = NDArray[np.float64]
G = 9.80665
RATE = 500.0


@dataclass(frozen=True)
class Car:
    """sprung: the body. heights above ground in m, stiffness and damping of the suspension in roll."""

    sprung_kg: float = 1640.0
    unsprung_kg: float = 160.0
    sprung_height: float = 0.70
    hub_height: float = 0.33
    roll_axis: float = 0.09
    body_inertia: float = 480.0
    axle_inertia: float = 85.0
    stiffness: float = 68_000.0
    damping: float = 5_600.0
    cubic: float = 0.0
    rebound: float = 1.0
    tyre_npm: float = 230_000.0
    track: float = 1.58
    imu_height: float = 0.45

    @property
    def mass(self) -> float:
        return self.sprung_kg + self.unsprung_kg

    @property
    def cg_height(self) -> float:
        return (self.sprung_kg * self.sprung_height + self.unsprung_kg * self.hub_height) / self.mass

    @property
    def arm(self) -> float:
        return self.sprung_height - self.roll_axis

    @property
    def roll_inertia(self) -> float:
        """Of the whole vehicle about its CG."""
        body = self.body_inertia + self.sprung_kg * (self.sprung_height - self.cg_height) ** 2
        hubs = self.unsprung_kg * ((self.track / 2) ** 2 + (self.hub_height - self.cg_height) ** 2)
        return body + hubs

    @property
    def tyre_roll(self) -> float:
        return self.tyre_npm * self.track**2

    def gradient(self, *, road: bool) -> float:
        """deg per sensed g of the small-angle static balance, worked out on its own here."""
        suspension = self.sprung_kg * self.arm / self.stiffness
        tyres = self.mass * self.cg_height / self.tyre_roll
        return float(np.degrees(G * (suspension + (tyres if road else 0.0))))


@dataclass(frozen=True)
class Sensors:
    """Noise (standard deviation at 100 Hz), colour (s, 0 = white), offsets, delay of the angle, and steps."""

    accel_noise: float = 0.1
    roll_noise: float = np.radians(0.1)
    rate_noise: float = np.radians(0.3)
    colour_s: float = 0.0
    accel_offset: float = 0.08
    roll_offset: float = np.radians(0.7)
    rate_offset: float = np.radians(0.36)
    roll_delay: float = 0.0
    rate_delay: float = 0.0
    roll_step: float = 0.0
    accel_step: float = 0.0


@kernel
def _simulate(accel: Array, bank: Array, p: Array, out: Array) -> None:
    """out (n, 6): body roll, axle roll, their rates, their accelerations. p: see `simulate`."""
    ms, mu, arm, axis, hub, inertia, axle, k, d, cubic, rebound, kt, dt_ = p
    step = 1.0 / 500.0
    y = np.zeros(4)
    slope = np.zeros((4, 4))
    trial = np.zeros(4)
    acc = np.zeros(2)
    for i in range(len(accel)):
        for stage in range(4):
            weight = 0.0 if stage == 0 else (0.5 if stage < 3 else 1.0)
            for j in range(4):
                trial[j] = y[j] + (0.0 if stage == 0 else weight * step * slope[stage - 1, j])
            j0, j1 = i, min(i + 1, len(accel) - 1)
            ay = (1 - weight) * accel[j0] + weight * accel[j1]
            be = (1 - weight) * bank[j0] + weight * bank[j1]
            bd = (bank[j1] - bank[j0]) / step
            phi, psi, dphi, dpsi = trial[0], trial[1], trial[2], trial[3]
            e, de = phi - psi, dphi - dpsi
            moment = k * e * (1 + cubic * e * e) + (d if de < 0 else d * rebound) * de
            cosine, sine = np.cos(phi), np.sin(phi)
            # body: I phi'' = arm ms (fy) - moment, fy = (ay - axis psi'' - arm phi'') cos + g sin
            # axle: Iu psi'' = moment + axis ms fy + mu hub (ay - hub psi'' + g psi) - kt (psi - bank) - ...
            a11 = inertia + arm * ms * arm * cosine
            a12 = arm * ms * axis * cosine
            b1 = arm * ms * (ay * cosine + 9.80665 * sine) - moment
            a21 = axis * ms * arm * cosine
            a22 = axle + axis * ms * axis * cosine + mu * hub * hub
            b2 = (
                moment
                + axis * ms * (ay * cosine + 9.80665 * sine)
                + mu * hub * (ay + 9.80665 * psi)
                - kt * (psi - be)
                - dt_ * (dpsi - bd)
            )
            det = a11 * a22 - a12 * a21
            acc[0] = (b1 * a22 - a12 * b2) / det
            acc[1] = (a11 * b2 - a21 * b1) / det
            slope[stage, 0], slope[stage, 1] = dphi, dpsi
            slope[stage, 2], slope[stage, 3] = acc[0], acc[1]
            if stage == 0:
                out[i, 0], out[i, 1], out[i, 2], out[i, 3] = phi, psi, dphi, dpsi
                out[i, 4], out[i, 5] = acc[0], acc[1]
        for j in range(4):
            y[j] += step / 6 * (slope[0, j] + 2 * slope[1, j] + 2 * slope[2, j] + slope[3, j])


def _smooth(values: Array, time_s: float) -> Array:
    """First-order lag, so that the road's lateral acceleration has no jumps."""
    keep = np.exp(-1 / RATE / time_s)
    from scipy.signal import lfilter

    return np.asarray(lfilter([1 - keep], [1, -keep], values))


def sine_with_dwell(peak: float, repeats: int = 3, still_s: float = 3.0) -> Array:
    """Lateral acceleration of the road frame in m/s² at 500 Hz: 0.7 Hz sine with 0.5 s dwell, `repeats` times."""
    t = np.arange(0, 2 + 1 / 0.7 + 0.5 + 3, 1 / RATE)
    one = np.zeros_like(t)
    s = t - 2
    first = (s >= 0) & (s < 0.75 / 0.7)
    one[first] = np.sin(2 * np.pi * 0.7 * s[first])
    one[(s >= 0.75 / 0.7) & (s < 0.75 / 0.7 + 0.5)] = -1
    last = (s >= 0.75 / 0.7 + 0.5) & (s < 1 / 0.7 + 0.5)
    one[last] = np.sin(2 * np.pi * 0.7 * (s[last] - 0.5))
    scales = peak * np.linspace(0.6, 1.0, repeats)
    parts = [np.zeros(int(still_s * RATE)), *(scale * one for scale in scales)]
    return _smooth(_smooth(np.concatenate(parts), 0.1), 0.05)


def slalom(peak: float, frequency: float = 0.45, seconds: float = 40.0, still_s: float = 3.0) -> Array:
    """A slalom of slowly changing rhythm."""
    t = np.arange(0, seconds, 1 / RATE)
    phase = 2 * np.pi * frequency * (t + 0.2 * t**2 / seconds)
    return _smooth(
        np.concatenate([np.zeros(int(still_s * RATE)), peak * np.sin(phase) * np.minimum(1, t / 3)]), 0.1
    )


def circle(peak: float, seconds: float = 60.0, still_s: float = 3.0) -> Array:
    """Slow circle: lateral acceleration that grows over a minute."""
    t = np.arange(0, seconds, 1 / RATE)
    return np.concatenate([np.zeros(int(still_s * RATE)), peak * np.minimum(1, t / (0.8 * seconds))])


def wavy_bank(n: int, std: float, rng: np.random.Generator, time_s: float = 5.0) -> Array:
    """A road whose bank wanders with the standard deviation `std` (rad)."""
    if std == 0:
        return np.zeros(n)
    rough = _smooth(_smooth(rng.standard_normal(n + 5000), time_s / 2), time_s / 2)[5000:]
    return np.asarray(std * rough / rough.std())


def simulate(car: Car, accel: Array, bank: Array | None = None) -> dict[str, Array]:
    """True motion at 500 Hz: roll, roll rate, deflections, sensed lateral acceleration at the IMU, yaw rate."""
    bank = np.zeros_like(accel) if bank is None else bank
    p = (
        car.sprung_kg, car.unsprung_kg, car.arm, car.roll_axis, car.hub_height, car.body_inertia, car.axle_inertia,
        car.stiffness, car.damping, car.cubic, car.rebound, car.tyre_roll, 0.005 * car.tyre_roll,
    )  # fmt: skip
    out = np.zeros((len(accel), 6))
    _simulate(accel, bank, np.array(p), out)
    phi, psi, dphi, _, ddphi, ddpsi = out.T
    lateral = accel - car.roll_axis * ddpsi - (car.imu_height - car.roll_axis) * ddphi
    sensed = lateral * np.cos(phi) + G * np.sin(phi)
    return {
        "roll": phi,
        "axle": psi,
        "roll_rate": dphi,
        "accel_y": sensed,
        "yaw_rate": accel / 15.0,
        "road": accel,
    }


def _noise(n: int, std: float, colour_s: float, rng: np.random.Generator) -> Array:
    white = rng.standard_normal(n)
    if colour_s > 0:
        from scipy.signal import lfilter

        keep = np.exp(-0.01 / colour_s)
        white = np.asarray(lfilter([np.sqrt(1 - keep**2)], [1, -keep], white))
    return std * white


def record(
    truth: dict[str, Array], car: Car, sensors: Sensors, rng: np.random.Generator, still_s: float = 3.0
) -> Drive:
    """What a 100 Hz logger (speed at 10 Hz) writes down."""
    t = np.arange(0, len(truth["roll"]) / RATE - 0.3, 0.01)
    fine = np.arange(len(truth["roll"])) / RATE

    def seen(name: str, late: float = 0.0) -> Array:
        return np.asarray(np.interp(t - late, fine, truth[name]))

    def stepped(values: Array, step: float) -> Array:
        return np.round(values / step) * step if step > 0 else values

    n, s = len(t), sensors
    time_ns = np.round(t * 1e9).astype(np.int64)
    columns = {
        "accel_y": stepped(
            seen("accel_y") + s.accel_offset + _noise(n, s.accel_noise, s.colour_s, rng), s.accel_step
        ),
        "roll": stepped(
            seen("roll", s.roll_delay) + s.roll_offset + _noise(n, s.roll_noise, s.colour_s, rng), s.roll_step
        ),
        "roll_rate": seen("roll_rate", s.rate_delay)
        + s.rate_offset
        + _noise(n, s.rate_noise, s.colour_s, rng),
        "yaw_rate": seen("yaw_rate") + _noise(n, 0.003, 0.0, rng),
    }
    deflection = 0.5 * car.track * (seen("roll") - seen("axle"))
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        columns[f"suspension_deflection_{wheel}"] = side * deflection + _noise(n, 3e-4, s.colour_s, rng)
    signals = {name: Signal(name, time_ns, values, name) for name, values in columns.items()}
    slow = time_ns[::10]
    speed = np.where(slow / 1e9 < still_s, 0.0, 15.0)
    signals["speed"] = Signal("speed", slow, speed, "speed")
    return Drive(signals, bare_record(float(t[-1])))


def bare_record(duration_s: float) -> ImportRecord:
    """An import record of a simulated drive."""
    return ImportRecord(
        "simulated", (Path("plant"),), "0", "complete", 0, {}, (), "plant", None, duration_s, ()
    )


def without(drive: Drive, *prefixes: str) -> Drive:
    """The drive without signals whose names begin so."""
    return replace(drive, signals={n: s for n, s in drive.signals.items() if not n.startswith(prefixes)})


@dataclass(frozen=True)
class Knowledge:
    """How well the vehicle file knows the car: relative standard deviations, None = silent."""

    mass: float | None = 0.01
    stiffness: float | None = 0.02
    tyre: float | None = 0.10
    inertia: float | None = None
    unsprung: float | None = 0.05
    height: tuple[float, float] | None = None
    roll_axis: float | None = 0.01
    imu: float | None = 0.02
    load: bool = True
    damping: float | None = None
    extra: dict[str, Quantity] = field(default_factory=dict)


def vehicle_of(car: Car, know: Knowledge, rng: np.random.Generator) -> Vehicle:
    """A vehicle file whose values miss the truth by their stated standard deviations."""

    def missed(value: float, relative: float) -> Quantity:
        return Quantity(value * (1 + relative * rng.standard_normal()), value * relative, "vehicle file")

    found: dict[str, Quantity] = {"track_front_m": Quantity(car.track, 0.005, "vehicle file")}
    found["track_rear_m"] = found["track_front_m"]
    for key, value, relative in (
        ("mass_kg", car.mass, know.mass),
        ("roll_stiffness_nmprad", car.stiffness, know.stiffness),
        ("roll_damping_nmsprad", car.damping, know.damping),
        ("tire_vertical_rate_npm", car.tyre_npm, know.tyre),
        ("roll_inertia_kgm2", car.roll_inertia, know.inertia),
        ("unsprung_mass_front_kg", car.unsprung_kg / 2, know.unsprung),
        ("unsprung_mass_rear_kg", car.unsprung_kg / 2, know.unsprung),
    ):
        if relative is not None:
            found[key] = missed(value, relative)
    found["wheel_radius_m"] = Quantity(car.hub_height, 0.005, "vehicle file")
    if know.height is not None:
        found["cg_height_m"] = Quantity(know.height[0], know.height[1], "vehicle file")
    if know.roll_axis is not None:
        for axle in ("front", "rear"):
            value = car.roll_axis + know.roll_axis * rng.standard_normal()
            found[f"roll_center_height_{axle}_m"] = Quantity(value, know.roll_axis, "vehicle file")
    sensors: dict[str, Quantity] = {}
    if know.imu is not None:
        sensors["imu_above_ground_m"] = Quantity(car.imu_height, know.imu, "vehicle file")
    load = {"mass_kg": Quantity(0.0, 0.0, "vehicle file")} if know.load else {}
    found.update(know.extra)
    reference = {"cg_height_m": car.cg_height, "mass_kg": car.mass, "roll_stiffness_nmprad": car.stiffness}
    return Vehicle("plant", "SUV", found, load, sensors, reference)
