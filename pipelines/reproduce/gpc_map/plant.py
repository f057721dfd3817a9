"""The seven-degree-of-freedom car of Figure 5.1, linear: body and four hubs over a road of two tracks, compiled.

    m_u z_u'' = k_t (road - z_u) + k e + b e',   e = (body over the wheel) - z_u

and the body as in `pipelines.models.base_excitation_3dof`, each wheel with its own hub: the hubs' warp acts, as it does on a car. Written
on its own, from the drawing, so that it shares no line with the model that is judged on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

FINE = 4
"""Integration steps a sample."""


@dataclass(frozen=True)
class Car:
    """Truth of Table 5.2; what is not printed is a car's. Rates are those of one wheel."""

    mass_kg: float = 1850.0
    pitch_kgm2: float = 3000.0
    roll_kgm2: float = 800.0
    front_m: float = 1.3
    wheelbase_m: float = 2.8
    track_m: float = 1.6
    spring_front_npm: float = 30_000.0
    spring_rear_npm: float = 32_000.0
    damper_front_nspm: float = 2_000.0
    damper_rear_nspm: float = 2_200.0
    hub_kg: float = 45.0
    tyre_npm: float = 220_000.0

    @property
    def truth(self) -> FloatArray:
        """Mass, pitch inertia, roll inertia."""
        return np.array([self.mass_kg, self.pitch_kgm2, self.roll_kgm2])

    def figures(self) -> FloatArray:
        """(12,) as the kernel takes them."""
        return np.array([
            self.mass_kg, self.pitch_kgm2, self.roll_kgm2, self.front_m, self.wheelbase_m, self.track_m,
            self.spring_front_npm, self.spring_rear_npm, self.damper_front_nspm, self.damper_rear_nspm, self.hub_kg,
            self.tyre_npm,
        ])  # fmt: skip


@kernel
def _slope(p: FloatArray, s: FloatArray, road: FloatArray, out: FloatArray) -> None:
    """Rates of s (14,): z, theta, phi, four hubs, and their rates; the seven accelerations are out[7:]."""
    force, pitch, roll = 0.0, 0.0, 0.0
    for i in range(4):
        x = p[3] if i < 2 else p[3] - p[4]
        y = 0.5 * p[5] if i % 2 == 0 else -0.5 * p[5]
        axle = i // 2
        e = s[0] - x * s[1] + y * s[2] - s[3 + i]
        v = s[7] - x * s[8] + y * s[9] - s[10 + i]
        pull = p[6 + axle] * e + p[8 + axle] * v
        force -= pull
        pitch += x * pull
        roll -= y * pull
        out[10 + i] = (p[11] * (road[i] - s[3 + i]) + pull) / p[10]
    out[7], out[8], out[9] = force / p[0], pitch / p[1], roll / p[2]
    for i in range(7):
        out[i] = s[7 + i]


@kernel
def _drive(p: FloatArray, road: FloatArray, step: float, fine: int, out: FloatArray) -> None:
    """Runge-Kutta of order 4; road (rows * fine * 2 + 1, 4): at half steps. out (rows, 8): body over wheels, hubs."""
    s, mid, total, rate = np.zeros(14), np.zeros(14), np.zeros(14), np.zeros(14)
    for row in range(out.shape[0]):
        for inner in range(fine):
            at = 2 * (row * fine + inner)
            for stage in range(4):
                ahead = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                for i in range(14):
                    mid[i] = s[i] + ahead * step * rate[i]
                _slope(p, mid, road[at + (0 if stage == 0 else (2 if stage == 3 else 1))], rate)
                if stage == 0 and inner == 0:
                    for i in range(4):
                        x = p[3] if i < 2 else p[3] - p[4]
                        y = 0.5 * p[5] if i % 2 == 0 else -0.5 * p[5]
                        out[row, i] = rate[7] - x * rate[8] + y * rate[9]
                        out[row, 4 + i] = rate[10 + i]
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                for i in range(14):
                    total[i] = (0.0 if stage == 0 else total[i]) + weight * rate[i]
            for i in range(14):
                s[i] += step / 6.0 * total[i]


def drive(car: Car, road: FloatArray, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """Body accelerations over the wheels and hub accelerations, each (n, 4), from rest; road: heights (2 FINE n + 1, 4)."""
    rows = (len(road) - 1) // (2 * FINE)
    out = np.zeros((rows, 8))
    _drive(car.figures(), np.ascontiguousarray(road), 1 / (rate_hz * FINE), FINE, out)
    return np.ascontiguousarray(out[:, :4]), np.ascontiguousarray(out[:, 4:])
