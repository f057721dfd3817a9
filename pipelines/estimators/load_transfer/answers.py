"""From what stands on the struts to the whole vehicle's parameters, with everything that is not exactly known.

Struts carry the sprung mass. The whole vehicle has the unsprung masses of the vehicle file below them, at the axles:

    m = m_s + m_uf + m_ur,   a = (m_s a_s + m_ur L) / m,   y = m_s y_s / m,   corner_i = F_i / g + m_u / 2
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.estimators.axle_load_gls.known import rolling_arm
from pipelines.estimators.load_transfer.batch import STATIC, BatchFit
from pipelines.estimators.load_transfer.data import Known, StrutData
from pipelines.models.roll import GRAVITY
from pipelines.results import Assumption, FloatArray, Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

MASSES: tuple[str, ...] = tuple(f"corner_mass_{w}_kg" for w in WHEELS)
GIVEN: tuple[str, ...] = (
    "mass_kg", "sprung_mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", *MASSES, "roll_arm_m", "pitch_arm_m",
    "drag_area_m2",
)  # fmt: skip

USUAL_ARM = 0.55
"""m, what an arm is taken for where only the effect of a small offset hangs on it."""
FRICTION_N = 40.0
"""What stuck springs leave in one strut in the mean of a drive: it moves round the four, total and moments stay."""


@dataclass(frozen=True)
class Errors:
    """Standard deviations of what strut force sensors may be wrong by: share of the load, and N."""

    scale: float
    offset: float


@dataclass(frozen=True)
class Standing:
    """Static strut loads (4,) N with covariance (4, 4) N² of all that moves them round or changes them alike.

    shift: what is added to a, m: mean and standard deviation; aside: the same for y.
    """

    loads: FloatArray
    covariance: FloatArray
    shift: tuple[float, float]
    aside: tuple[float, float]


def sensors_covariance(loads: FloatArray, errors: Errors) -> FloatArray:
    """(4, 4) of independent scale errors and offsets."""
    return np.diag((errors.scale * loads) ** 2 + errors.offset**2)


def about_cg(found: BatchFit, known: Known) -> FloatArray:
    """(4,) levers of the struts behind the sprung CG, m: what the links lift of the whole body has no moment there."""
    loads = found.coefficients[STATIC]
    behind = float(loads[2:].sum() / loads.sum())
    return known.wheelbase.value * np.array([-behind, -behind, 1 - behind, 1 - behind])


def level_doubt(data: StrutData, arms: tuple[float, float]) -> tuple[float, float]:
    """What the offsets left in the horizontal forces do to a and y through pitch and roll arm, m (std)."""
    return arms[1] * data.offset_std[0] / GRAVITY, arms[0] * data.offset_std[1] / GRAVITY


def rolling_shift(vehicle: Vehicle, known: Known) -> tuple[float, float]:
    """By how much rolling resistance makes a seem larger than standing scales show, m: mean, std."""
    mean, std, _ = rolling_arm(vehicle, known.wheelbase.value)
    return -mean, std


def _whole(q: FloatArray) -> FloatArray:
    """(8,) mass, sprung mass, a, y, corners from loads (4), L, tracks (2), unsprung (2), shift, aside."""
    loads, (length, front, rear, under_front, under_rear, shift, aside) = q[:4], q[4:]
    total = loads.sum()
    sprung = total / GRAVITY
    mass = sprung + under_front + under_rear
    behind = length * (loads[2] + loads[3]) / total
    left = 0.5 * (front * (loads[0] - loads[1]) + rear * (loads[2] - loads[3])) / total
    corners = loads / GRAVITY + 0.5 * np.array([under_front, under_front, under_rear, under_rear])
    corners = corners + 0.5 * mass * shift / length * np.array([-1, -1, 1, 1])
    corners = corners + mass * aside / (front + rear) * np.array([1, -1, 1, -1])
    return np.array(
        [
            mass,
            sprung,
            (sprung * behind + under_rear * length) / mass + shift,
            sprung * left / mass + aside,
            *corners,
        ]
    )


def whole_vehicle(standing: Standing, known: Known) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of mass, sprung mass, CG place and corner masses."""
    beside = [known.wheelbase, *known.track, *known.unsprung]
    q = np.concatenate((standing.loads, [b.value for b in beside], [standing.shift[0], standing.aside[0]]))
    std = np.array([*(b.std for b in beside), standing.shift[1], standing.aside[1]])
    covariance = np.zeros((11, 11))
    covariance[:4, :4] = standing.covariance
    covariance[4:, 4:] = np.diag(std**2)
    values = _whole(q)
    step = np.maximum(1e-6 * np.abs(q), 1e-6)
    slopes = np.column_stack(
        [(_whole(q + h) - _whole(q - h)) / (2 * s) for h, s in zip(np.diag(step), step, strict=True)]
    )
    spread = np.einsum("ij,jk,ik->i", slopes, covariance, slopes)
    # stuck springs: only the corners see them
    spread[4:] += (FRICTION_N / GRAVITY) ** 2
    names = ("mass_kg", "sprung_mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", *MASSES)
    return {n: (float(v), math.sqrt(float(s))) for n, v, s in zip(names, values, spread, strict=True)}


_LIMITS: Mapping[str, tuple[float, float]] = {
    "mass_kg": (0.02, 0.08), "sprung_mass_kg": (0.02, 0.08), "roll_arm_m": (0.08, 0.3), "pitch_arm_m": (0.08, 0.3),
    "drag_area_m2": (0.0, 0.6), **dict.fromkeys(MASSES, (0.03, 0.1)),
}  # fmt: skip
"""Largest standard deviation over value for "identified" and "weak"; of the CG's place over its length below."""
_PLACE = (0.012, 0.05)


def status_of(name: str, value: float, std: float, known: Known) -> Identification:
    """How well a parameter is told by its spread."""
    if name in _LIMITS:
        good, fair = _LIMITS[name]
        share = std / max(abs(value), 1e-12)
    else:
        good, fair = _PLACE
        share = std / (known.wheelbase.value if name == "cg_to_front_axle_m" else known.size.track)
    return "identified" if share <= good else "weak" if share <= fair else "not_identifiable"


def contradiction(standing: Standing, data: StrutData, vehicle: Vehicle) -> str | None:
    """Why the strut forces cannot be those of this vehicle, in words; None where they can."""
    loads = standing.loads
    if loads.min() <= 0:
        return "a strut carries less than nothing in the mean: check signs and units of the suspension forces"
    if loads[2:].sum() / loads.sum() < 0.15 or loads[2:].sum() / loads.sum() > 0.85:
        return "one axle carries nearly everything: check the suspension forces' units and wheels"
    moved = data.forces.std(axis=0)
    if data.moving and moved.min() < 0.05 * moved.max():
        return f"the suspension force {WHEELS[int(np.argmin(moved))]} hardly changes while the others do: a dead sensor"
    mass = vehicle.get("mass_kg")
    sprung = loads.sum() / GRAVITY
    if mass is not None and not 0.6 * mass.value < sprung < 2.2 * mass.value:
        return f"the struts carry {sprung:.0f} kg, the vehicle file says {mass.value:.0f} kg empty: check units and vehicle file"
    return None


def parameter(
    name: str, value: float, std: float, reason: str, known: Known, vehicle: Vehicle, source: str
) -> ParameterEstimate:
    """One answer; without figures where its spread tells nothing."""
    status = status_of(name, value, std, known)
    reference = vehicle.reference.get(name)
    if status == "not_identifiable":
        words = f"{reason}; its spread ({std:.3g}) is too wide to tell anything"
        return ParameterEstimate(name, None, None, None, None, status, words, None, reference)
    half = 1.96 * std
    return ParameterEstimate(
        name, value, std, value - half, value + half, status, reason, None, reference, (source,)
    )


def unknown(name: str, reason: str, vehicle: Vehicle) -> ParameterEstimate:
    """An answer that this drive does not give."""
    return ParameterEstimate(
        name, None, None, None, None, "not_identifiable", reason, None, vehicle.reference.get(name)
    )


def softened(entry: ParameterEstimate) -> ParameterEstimate:
    """The same, called weak where it was called identified."""
    return replace(entry, status="weak") if entry.status == "identified" else entry


def assumptions(data: StrutData, known: Known, errors: Errors) -> tuple[Assumption, ...]:
    """What was taken as given."""
    names = (
        "wheelbase_m",
        "track_front_m",
        "track_rear_m",
        "unsprung_mass_front_kg",
        "unsprung_mass_rear_kg",
    )
    quantities = (known.wheelbase, *known.track, *known.unsprung)
    found = [
        Assumption(n, f"{q.value:.4g} ± {q.std:.2g}", q.source)
        for n, q in zip(names, quantities, strict=True)
    ]
    found.append(
        Assumption(
            "strut force sensors",
            f"scale within {errors.scale:.1%}, offset within {errors.offset:.0f} N",
            "settings",
        )
    )
    found += [Assumption("signals", words, "log") for words in data.words]
    found.append(
        Assumption(
            "level road",
            f"mean grade and cross slope of the drive near 0: {data.offset_std[0]:.2f} and {data.offset_std[1]:.2f} m/s² left",
            "speed, yaw rate and what sensors usually are off by",
        )
    )
    return tuple(found)
