"""A small car for judging load_balance, built otherwise than the estimator: seven degrees of freedom, stepped in time.

Body with heave, pitch and roll on four unsprung masses and tyres; forces of the driver act at the road, links carry
what acts below roll and pitch centre. Friction, a two-slope damper and a cubic spring are in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from parsers.jit import kernel
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665


@dataclass(frozen=True)
class Car:
    """The loaded car. load at (behind the front axle, left, above ground)."""

    empty_sprung: float = 1650.0
    unsprung_front: float = 100.0
    unsprung_rear: float = 95.0
    empty_x: float = 1.28
    empty_h: float = 0.70
    load: float = 170.0
    load_at: tuple[float, float, float] = (1.5, 0.15, 1.2)
    wheelbase: float = 2.75
    track: float = 1.6
    spring_front: float = 29_000.0
    spring_rear: float = 32_000.0
    cube: float = 5.0
    bar_front: float = 22_000.0
    bar_rear: float = 9_000.0
    bump: float = 1_400.0
    rebound: float = 2_300.0
    friction: float = 60.0
    tyre: float = 240_000.0
    roll_center: float = 0.10
    pitch_center: float = 0.0
    radius: float = 0.34
    wheel_inertia: float = 1.3
    drag: float = 0.75
    rolling: float = 0.011
    roll_inertia: float = 620.0
    pitch_inertia: float = 2500.0
    stop_at: float = 1.0
    """Travel from where the empty car stands, at which the front wheels meet their bump stops."""
    stop_rate: float = 3e6
    """N a m² of travel into them."""

    @property
    def sprung(self) -> float:
        return self.empty_sprung + self.load

    @property
    def unsprung(self) -> float:
        return self.unsprung_front + self.unsprung_rear

    @property
    def mass(self) -> float:
        return self.sprung + self.unsprung

    @property
    def place(self) -> tuple[float, float, float]:
        """Sprung CG before the load's sag."""
        base = (self.empty_x, 0.0, self.empty_h)
        return tuple(
            (self.empty_sprung * b + self.load * at) / self.sprung
            for b, at in zip(base, self.load_at, strict=True)
        )  # type: ignore[return-value]

    @property
    def sag(self) -> float:
        s = self.spring_front + self.spring_rear
        return self.load * G * (1 / (2 * s) + 1 / (4 * self.tyre))

    def truth(self) -> dict[str, float]:
        x, y, z = self.place
        h = z - self.sag
        mass = self.mass
        return {
            "mass_kg": mass,
            "sprung_mass_kg": self.sprung,
            "cg_height_m": (self.sprung * h + self.unsprung * self.radius) / mass,
            "sprung_cg_height_m": h,
            "cg_to_front_axle_m": (self.sprung * x + self.unsprung_rear * self.wheelbase) / mass,
            "cg_lateral_offset_m": self.sprung * y / mass,
        }

    def empty(self) -> dict[str, float]:
        """The data sheet."""
        bare = replace(self, load=0.0)
        t = bare.truth()
        return {
            "mass_kg": t["mass_kg"], "cg_to_front_axle_m": t["cg_to_front_axle_m"], "cg_height_m": t["cg_height_m"],
            "unsprung_mass_front_kg": self.unsprung_front, "unsprung_mass_rear_kg": self.unsprung_rear,
            "wheelbase_m": self.wheelbase, "track_front_m": self.track, "track_rear_m": self.track,
            "spring_rate_front_npm": self.spring_front, "spring_rate_rear_npm": self.spring_rear,
            "anti_roll_stiffness_front_nmprad": self.bar_front, "anti_roll_stiffness_rear_nmprad": self.bar_rear,
            "roll_center_height_front_m": self.roll_center, "roll_center_height_rear_m": self.roll_center,
            "wheel_radius_m": self.radius, "wheel_inertia_kgm2": self.wheel_inertia, "drag_area_m2": self.drag,
            "rolling_resistance": self.rolling, "pitch_center_height_m": self.pitch_center,
        }  # fmt: skip


STDS = {
    "mass_kg": 0.01, "cg_to_front_axle_m": 0.01, "cg_height_m": 0.03, "unsprung_mass_front_kg": 0.03,
    "unsprung_mass_rear_kg": 0.03, "wheelbase_m": 0.002, "track_front_m": 0.005, "track_rear_m": 0.005,
    "spring_rate_front_npm": 0.02, "spring_rate_rear_npm": 0.02, "anti_roll_stiffness_front_nmprad": 0.05,
    "anti_roll_stiffness_rear_nmprad": 0.05, "wheel_radius_m": 0.01, "wheel_inertia_kgm2": 0.1, "drag_area_m2": 0.05,
    "rolling_resistance": 0.15,
}  # fmt: skip


def vehicle_file(car: Car, rng: np.random.Generator | None, *drop: str) -> Vehicle:
    """The empty car as a data sheet has it: wrong by its stated spread (rng None: right, with the same spread)."""
    quantities = {}
    for key, value in car.empty().items():
        if key in drop:
            continue
        std = STDS[key] * value if key in STDS else 0.02
        off = 0.0 if rng is None else std * rng.standard_normal()
        quantities[key] = Quantity(value + off, std, "vehicle file")
    sensors = {
        name: Quantity(value, 0.03, "vehicle file")
        for name, value in (
            ("imu_behind_front_axle_m", 1.2),
            ("imu_left_m", 0.0),
            ("imu_above_ground_m", 0.5),
        )
    }
    return Vehicle(name="car", body="SUV", quantities=quantities, sensors=sensors, reference=car.truth())


def demand(seconds: float, rng: np.random.Generator, *, brake: float = 3.0, turn: float = 3.0) -> FloatArray:
    """(n, 3) at 1 kHz: a_x, a_y in m/s² and speed: launches, stops and bends, rest at both ends and between."""
    n = round(seconds * 1000)
    t = np.arange(n) / 1000
    ax = np.zeros(n)
    v, at = 0.0, 5.0
    while at < seconds - 25:
        up, hold, down = rng.uniform(5, 9), rng.uniform(4, 12), 0.0
        a = rng.uniform(0.4, 1.0) * min(brake, 2.5)
        b = rng.uniform(0.4, 1.0) * brake
        down = a * up / b
        ax[(t >= at) & (t < at + up)] = a
        ax[(t >= at + up + hold) & (t < at + up + hold + down)] = -b
        at += up + hold + down + rng.uniform(2, 5)
    box = np.hanning(601)
    ax = np.convolve(ax, box / box.sum(), mode="same")
    speed = np.maximum(np.cumsum(ax) / 1000, 0.0)
    bend = np.repeat(rng.standard_normal(n // 2500 + 1), 2500)[:n]
    bend = np.convolve(bend, np.hanning(2001) / 1000, mode="same")
    ay = turn * np.clip(bend, -1.2, 1.2) * np.clip(speed / 8.0, 0, 1)
    del v
    return np.column_stack([ax, ay, speed])


@kernel
def _step_all(u: FloatArray, road: FloatArray, k: FloatArray, out: FloatArray) -> None:
    """Step the car through u (n, 3) on the road (n, 4) at 1 kHz. k: the car, in `simulate`'s order. out: (n / 10, 17)."""
    ms, x, y, h, length, track, kf, kr, cube, bf, br, bump, reb, fric = k[:14]
    kt, hrc, hpc, radius, iw, da, ix, iy, mu = k[14:23]
    pos, vel = np.zeros(3), np.zeros(3)
    zu, vu = np.zeros(4), np.zeros(4)
    lever_x = np.array([x, x, x - length, x - length])
    lever_y = np.array([track / 2 - y, -track / 2 - y, track / 2 - y, -track / 2 - y])
    preload = k[23:27]
    mui = k[27:31]
    d, rate, s = np.zeros(4), np.zeros(4), np.zeros(4)
    dt = 1e-3
    mass = ms + mu
    whole = ms * h + mu * radius
    for i in range(len(u)):
        ax, ay, v = u[i, 0], u[i, 1], u[i, 2]
        for w in range(4):
            body = pos[0] + lever_y[w] * pos[2] - lever_x[w] * pos[1]
            speed = vel[0] + lever_y[w] * vel[2] - lever_x[w] * vel[1]
            d[w] = zu[w] - body
            rate[w] = vu[w] - speed
        for w in range(4):
            ks = kf if w < 2 else kr
            bar = (bf if w < 2 else br) / track**2
            other = w + 1 if w % 2 == 0 else w - 1
            damp = bump if rate[w] > 0 else reb
            s[w] = preload[w] + ks * d[w] * (1 + cube * d[w] ** 2) + bar * (d[w] - d[other]) + damp * rate[w]
            s[w] += fric * np.tanh(rate[w] / 0.002)
            if w < 2 and d[w] > k[31]:
                s[w] += k[32] * (d[w] - k[31]) ** 2
        drag = 0.6125 * da * v * v
        total = s.sum()
        # about the sprung CG: pitch nose down, roll right side down; the body's shift over its wheels with roll
        links = mass * hpc * ax
        mp = -(s * lever_x).sum() - whole * ax + links - drag * 0.75 - 4 * iw / radius * ax
        mr = (s * lever_y).sum() + ms * (h - hrc) * (ay + G * pos[2])
        acc0 = total / ms - G
        acc1 = mp / iy
        acc2 = mr / ix
        for w in range(4):
            n = kt * (road[i, w] - zu[w]) + preload[w] + mui[w] * G
            if n < 0:
                n = 0.0
            vu[w] += dt * ((n - s[w] - mui[w] * G) / mui[w])
            zu[w] += dt * vu[w]
        vel[0] += dt * acc0
        vel[1] += dt * acc1
        vel[2] += dt * acc2
        for j in range(3):
            pos[j] += dt * vel[j]
        if i % 10 == 0:
            r = i // 10
            out[r, 0:4] = d
            out[r, 4] = ax - G * pos[1]
            out[r, 5] = ay + G * pos[2]
            out[r, 6] = G + acc0 + ax * pos[1] - ay * pos[2]
            out[r, 7], out[r, 8] = vel[2], vel[1]
            out[r, 9:13] = s
            out[r, 13], out[r, 14] = v, mass * ax + drag
            out[r, 15], out[r, 16] = acc1, acc2


def simulate(
    car: Car, u: FloatArray, rng: np.random.Generator, rough_m: float = 0.004
) -> dict[str, FloatArray]:
    """True columns at 100 Hz. u: (n, 3) at 1 kHz from `demand`."""
    x, y, h = car.place
    h -= car.sag
    front = car.empty_sprung * G * (1 - car.empty_x / car.wheelbase) / 2
    rear = car.empty_sprung * G * car.empty_x / car.wheelbase / 2
    corners = [car.unsprung_front / 2] * 2 + [car.unsprung_rear / 2] * 2
    k = np.array([
        car.sprung, x, y, h, car.wheelbase, car.track, car.spring_front, car.spring_rear, car.cube, car.bar_front,
        car.bar_rear, car.bump, car.rebound, car.friction, car.tyre, car.roll_center, car.pitch_center, car.radius,
        car.wheel_inertia, car.drag, car.roll_inertia, car.pitch_inertia, car.unsprung,
        front, front, rear, rear, *corners, car.stop_at, car.stop_rate,
    ])  # fmt: skip
    metres = np.cumsum(u[:, 2]) / 1000
    grid = np.arange(0, metres[-1] + 10, 0.1)
    tracks = []
    for _ in range(2):
        noise = np.cumsum(rng.standard_normal(len(grid)))
        smooth = noise - np.convolve(noise, np.ones(301) / 301, mode="same")
        tracks.append(rough_m * smooth / max(float(smooth.std()), 1e-9))
    front_at = [np.interp(metres, grid, side) for side in tracks]
    rear_at = [np.interp(metres - car.wheelbase, grid, side) for side in tracks]
    settle = 3000
    u = np.concatenate((np.tile(u[:1], (settle, 1)), u))
    road = np.column_stack([*front_at, *rear_at])
    road = np.concatenate((np.tile(road[:1], (settle, 1)), road))
    out = np.zeros((-(-len(u) // 10), 17))
    _step_all(u, road, k, out)
    out = out[settle // 10 :]
    names = [f"suspension_deflection_{w}" for w in ("fl", "fr", "rl", "rr")]
    names += ["accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate"]
    names += [f"suspension_force_{w}" for w in ("fl", "fr", "rl", "rr")] + ["speed", "force"]
    found = dict(zip(names, out.T[:15], strict=True))
    # the inertial unit of `vehicle_file` sits away from the CG
    found["accel_x"] = found["accel_x"] + out[:, 15] * (0.5 - h)
    found["accel_y"] = found["accel_y"] - out[:, 16] * (0.5 - h)
    grip = car.rolling * car.mass * G * np.tanh(found["speed"])
    torque = car.radius * (found.pop("force") + grip) + 4 * car.wheel_inertia / car.radius * u[settle::10, 0]
    found["drive_torque"] = np.maximum(torque, 0.0)
    found["brake_torque"] = np.maximum(-torque, 0.0)
    return found


NOISE = {"suspension_deflection": 5e-4, "accel": 0.05, "roll_rate": 0.003, "pitch_rate": 0.003, "suspension_force": 20.0,
         "speed": 0.03, "drive_torque": 15.0, "brake_torque": 15.0}  # fmt: skip
OFFSET = {"suspension_deflection": 1e-3, "accel": 0.04, "roll_rate": 0.003, "pitch_rate": 0.003, "suspension_force": 20.0,
          "speed": 0.0, "drive_torque": 0.0, "brake_torque": 0.0}  # fmt: skip


def logged(
    columns: dict[str, FloatArray],
    rng: np.random.Generator,
    *drop: str,
    noise: float = 1.0,
    rate_hz: float = 100.0,
) -> Drive:
    """The columns as sensors with noise and offsets would log them; `drop`: beginnings of names left out."""
    signals = {}
    for name, values in columns.items():
        if name.startswith(drop or ("-",)):
            continue
        kind = next(k for k in NOISE if name.startswith(k))
        scale = 1 + 0.02 * rng.standard_normal() if "torque" in name else 1.0
        wrong = OFFSET[kind] * rng.standard_normal() + noise * NOISE[kind] * rng.standard_normal(len(values))
        time_ns = (np.arange(len(values)) * (1e9 / rate_hz)).astype(np.int64)
        signals[name] = Signal(name, time_ns, scale * values + wrong, "simulated")
    record = ImportRecord("sim", (), "", "complete", 0, {}, (), "clock", None, 0.0, ())
    return Drive(signals, record)
