"""What both base-excitation estimators take from a log: corners with both accelerometers, springs, lively stretches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.estimators.base import Need
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Assumption, FloatArray
from pipelines.vehicles.usual import usual_unsprung_share
from pipelines.vehicles.vehicle import Quantity, Vehicle

SPRUNG, UNSPRUNG = "accel_z_sprung_{}", "accel_z_unsprung_{}"
AXLES = {"front": ("fl", "fr"), "rear": ("rl", "rr")}
LIVELY_BAND_HZ = (0.5, 20.0)
LIVELY_WINDOW_S = 4.0
BUSHES = 0.05
TYRE_LATERAL_PER_LOAD = 20.0
ROLL_CENTRE_M = 0.08
TRACK_M = 1.5
"""What bushes and sticking friction may add to a spring, as a share of it; a tyre's lateral stiffness per wheel load in
1/m (the upper end: cornering stiffness of 8-12 loads per rad over a relaxation length of 0.5-0.8 m); where the vehicle file is silent."""

SIGNAL_NEEDS = (
    Need(tuple(SPRUNG.format(w) for w in WHEELS), "the body's vertical acceleration over a wheel"),
    Need(tuple(UNSPRUNG.format(w) for w in WHEELS), "the same wheel's hub, which is the known input"),
)
VEHICLE_NEEDS = (
    Need(
        ("spring_rate_front_npm", "spring_rate_rear_npm"), "all masses come in proportion to the spring rate"
    ),
)


@dataclass(frozen=True)
class RideData:
    """Accelerations of the corners that can be used: (n,) each, no mean over a stretch (gravity and offsets are gone).

    corners: wheels with both sensors and a known spring rate, in the order of WHEELS. stretches: rows without gaps.
    lively: (n,) the hubs move enough. hub_rms: over all of the drive, in m/s². why_not: "" or why nothing can be used.
    """

    corners: tuple[str, ...]
    sprung: dict[str, FloatArray]
    unsprung: dict[str, FloatArray]
    springs: dict[str, Quantity]
    stretches: tuple[tuple[int, int], ...]
    rate_hz: float
    lively: np.ndarray
    hub_rms: float
    why_not: str = ""


def wheels_with_both(names: Sequence[str]) -> tuple[str, ...]:
    """Wheels of which a log holds both accelerations."""
    return tuple(w for w in WHEELS if SPRUNG.format(w) in names and UNSPRUNG.format(w) in names)


def prepare_ride(drive: Drive, cutoff_hz: float) -> Prepared:
    """Both accelerations of every wheel that has them, on one clock and low-passed alike; speed where it is there."""
    wheels = wheels_with_both(tuple(drive.signals))
    wanted = [form.format(w) for w in wheels for form in (SPRUNG, UNSPRUNG)]
    if not wanted:
        wanted = [SPRUNG.format(WHEELS[0]), UNSPRUNG.format(WHEELS[0])]
    return prepare_signals(drive, wanted, rate_hz=None, cutoff_hz=cutoff_hz, optional=["speed"])


def axle_of(wheel: str) -> str:
    """ "front" or "rear"."""
    return "front" if wheel.startswith("f") else "rear"


def spring_of(vehicle: Vehicle, wheel: str) -> Quantity | None:
    """The spring rate at that wheel."""
    return vehicle.get(f"spring_rate_{axle_of(wheel)}_npm")


def _band_power(column: FloatArray, rate_hz: float) -> FloatArray:
    """Square of the column within LIVELY_BAND_HZ, averaged over LIVELY_WINDOW_S, (n,)."""
    n = len(column)
    frequency = np.fft.rfftfreq(n, 1 / rate_hz)
    inside = (frequency >= LIVELY_BAND_HZ[0]) & (frequency <= LIVELY_BAND_HZ[1])
    band = np.fft.irfft(np.fft.rfft(column) * inside, n)
    width = min(n, max(1, round(LIVELY_WINDOW_S * rate_hz)))
    total = np.concatenate(([0.0], np.cumsum(band**2)))
    first = np.clip(np.arange(n) - width // 2, 0, n - width)
    return np.asarray((total[first + width] - total[first]) / width)


def collect_ride(prepared: Prepared, vehicle: Vehicle, least_mps2: float) -> RideData:
    """The usable corners. Where nothing can be used, `why_not` says it in words and `corners` may be empty."""
    both = wheels_with_both(tuple(prepared.columns))
    springs = {w: q for w in both if (q := spring_of(vehicle, w)) is not None and q.value > 0}
    corners = tuple(w for w in both if w in springs)
    stretches = tuple((s.start, s.stop) for s in prepared.segments)
    rows = len(prepared.time_s)
    lively = np.zeros(rows, dtype=bool)
    sprung: dict[str, FloatArray] = {}
    unsprung: dict[str, FloatArray] = {}
    power = np.zeros(rows)
    for form, into in ((SPRUNG, sprung), (UNSPRUNG, unsprung)):
        for w in corners:
            column = np.zeros(rows)
            for start, stop in stretches:
                piece = prepared.columns[form.format(w)][start:stop]
                column[start:stop] = piece - piece.mean()
                if form is UNSPRUNG:
                    power[start:stop] += _band_power(column[start:stop], prepared.rate_hz) / len(corners)
            into[w] = column
    for start, stop in stretches:
        lively[start:stop] = power[start:stop] >= least_mps2**2
    used = sum(stop - start for start, stop in stretches)
    hub_rms = math.sqrt(float(power.sum()) / max(used, 1))
    why = ""
    if not corners:
        missing = "no wheel with both accelerations" if not both else "no spring rate in the vehicle file"
        why = f"{missing}: the mass comes in proportion to the spring rate at the wheel"
    elif not stretches:
        why = "; ".join(prepared.notes) or "no stretch of the drive holds both accelerations"
    elif not lively.any():
        why = (
            f"the hubs hardly move ({hub_rms:.2g} m/s² RMS from {LIVELY_BAND_HZ[0]:g} to {LIVELY_BAND_HZ[1]:g} Hz, "
            f"{least_mps2:g} are needed): drive over rough ground"
        )
    return RideData(corners, sprung, unsprung, springs, stretches, prepared.rate_hz, lively, hub_rms, why)


def unsprung_masses(vehicle: Vehicle, sprung_kg: float) -> tuple[tuple[float, float], float, Assumption]:
    """Unsprung mass of the front and the rear axle, the standard deviation of their sum, and where it is from."""
    front, rear = vehicle.get("unsprung_mass_front_kg"), vehicle.get("unsprung_mass_rear_kg")
    if front is not None and rear is not None:
        std = math.hypot(front.std, rear.std)
        words = f"{front.value:.0f} + {rear.value:.0f} ± {std:.0f} kg"
        return (front.value, rear.value), std, Assumption("unsprung mass", words, front.source)
    empty = vehicle.get("mass_kg")
    share = usual_unsprung_share(vehicle)
    whole = empty.value if empty is not None else sprung_kg / (1 - share[0])
    mean, std = share[0] * whole, share[1] * whole
    known = front or rear
    parts = (mean / 2, mean / 2)
    if known is not None:
        other = max(mean - known.value, 0.3 * mean)
        parts = (known.value, other) if front is not None else (other, known.value)
        std = math.hypot(known.std, 0.25 * other)
    words = f"{sum(parts):.0f} ± {std:.0f} kg"
    return parts, std, Assumption("unsprung mass", words, "the vehicle file is silent: usual for cars")


def stiffness_beyond_springs(vehicle: Vehicle, axle: str, wheel_load_kg: float) -> float:
    """How much stiffer than its springs an axle's suspension may be in heave, as a share of the spring rate; an upper end.

    Bushes and friction that does not slip act as springs. And a wheel that moves up moves sideways by the slope of its
    guide, about 2 h / t for a roll centre h above ground: the tyre resists with its lateral stiffness, of which the slope
    takes its square back to the vertical. Whatever is stiffer than assumed makes the mass seem smaller, never larger.
    """
    centre = vehicle.get(f"roll_center_height_{axle}_m")
    height = abs(centre.value) + centre.std if centre is not None else ROLL_CENTRE_M
    track = vehicle.get(f"track_{axle}_m")
    slope = 2 * height / (track.value if track is not None else TRACK_M)
    spring = vehicle.get(f"spring_rate_{axle}_npm")
    if spring is None:
        return BUSHES
    lateral = TYRE_LATERAL_PER_LOAD * 9.80665 * max(wheel_load_kg, 0.0)
    return BUSHES + lateral * slope**2 / spring.value


def stiffer(front_kg: float, rear_kg: float, vehicle: Vehicle) -> tuple[float, float]:
    """`stiffness_beyond_springs` of the front and the rear axle under these sprung masses."""
    return (
        stiffness_beyond_springs(vehicle, "front", front_kg / 2),
        stiffness_beyond_springs(vehicle, "rear", rear_kg / 2),
    )


def spring_assumptions(data: RideData) -> tuple[Assumption, ...]:
    """The spring rates that were used."""
    axles = {axle_of(w): data.springs[w] for w in data.corners}
    return tuple(
        Assumption(f"spring_rate_{axle}_npm (a wheel)", f"{q.value:.0f} ± {q.std:.0f} N/m", q.source)
        for axle, q in axles.items()
    )
