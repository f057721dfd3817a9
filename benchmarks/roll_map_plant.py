"""Vehicles, drives and sensors for judging the roll estimator; built from the physics, not from the estimator.

A sprung body that rolls, slides and yaws on two axles that roll on their tyres: a bicycle with tyre relaxation and
saturation, a roll centre at each axle, unsprung masses with inertia of their own, springs that stiffen, digressive
dampers (two slopes with a knee), Dahl friction, a road with bank and roughness by distance. Runge-Kutta at 1 kHz.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from parsers.jit import kernel
from pipelines.results import FloatArray

G = 9.80665
RATE = 1000
PLACES = 22
AXLE = 9
"""Places in the kernel's parameter vector: the vehicle's, and how many an axle takes."""


@dataclass(frozen=True)
class Axle:
    """One axle, SI: mass, its height and own roll inertia, roll centre, roll stiffness (springs and bars), damping at
    low speed, slope above the knee over that below, knee as roll rate, friction moment and the roll after which it has turned round, tyres' roll stiffness."""

    kg: float
    hub: float
    inertia: float
    centre: float
    stiffness: float
    damping: float
    slope: float
    knee: float
    friction: float
    slip: float
    tyres: float


@dataclass(frozen=True)
class Car:
    """The loaded vehicle. ahead, behind: front and rear axle from the CG. body: roll inertia of the sprung mass about
    its own CG. empty_*: as a data sheet has them; load_*: mass and CG height of all that was put in."""

    style: str
    sprung_kg: float
    sprung_height: float
    body: float
    ahead: float
    behind: float
    track: float
    front: Axle
    rear: Axle
    stiffening: float
    yaw_inertia: float
    grip_front: float
    grip_rear: float
    tyre_npm: float
    empty_kg: float
    empty_height: float
    empty_inertia: float
    load_kg: float
    load_height: float
    imu_height: float
    imu_ahead: float

    @property
    def mass(self) -> float:
        return self.sprung_kg + self.front.kg + self.rear.kg

    @property
    def height(self) -> float:
        hubs = self.front.kg * self.front.hub + self.rear.kg * self.rear.hub
        return (self.sprung_kg * self.sprung_height + hubs) / self.mass

    @property
    def shares(self) -> tuple[float, float]:
        """Front and rear share of the sprung mass."""
        base = self.ahead + self.behind
        return self.behind / base, self.ahead / base

    @property
    def axis(self) -> float:
        """Height of the roll axis below the CG."""
        return self.shares[0] * self.front.centre + self.shares[1] * self.rear.centre

    @property
    def arm(self) -> float:
        return self.sprung_height - self.axis

    @property
    def inertia(self) -> float:
        """Roll inertia of the whole vehicle about its CG."""
        total = self.body + self.sprung_kg * (self.sprung_height - self.height) ** 2
        for axle in (self.front, self.rear):
            total += axle.inertia + axle.kg * (axle.hub - self.height) ** 2
        return total


def matrices(car: Car, damping: tuple[float, float]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Small motions of (body, front axle, rear axle) about rest: inertia, damping, stiffness without gravity (3, 3),
    and the load (3,) of a lateral acceleration of the road; all angles against the horizon."""
    axles, shares = (car.front, car.rear), car.shares
    mass, damp, stiff, load = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3)
    sway = np.array([car.arm, *(s * axle.centre for s, axle in zip(shares, axles, strict=True))])
    mass += car.sprung_kg * np.outer(sway, sway)
    mass[0, 0] += car.body
    load += car.sprung_kg * sway
    for i, (axle, d) in enumerate(zip(axles, damping, strict=True), start=1):
        mass[i, i] += axle.inertia + axle.kg * axle.hub**2
        load[i] += axle.kg * axle.hub
        between = np.zeros(3)
        between[[0, i]] = 1.0, -1.0
        damp += d * np.outer(between, between)
        stiff += axle.stiffness * np.outer(between, between)
        stiff[i, i] += axle.tyres
    return mass, damp, stiff, load


def truths(car: Car, damping: tuple[float, float]) -> dict[str, float]:
    """The truth of every parameter that the estimator gives; `damping`: equivalent linear ones of the axles.

    Gradient: static roll per sensed acceleration of small motions about rest. Natural frequency: lowest undamped mode,
    without gravity. Damping ratio: of that mode with the equivalent damping. Tyres included, whatever
    was measured.
    """
    mass, damp, stiff, load = matrices(car, damping)
    weight = np.zeros_like(stiff)
    weight[0, 0] = car.sprung_kg * car.arm
    for i in range(1, len(load)):
        weight[i, i] = load[i]
    lean = np.linalg.solve(stiff - G * weight, load)[0]
    squares, shapes = eigh(stiff, mass)
    shape = shapes[:, 0]
    return {
        "cg_height_m": car.height,
        "sprung_cg_height_m": car.sprung_height,
        "roll_arm_m": car.arm,
        "mass_kg": car.mass,
        "sprung_mass_kg": car.sprung_kg,
        "roll_inertia_kgm2": car.inertia,
        "roll_stiffness_nmprad": car.front.stiffness + car.rear.stiffness,
        "roll_damping_nmsprad": sum(damping),
        "roll_gradient_degpg": float(np.degrees(G * lean / (1 + G * lean))),
        "roll_natural_frequency_hz": float(np.sqrt(squares[0]) / (2 * np.pi)),
        "roll_damping_ratio": float(shape @ damp @ shape / (2 * np.sqrt(squares[0]))),
    }


@kernel
def _suspension(
    e: float, de: float, z: float, q: FloatArray, base: int, stiffening: float
) -> tuple[float, float, float]:
    """Moments of springs, and of dampers with friction, and the friction state's rate."""
    knee = q[base + 5]
    speed = abs(de)
    if speed > knee:
        speed = knee + q[base + 4] * (speed - knee)
    damper = q[base + 3] * (speed if de >= 0 else -speed)
    dz = de - abs(de) * z / q[base + 8]
    spring = q[base + 2] * e * (1 + stiffening * e * e)
    return spring, damper + q[base + 6] * z / q[base + 8], dz


@kernel
def _solve(m: FloatArray, x: FloatArray) -> None:
    """Solve the four equations m (4, 5), the last column on their right, by elimination; m is used up. x: (4 or more,)."""
    for i in range(4):
        for j in range(i + 1, 4):
            part = m[j, i] / m[i, i]
            for k in range(i, 5):
                m[j, k] -= part * m[i, k]
    for i in range(3, -1, -1):
        total = m[i, 4]
        for k in range(i + 1, 4):
            total -= m[i, k] * x[k]
        x[i] = total / m[i, i]


@kernel
def _slopes(
    y: FloatArray, at: FloatArray, q: FloatArray, m: FloatArray, out: FloatArray, extra: FloatArray
) -> None:
    """Rates of change (12,) of the states; extra (9,): accelerations and moments. at: speed, steer, banks and rates."""
    ms, arm, body, ahead, behind, izz, cf, cr, stiffening, mu = q[:10]
    f, r = PLACES, PLACES + AXLE
    u = max(at[0], 2.0)
    front_share, rear_share = behind / (ahead + behind), ahead / (ahead + behind)
    weight_f, weight_r = front_share * ms + q[f], rear_share * ms + q[r]
    grip_f, grip_r = mu * weight_f * G, mu * weight_r * G
    slip_f = at[1] - (y[0] + ahead * y[1]) / u
    slip_r = -(y[0] - behind * y[1]) / u
    out[2] = (grip_f * np.tanh(cf * slip_f / mu) - y[2]) * u / 0.4
    out[3] = (grip_r * np.tanh(cr * slip_r / mu) - y[3]) * u / 0.4
    yaw = (ahead * y[2] - behind * y[3]) / izz
    phi, sf, sr = y[4], y[5], y[6]
    spring_f, damp_f, out[10] = _suspension(phi - sf, y[7] - y[8], y[10], q, f, stiffening)
    spring_r, damp_r, out[11] = _suspension(phi - sr, y[7] - y[9], y[11], q, r, stiffening)
    cosine, sine = np.cos(phi), np.sin(phi)
    hub_f, hub_r, centre_f, centre_r = q[10], q[11], q[12], q[13]
    tyre_f, tyre_r = q[f + 7], q[r + 7]
    load_f = y[2] - weight_f * G * at[2]
    load_r = y[3] - weight_r * G * at[3]
    # unknowns: lateral acceleration of the road point, body, front axle, rear axle
    m[:] = 0.0
    m[0, 0] = ms + q[f] + q[r]
    m[0, 1] = -ms * arm
    m[0, 2] = -ms * front_share * centre_f - q[f] * hub_f
    m[0, 3] = -ms * rear_share * centre_r - q[r] * hub_r
    m[0, 4] = load_f + load_r - (q[f] * ahead - q[r] * behind) * yaw
    lever = ms * arm * cosine
    m[1, 0] = -lever
    m[1, 1] = body + lever * arm
    m[1, 2] = lever * front_share * centre_f
    m[1, 3] = lever * rear_share * centre_r
    m[1, 4] = ms * arm * G * sine - spring_f - damp_f - spring_r - damp_r
    # an axle: its link carries the tyre force less what the axle itself takes
    m[2, 0] = -q[f] * (hub_f - centre_f)
    m[2, 2] = q[f + 1] + q[f] * hub_f * (hub_f - centre_f)
    m[2, 4] = (
        spring_f + damp_f + centre_f * load_f + q[f] * (hub_f - centre_f) * ahead * yaw
        + (q[f] * hub_f + ms * front_share * centre_f) * G * sf
        - tyre_f * (sf - at[2]) - 0.004 * tyre_f * (y[8] - at[4])
    )  # fmt: skip
    m[3, 0] = -q[r] * (hub_r - centre_r)
    m[3, 3] = q[r + 1] + q[r] * hub_r * (hub_r - centre_r)
    m[3, 4] = (
        spring_r + damp_r + centre_r * load_r - q[r] * (hub_r - centre_r) * behind * yaw
        + (q[r] * hub_r + ms * rear_share * centre_r) * G * sr
        - tyre_r * (sr - at[3]) - 0.004 * tyre_r * (y[9] - at[5])
    )  # fmt: skip
    _solve(m, extra)
    out[0] = extra[0] - at[0] * y[1]
    out[1] = yaw
    for i in range(3):
        out[4 + i] = y[7 + i]
        out[7 + i] = extra[1 + i]
    extra[4] = yaw
    extra[5], extra[6] = damp_f, damp_r


@kernel
def _integrate(inputs: FloatArray, q: FloatArray, every: int, out: FloatArray, energy: FloatArray) -> None:
    """out (n // every, 12): roll, rate, acceleration, both axles' roll and accelerations, road acceleration, yaw rate
    and acceleration, speed, bank. energy (2, 2): damper work and squared speed of each axle. inputs (n, 6)."""
    y, trial, m = np.zeros(12), np.zeros(12), np.zeros((4, 5))
    slope, extra, at = np.zeros((4, 12)), np.zeros(9), np.zeros(6)
    y[4] = y[5] = y[6] = inputs[0, 2]
    step = 1.0 / RATE
    for i in range(len(inputs) - 1):
        for stage in range(4):
            part = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
            for j in range(6):
                at[j] = (1 - part) * inputs[i, j] + part * inputs[i + 1, j]
            for j in range(12):
                trial[j] = y[j] + (0.0 if stage == 0 else part * step * slope[stage - 1, j])
            _slopes(trial, at, q, m, slope[stage], extra)
            if stage == 0:
                for axle in range(2):
                    de = y[7] - y[8 + axle]
                    energy[axle, 0] += extra[5 + axle] * de
                    energy[axle, 1] += de * de
                if i % every == 0:
                    k = i // every
                    out[k, 0], out[k, 1], out[k, 2] = y[4], y[7], extra[1]
                    out[k, 3], out[k, 4], out[k, 5], out[k, 6] = y[5], y[6], extra[2], extra[3]
                    out[k, 7], out[k, 8], out[k, 9] = extra[0], y[1], extra[4]
                    out[k, 10], out[k, 11] = inputs[i, 0], inputs[i, 2]
        for j in range(12):
            y[j] += step / 6 * (slope[0, j] + 2 * slope[1, j] + 2 * slope[2, j] + slope[3, j])


def _vector(car: Car) -> FloatArray:
    q = np.zeros(PLACES + 2 * AXLE)
    q[:14] = (
        car.sprung_kg, car.arm, car.body, car.ahead, car.behind, car.yaw_inertia, car.grip_front, car.grip_rear,
        car.stiffening, 0.95, car.front.hub, car.rear.hub, car.front.centre, car.rear.centre,
    )  # fmt: skip
    for i, x in enumerate((car.front, car.rear)):
        first = PLACES + i * AXLE
        q[first : first + AXLE] = (
            x.kg, x.inertia, x.stiffness, x.damping, x.slope, x.knee, x.friction, x.tyres, x.slip,
        )  # fmt: skip
    return q


def integrate(car: Car, inputs: FloatArray) -> tuple[dict[str, FloatArray], tuple[float, float]]:
    """Motion at 500 Hz by name, and the equivalent linear damping of each axle. inputs (n, 6) at 1 kHz: speed, steering
    angle of the front wheels, bank under the front and rear axle, and their rates."""
    every = 2
    out, energy = np.zeros(((len(inputs) - 1 + every - 1) // every, 12)), np.zeros((2, 2))
    _integrate(inputs, _vector(car), every, out, energy)
    names = (
        *("roll", "rate", "turn", "front", "rear", "front_turn", "rear_turn"),
        *("road", "yaw", "yaw_turn", "speed", "bank"),
    )
    damping = (float(energy[0, 0] / energy[0, 1]), float(energy[1, 0] / energy[1, 1]))
    return dict(zip(names, out.T, strict=True)), damping
