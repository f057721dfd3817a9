"""Static rollover measures, and how near the drive came to them.

SSF = T / (2 h). A body that leans moves its CG outwards: a_y/g at wheel lift = SSF / (1 + R (1 - h_r/h)), with the roll
gradient R in rad per g of horizontal lateral acceleration and the roll axis height h_r.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from parsers.drive import Drive
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import rank_roll
from pipelines.prepare.signals import prepare_signals
from pipelines.results import FloatArray, ParameterEstimate, Rollover
from pipelines.vehicles.vehicle import Quantity, Vehicle

CUTOFF_HZ = 3.0
"""Lateral acceleration is low-passed here before its peak is taken: wheels do not lift for a bump's shock."""

ROLL_CENTRES = ("roll_center_height_front_m", "roll_center_height_rear_m")
USUAL_ROLL_AXIS = 0.08
"""m above ground, where the vehicle file gives no roll centres; 0.07 m more or less moves the threshold by 1 %."""

LEVELS = (0.025, 0.975)
_COUNT = 20_000


def _track(vehicle: Vehicle) -> Quantity | None:
    known = [q for key in ("track_front_m", "track_rear_m") if (q := vehicle.get(key)) is not None]
    if not known:
        return None
    return Quantity(sum(q.value for q in known) / len(known), max(q.std for q in known), "vehicle file")


def _draws(value: float, std: float, rng: np.random.Generator) -> FloatArray:
    """Draws of a positive quantity with this mean and spread (log-normal)."""
    share = math.log(1 + (std / value) ** 2)
    return np.asarray(value * np.exp(math.sqrt(share) * rng.standard_normal(_COUNT) - share / 2))


def _measure(
    name: str, values: FloatArray, height: ParameterEstimate, reason: str, reference: float | None
) -> ParameterEstimate:
    low, high = (float(q) for q in np.quantile(values, LEVELS))
    return ParameterEstimate(
        name, float(values.mean()), float(values.std()), low, high, height.status, reason, None, reference, height.sources
    )  # fmt: skip


def _static(
    verdict: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> tuple[ParameterEstimate | None, ParameterEstimate | None, list[str]]:
    """SSF and threshold in g, with notes on what is missing."""
    height, track = verdict.get("cg_height_m"), _track(vehicle)
    if height is None or height.value is None or not height.std or height.value <= 0:
        return None, None, ["no static stability factor: the CG height is not known"]
    if track is None:
        return None, None, ["no static stability factor: the vehicle file gives no track width"]
    # a fixed seed of its own: these draws carry no information and must not move with anything else
    rng = np.random.default_rng(20_000)
    h = _draws(height.value, height.std, rng)
    ssf = _draws(track.value, max(track.std, 1e-6), rng) / (2 * h)
    true_height = vehicle.reference.get("cg_height_m")
    reference = None if not true_height else track.value / (2 * true_height)
    text = f"track / (2 × CG height); the CG height is {height.status.replace('_', ' ')}"
    factor = _measure("static_stability_factor", ssf, height, text, reference)
    gradient = verdict.get("roll_gradient_degpg")
    if gradient is None or gradient.value is None or gradient.std is None:
        threshold = _measure("threshold_g", ssf, height, "rigid body: the roll gradient is not known", None)
        return factor, threshold, ["the rollover threshold leaves out body roll (no roll gradient)"]
    sensed = np.maximum(gradient.value + gradient.std * rng.standard_normal(_COUNT), 0.0) / DEGREES
    horizontal = sensed / np.maximum(1 - sensed, 0.5)
    centres = [q.value for key in ROLL_CENTRES if (q := vehicle.get(key)) is not None]
    axis = sum(centres) / len(centres) if centres else USUAL_ROLL_AXIS
    leaning = ssf / (1 + horizontal * np.clip(1 - axis / h, 0.0, 1.0))
    text = f"static stability factor, less what body roll takes ({gradient.value:.1f} deg/g)"
    return factor, _measure("threshold_g", leaning, height, text, None), []


def _road_frame(prepared: Prepared, vehicle: Vehicle) -> tuple[FloatArray, str]:
    """Lateral acceleration in the road's plane where the roll angle is known, and which it is."""
    offsets = prepared.standstill_offset
    accel = prepared.columns["accel_y"] - offsets.get("accel_y", (0.0, 0.0))[0]
    ranked = [source for source in rank_roll(prepared, vehicle) if source.kind != "gyro_gravity"]
    if not ranked:
        return accel, "sensed lateral acceleration (body roll adds to it: no roll angle)"
    angle = ranked[0].angle - (offsets.get("roll", (0.0, 0.0))[0] if ranked[0].kind == "measured" else 0.0)
    level = (accel - GRAVITY * np.sin(angle)) / np.cos(angle)
    return np.where(
        np.isfinite(level), level, accel
    ), "lateral acceleration without gravity's part in a leaning body"


def _peak(drive: Drive, vehicle: Vehicle) -> tuple[float, float, str] | None:
    """Largest |a_y| in g, its time, and what it is; None without lateral acceleration."""
    deflections = [n for n in drive.signals if n.startswith("suspension_deflection_")]
    prepared = prepare_signals(
        drive, ["accel_y"], rate_hz=20.0, cutoff_hz=CUTOFF_HZ, optional=["roll", "roll_rate", *deflections]
    )
    if not prepared.segments:
        return None
    values, what = _road_frame(prepared, vehicle)
    best: tuple[float, float] | None = None
    for segment in prepared.segments:
        part = np.abs(values[segment.start : segment.stop])
        row = int(np.argmax(part))
        if best is None or part[row] > best[0]:
            best = float(part[row]), float(prepared.time_s[segment.start + row])
    assert best is not None
    return best[0] / GRAVITY, best[1], what


def assess_rollover(verdict: Mapping[str, ParameterEstimate], vehicle: Vehicle, drive: Drive) -> Rollover:
    """SSF with interval, threshold, the drive's peak lateral acceleration and how much of the SSF it used.

    Parts that cannot be told are None, with a note that says why.
    """
    factor, threshold, notes = _static(verdict, vehicle)
    peak = _peak(drive, vehicle)
    if peak is None:
        notes.append("no peak: the log has no usable lateral acceleration")
        return Rollover(factor, threshold, notes=tuple(notes))
    value, time_s, what = peak
    notes.append(f"peak of the {what}, low-passed at {CUTOFF_HZ:g} Hz")
    coefficient = None
    if factor is not None and factor.value:
        coefficient = value / factor.value
    return Rollover(factor, threshold, value, coefficient, time_s, tuple(notes))
