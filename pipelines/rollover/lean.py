"""How the body leans against the road, from what the drive has: deflections, an angle, a gyro, or the acceleration alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource, rank_roll
from pipelines.results import FloatArray
from pipelines.rollover.body import USUAL_DAMPING, USUAL_HZ, Body
from pipelines.rollover.zero import PLACE_STD_G, angle_zero
from pipelines.vehicles.vehicle import Vehicle

BANK_HZ = 0.1
"""Below this frequency the steady roll of the sensed acceleration says how the body leans, above it the angle: an angle
against the horizon holds the road's bank and its own offset, the sensed acceleration neither."""

TIRE_SAG, USUAL_TIRE_SHARE = 0.02, 1.2
"""m of squash of the tyres under the standing vehicle, where the vehicle file is silent; and how much more than against
its axles a body then leans."""

USUAL_GRADIENT = math.radians(5.5)
SWING_STD = 0.5
"""Relative error of the roll's dynamic part where neither an angle nor a gyro shows it."""


@dataclass(frozen=True)
class Lean:
    """Body roll against the road, rad, 0 at rest: (n,). gain: relative error of its scale; it follows the gradient where
    `steady`. std: of its offset, rad. how: in words. swing: (n,) its dynamic part where that is guessed, else 0."""

    angle: FloatArray
    steady: bool
    gain: float
    std: float
    how: str
    swing: FloatArray


def tire_share(body: Body | None, vehicle: Vehicle, mass_kg: float | None) -> float:
    """How much more the body leans against the road than against its axles: the tyres' part, from static figures."""
    if body is None:
        return USUAL_TIRE_SHARE
    rate = vehicle.get("tire_vertical_rate_npm")
    sag = TIRE_SAG if rate is None or mass_kg is None else mass_kg * GRAVITY / (4 * rate.value)
    height, track, gradient = (float(np.median(x)) for x in (body.height, body.track, body.gradient))
    tires = 4 * sag * height / track**2
    return gradient / max(gradient - tires, 0.6 * gradient) if body.gradient_known else 1.0 + tires / gradient


def _blended(prepared: Prepared, angle: FloatArray, steady: FloatArray) -> FloatArray:
    """The angle above BANK_HZ, the steady roll below it."""
    found = np.array(steady)
    for s in prepared.segments:
        part = slice(s.start, s.stop)
        apart = angle[part] - steady[part]
        if np.isfinite(apart).all():
            found[part] = angle[part] - lowpass(apart, prepared.rate_hz, BANK_HZ)
    return found


def deflected(
    prepared: Prepared, accel: FloatArray, source: RollSource, share: float
) -> tuple[FloatArray, bool]:
    """Roll against the road from deflections: the axles' part added, nought when going straight; whether a place's slope is in that."""
    zero, sloped = angle_zero(prepared, accel, source.angle)
    return np.asarray(share * (source.angle - zero)), sloped


def _swung(prepared: Prepared, steady: FloatArray, hertz: float, damping: float) -> FloatArray:
    """Roll that follows its steady value as a mass on spring and damper does; segment by segment, at rest before it."""
    from scipy.signal import bilinear, lfilter, lfilter_zi

    omega = 2 * np.pi * hertz
    top, bottom = bilinear([omega**2], [1.0, 2 * damping * omega, omega**2], fs=prepared.rate_hz)
    found = np.array(steady)
    for s in prepared.segments:
        part = steady[s.start : s.stop]
        found[s.start : s.stop] = lfilter(top, bottom, part, zi=lfilter_zi(top, bottom) * part[0])[0]
    return found


def lean_of(
    prepared: Prepared, vehicle: Vehicle, accel: FloatArray, body: Body | None, mass_kg: float | None
) -> Lean:
    """The best that the drive has. accel: (n,) sensed lateral acceleration less its offset."""
    gradient = USUAL_GRADIENT if body is None else float(np.median(body.gradient))
    known = body is not None and body.gradient_known
    steady = gradient * accel / GRAVITY
    still = np.zeros(len(accel))
    ranked: dict[str, RollSource] = {source.kind: source for source in rank_roll(prepared, vehicle)}
    turned = next((ranked[kind] for kind in ("measured", "gyro_gravity") if kind in ranked), None)
    what = "measured roll angle" if "measured" in ranked else "integrated roll rate"
    if "deflections" in ranked:
        share = tire_share(body, vehicle, mass_kg)
        angle, sloped = deflected(prepared, accel, ranked["deflections"], share)
        angle = np.where(np.isfinite(angle), angle, steady)
        text = f"body roll from suspension deflections, {share:.2f} times for the tyres"
        if turned is not None:
            # deflections do not see the axles tilt once a side's wheels are off: an angle against the horizon does
            angle = _blended(prepared, turned.angle, angle)
            text += f", below {BANK_HZ:g} Hz, from the {what} above"
        return Lean(
            angle, False, 0.04, math.hypot(0.003, gradient * PLACE_STD_G if sloped else 0.0), text, still
        )
    if turned is not None and (known or turned.kind == "gyro_gravity"):
        text = f"body roll from the {what} above {BANK_HZ:g} Hz, from the roll gradient below"
        angle = _blended(prepared, turned.angle, steady)
        return Lean(angle, True, 0.03, 0.003, text if known else f"{text}, a usual one", still)
    if turned is not None:
        zero, sloped = angle_zero(prepared, accel, turned.angle)
        angle = turned.angle - zero
        why = (
            "the vehicle is not known: mass_kg and body in a vehicle file would tell them apart"
            if body is None
            else "no roll gradient is identified that would tell them apart"
        )
        text = f"body roll from the measured roll angle: the road's bank is in it ({why})"
        std = math.hypot(0.02, PLACE_STD_G if sloped else 0.0)
        return Lean(np.where(np.isfinite(angle), angle, steady), False, 0.05, std, text, still)
    hertz, damping = (USUAL_HZ, USUAL_DAMPING) if body is None else (body.roll_hz, body.roll_damping)
    angle = _swung(prepared, steady, hertz, damping)
    text = (
        "body roll from the roll gradient and the sensed acceleration, swinging as vehicles do: no roll angle"
    )
    return Lean(angle, True, 0.05, 0.003, text if known else f"{text}, and a usual gradient", angle - steady)
