"""The matched plant: a vehicle of the dissertation's size whose strut forces are those of the model itself, plus noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.load_transfer.kernels import HFLTM, LTM
from pipelines.models.load_transfer import (
    Motion,
    Size,
    corners_from_imu,
    hfltm_forces,
    ltm_forces,
    mltm_forces,
)
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

RATE_HZ = 1000.0
SIZE = Size(3.30, 1.82)
MASS, BEHIND, LEFT = 1940.0, 1.70, 0.88
ROLL_ARM, PITCH_ARM, DRAG = 0.70, 0.75, 0.80
ARMS = np.array([0.80, 0.70, 0.70, 0.60, 0.75])
"""The dissertation's off-road vehicle as far as it is printed: 2400 kg on scales with 500 kg unsprung (8.1); the rest ours."""


@dataclass(frozen=True)
class Matched:
    """A drive at 1 kHz: motion, vertical accelerations over the struts (n, 4), and corner masses (4,)."""

    motion: Motion
    corners: FloatArray
    masses: FloatArray


def corner_masses(cross_kg: float = 0.0) -> FloatArray:
    """(4,) of the lumped mass; cross_kg moved from fl to fr and from rr to rl (Figure 6.6)."""
    front, left = 1 - BEHIND / SIZE.wheelbase, 1 - LEFT / SIZE.track
    shares = np.array([front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left)])
    return np.asarray(MASS * shares + cross_kg * np.array([-1.0, 1.0, 1.0, -1.0]))


def _waves(
    time_s: FloatArray, band: tuple[float, float], size: float, rng: np.random.Generator
) -> FloatArray:
    """Twelve sines of random frequency and phase, of a standard deviation of `size`, from rest over the first 4 s."""
    total = np.zeros(len(time_s))
    for frequency in np.exp(rng.uniform(math.log(band[0]), math.log(band[1]), 12)):
        total += np.sin(2 * np.pi * (frequency * time_s + rng.random()))
    ramp = np.clip(time_s / 4, 0, 1)
    return np.asarray(size / np.sqrt(6) * total * ramp * ramp * (3 - 2 * ramp))


def matched_drive(
    seconds: float,
    rng: np.random.Generator,
    *,
    harsh: float = 1.0,
    cross_kg: float = 0.0,
    rate_hz: float = RATE_HZ,
) -> Matched:
    """A drive with cornering, braking and a rough road. harsh: factor on the horizontal accelerations (1: rural)."""
    t = np.arange(round(seconds * rate_hz)) / rate_hz
    along, across = _waves(t, (0.03, 0.4), 1.2 * harsh, rng), _waves(t, (0.03, 0.5), 2.0 * harsh, rng)
    heave = GRAVITY + _waves(t, (0.6, 8.0), 0.6, rng)
    roll, pitch = _waves(t, (0.6, 6.0), 0.8, rng), _waves(t, (0.6, 6.0), 0.5, rng)
    speed = np.maximum(18 + _waves(t, (0.01, 0.05), 5.0, rng), 3.0)
    corners = corners_from_imu(heave, roll, pitch, (BEHIND, SIZE.track / 2 - LEFT), SIZE)
    motion = Motion(along, across, heave, 0.010 * across, -0.004 * along, speed)
    return Matched(motion, corners, corner_masses(cross_kg))


def forces_at(model: int, drive: Matched, p: FloatArray) -> FloatArray:
    """(n, 4) strut forces of a model with its parameters in the order of the filter's state, N."""
    if model == LTM:
        return ltm_forces(drive.motion, SIZE, *(float(v) for v in p))
    if model == HFLTM:
        return hfltm_forces(drive.motion, drive.corners, SIZE, p[:4], p[4:])
    return mltm_forces(drive.motion, drive.corners, SIZE, p[:4], float(p[4]), float(p[5]), float(p[6]))


def forces(model: int, drive: Matched) -> FloatArray:
    """(n, 4) true strut forces, N. A diagonal shift loads the struts beside the LTM's own."""
    found = forces_at(model, drive, truth(model, drive))
    if model == LTM:
        found = found + (drive.masses - corner_masses()) * drive.motion.vertical[:, None]
    return np.asarray(found)


def truth(model: int, drive: Matched) -> FloatArray:
    """True parameters in the order of the filter's state."""
    if model == LTM:
        return np.array([MASS, BEHIND, LEFT, ROLL_ARM, PITCH_ARM, DRAG])
    if model == HFLTM:
        return np.concatenate((drive.masses, ARMS))
    return np.concatenate((drive.masses, [ROLL_ARM, PITCH_ARM, DRAG]))
