"""A quarter car on off-road terrain: the simulation of Pence, Fathy & Stein (Fig. 1, Table I), compiled.

    m_s z_s'' = -k_s x - k_3 x³ - d(x') - c sign(x') - stops
    m_u z_u'' = -(m_s z_s'') + F_t,    x = z_s - z_u,    x' > 0 is extension

d has one slope in extension and one in compression. The tyre pushes only: F_t = k_u (z_g - z_u) + b_u (z_g' - z_u')
beyond the static load, and it is off the ground where the sum would pull. Friction, cubic spring and bump stops are
0 in the paper's own set-up; they are for judging the methods on a car that their model does not hold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from parsers.jit import kernel, lean_kernel
from pipelines.results import FloatArray
from pipelines.simulation.records import GRAVITY

STEPS = 8
"""Integration steps a sample at 200 Hz; halving the step moves no acceleration by more than 1e-3 of its RMS."""

TERRAIN_STEP_M = 0.05
STICK_MPS = 0.005
"""Speed over which friction changes its sign."""


@dataclass(frozen=True)
class QuarterCar:
    """Table I by default. SI. stop_m: travel each way from rest to the bump stop; stop_npm: its further stiffness."""

    sprung_kg: float = 803.0
    spring_npm: float = 63_528.0
    extension_nspm: float = 3_428.0
    compression_nspm: float = 10_571.0
    unsprung_kg: float = 98.0
    tyre_npm: float = 204_394.0
    tyre_nspm: float = 0.0
    cubic_npm3: float = 0.0
    friction_n: float = 0.0
    stop_m: float = math.inf
    stop_npm: float = 0.0

    def parameters(self) -> FloatArray:
        """As the kernel takes them, (11,)."""
        stop = self.stop_m if math.isfinite(self.stop_m) else 1e9
        return np.array([
            self.sprung_kg, self.spring_npm, self.extension_nspm, self.compression_nspm, self.unsprung_kg,
            self.tyre_npm, self.tyre_nspm, self.cubic_npm3, self.friction_n, stop, self.stop_npm,
        ])  # fmt: skip


@dataclass(frozen=True)
class Terrain:
    """Heights (n,) in m at even steps along the way, smooth in between (cubic); it begins flat."""

    height_m: FloatArray
    step_m: float = TERRAIN_STEP_M

    @property
    def length_m(self) -> float:
        """How long it is."""
        return self.step_m * (len(self.height_m) - 3)

    def times(self, factor: float) -> Terrain:
        """The same terrain, `factor` times as high."""
        return Terrain(factor * self.height_m, self.step_m)


@dataclass(frozen=True)
class QuarterRun:
    """What the quarter car did, at an even rate, all (n,): accelerations 0 at rest (no gravity), deflection and its
    rate (+ extension), tyre force (static load with it). off_ground: share of the time that the tyre was in the air.
    """

    step_s: float
    accel_sprung: FloatArray
    accel_unsprung: FloatArray
    extension: FloatArray
    extension_rate: FloatArray
    tyre_force: FloatArray
    off_ground: float
    car: QuarterCar = field(default_factory=QuarterCar)


@lean_kernel
def _suspension(p: FloatArray, x: float, v: float) -> float:
    """Force that pulls the body towards the hub at extension x and its rate v."""
    force: float = p[1] * x + p[7] * x * x * x + (p[2] if v > 0.0 else p[3]) * v
    if p[8] > 0.0:
        force += p[8] * math.tanh(v / STICK_MPS)
    if x > p[9]:
        force += p[10] * (x - p[9])
    elif x < -p[9]:
        force += p[10] * (x + p[9])
    return force


@lean_kernel
def _ground(height: FloatArray, place: float) -> tuple[float, float]:
    """Height and slope per grid step at `place` (in grid steps): Catmull-Rom's cubic, held at the ends."""
    last = len(height) - 3
    i = int(place)
    if i < 1:
        return height[1], 0.0
    if i >= last:
        return height[last], 0.0
    t = place - i
    a, b, c, d = height[i - 1], height[i], height[i + 1], height[i + 2]
    k1, k2, k3 = 0.5 * (c - a), a - 2.5 * b + 2.0 * c - 0.5 * d, 0.5 * (d - a) + 1.5 * (b - c)
    return b + t * (k1 + t * (k2 + t * k3)), k1 + t * (2.0 * k2 + 3.0 * t * k3)


@kernel
def _run(p: FloatArray, height: FloatArray, pace: float, step: float, steps: int, out: FloatArray) -> int:
    """Runge-Kutta of order 4 with `steps` steps of `step` a row of `out` (n, 5); pace: grid steps a second.

    Returns the steps that the tyre spent off the ground. States: z_s, z_s', z_u, z_u'.
    """
    load = (p[0] + p[4]) * GRAVITY
    state, mid, total, rate = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    air = 0
    for row in range(out.shape[0]):
        for inner in range(steps):
            start = (row * steps + inner) * step
            for stage in range(4):
                share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                for i in range(4):
                    mid[i] = state[i] + share * step * rate[i]
                zg, slope = _ground(height, (start + share * step) * pace)
                pull = _suspension(p, mid[0] - mid[2], mid[1] - mid[3])
                push = load + p[5] * (zg - mid[2]) + p[6] * (slope * pace - mid[3])
                if push < 0.0:
                    push = 0.0
                rate[0] = mid[1]
                rate[1] = -pull / p[0]
                rate[2] = mid[3]
                rate[3] = (pull + push - load) / p[4]
                if stage == 0:
                    air += push == 0.0
                    if inner == 0:
                        out[row, 0], out[row, 1] = rate[1], rate[3]
                        out[row, 2], out[row, 3], out[row, 4] = mid[0] - mid[2], mid[1] - mid[3], push
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                for i in range(4):
                    total[i] = (0.0 if stage == 0 else total[i]) + weight * rate[i]
            for i in range(4):
                state[i] += step / 6.0 * total[i]
    return air


def drive_quarter_car(
    car: QuarterCar,
    terrain: Terrain,
    speed_mps: float,
    duration_s: float,
    step_s: float = 0.005,
    steps: int = STEPS,
) -> QuarterRun:
    """Drive from rest over `terrain` at a constant speed. Raises ValueError where the terrain is too short."""
    if speed_mps * duration_s > terrain.length_m:
        raise ValueError(f"{terrain.length_m:.0f} m of terrain, {speed_mps * duration_s:.0f} m are driven")
    rows = round(duration_s / step_s)
    out = np.zeros((rows, 5))
    air = _run(car.parameters(), terrain.height_m, speed_mps / terrain.step_m, step_s / steps, steps, out)
    a, u, x, v, force = (np.ascontiguousarray(column) for column in out.T)
    return QuarterRun(step_s, a, u, x, v, force, air / (rows * steps), car)


def off_road_terrain(length_m: float, rng: np.random.Generator) -> Terrain:
    """Terrain of the displacement spectrum (n² + 0.1²)^-1.5 / (1 + n²), n in cycles/m, of unit RMS height.

    In place of the paper's ARIMA(8,1,0), whose coefficients are not printed. The first 2 m rise from flat ground.
    """
    rows = 1 << math.ceil(math.log2(length_m / TERRAIN_STEP_M + 8))
    n = np.fft.rfftfreq(rows, TERRAIN_STEP_M)
    amplitude = np.sqrt((n**2 + 0.1**2) ** -1.5 / (1 + n**2))
    amplitude[0] = 0.0
    noise = rng.standard_normal(len(n)) + 1j * rng.standard_normal(len(n))
    height = np.fft.irfft(amplitude * noise, rows)
    height = height[: math.ceil(length_m / TERRAIN_STEP_M) + 4] / float(np.std(height))
    way = np.arange(len(height)) * TERRAIN_STEP_M
    return Terrain((height - height[0]) * (1 - np.exp(-((way / 2.0) ** 2))))


def scaled_terrain(
    terrain: Terrain, car: QuarterCar, speed_mps: float, duration_s: float, wanted: float
) -> Terrain:
    """The terrain, made so high that the hub's acceleration has the RMS `wanted` in m/s².

    The paper prints no heights, but a noise of 0.37 m/s² for 25 dB (Table II): a hub acceleration of 6.6 m/s² RMS.
    """
    factor = 1.0
    for _ in range(8):
        # without the tyre's lift-off one step would do: the car is piecewise linear with its kink at zero
        run = drive_quarter_car(car, terrain.times(factor), speed_mps, duration_s)
        factor *= wanted / float(np.sqrt(np.mean(run.accel_unsprung**2)))
    return terrain.times(factor)
