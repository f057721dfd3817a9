"""What braking and roll need of the vehicle, with its spread, and what was assumed where the file is silent."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pipelines.estimators.roll_map.priors import (
    TYRE_RATIO,
    damping_prior,
    rigid_tyres,
    stiffness_prior,
)
from pipelines.prepare.roll_angle import TYPICAL_TRACK
from pipelines.results import Assumption
from pipelines.vehicles.kinds import DRIVER, usual_load
from pipelines.vehicles.priors import measured_roll_inertia
from pipelines.vehicles.usual import usual_drag, usual_radius, usual_roll_axis, usual_wheel_inertia
from pipelines.vehicles.vehicle import Quantity, Vehicle

LOAD_BEHIND = (0.5, 0.8)
"""m, how far behind the empty vehicle's CG a load's own lies: a driver little, rear seats 0.8, a boot 1.6, a roof box
hardly. It moves the CG by a decimetre, and a height from slips by g / |a_x| times as much."""

BRAKE_FRONT = (0.68, 0.06)
"""Share of the brakes' torque, usual of road cars."""


@dataclass(frozen=True)
class BrakeRollVehicle:
    """Quantities (None: neither known nor usual). mass, front: loaded, with the load's spread. stiffness, damping: in roll,
    body against the road (tyres in series). centre: roll axis above ground below the CG. gain: brake torque of all
    wheels per Pa."""

    mass: Quantity
    nominal: Quantity
    front: Quantity | None
    wheelbase: Quantity | None
    radius: Quantity
    wheel_inertia: Quantity
    drag_area: Quantity
    gain: Quantity | None
    brake_front: Quantity
    stiffness: Quantity | None
    damping: Quantity | None
    inertia: Quantity | None
    centre: Quantity
    track: Quantity
    assumptions: tuple[Assumption, ...]


class _Ledger:
    """Looks quantities up and writes down where they came from."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.entries: list[Assumption] = []

    def note(self, name: str, quantity: Quantity, unit: str) -> Quantity:
        """Write one down."""
        text = f"{quantity.value:.4g} ± {quantity.std:.2g} {unit}".rstrip()
        self.entries.append(Assumption(name, text, quantity.source))
        return quantity

    def known(self, key: str, unit: str) -> Quantity | None:
        """The file's, or None."""
        found = self.vehicle.get(key)
        return None if found is None else self.note(key, found, unit)

    def usual(self, key: str, pair: tuple[float, float], unit: str) -> Quantity:
        """The file's, or the usual one of road cars."""
        found = self.vehicle.get(key)
        if found is None:
            found = Quantity(pair[0], pair[1], "the vehicle file is silent: usual for road cars")
        return self.note(key, found, unit)


def _masses(book: _Ledger, vehicle: Vehicle) -> tuple[Quantity, Quantity] | None:
    """Loaded mass with the load's spread, and the nominal one (with a driver, where the load is not told)."""
    empty = vehicle.get("mass_kg")
    if empty is None:
        return None
    load = vehicle.load.get("mass_kg")
    if load is not None:
        mass = Quantity(
            empty.value + load.value, math.hypot(empty.std, load.std), "vehicle file with its [load]"
        )
        return book.note("mass (loaded)", mass, "kg"), mass
    usual = usual_load(vehicle, empty.value)
    spread = math.hypot(DRIVER[1], usual.further)
    mass = Quantity(
        empty.value + DRIVER[0] + usual.further,
        math.hypot(empty.std, spread),
        "vehicle file (empty), a driver and an unknown load: there is no [load]",
    )
    nominal = Quantity(empty.value + DRIVER[0], mass.std, "vehicle file (empty) and a driver")
    return book.note("mass (loaded)", mass, "kg"), nominal


def _front(vehicle: Vehicle, mass: Quantity) -> Quantity | None:
    """CG to front axle of the loaded vehicle."""
    empty, unladen = vehicle.get("cg_to_front_axle_m"), vehicle.get("mass_kg")
    if empty is None or unladen is None:
        return None
    load = mass.value - unladen.value
    told = vehicle.load.get("mass_kg")
    usual = usual_load(vehicle, unladen.value)
    spread = math.hypot(DRIVER[1], usual.further) if told is None else told.std
    moved = load / mass.value * LOAD_BEHIND[0]
    std = math.hypot(load / mass.value * LOAD_BEHIND[1], spread / mass.value * LOAD_BEHIND[0])
    return Quantity(empty.value + moved, math.hypot(empty.std, std), f"{empty.source}, moved by the load")


def _centre(vehicle: Vehicle) -> Quantity:
    """Roll axis height below the CG."""
    ends = [q for a in ("front", "rear") if (q := vehicle.get(f"roll_center_height_{a}_m")) is not None]
    if not ends:
        return Quantity(*usual_roll_axis(vehicle), "the vehicle file is silent: usual of its kind")
    if len(ends) == 1:
        return Quantity(ends[0].value, math.hypot(ends[0].std, 0.05), "vehicle file, one axle only")
    a, wheelbase = vehicle.get("cg_to_front_axle_m"), vehicle.get("wheelbase_m")
    share = 0.5 if a is None or wheelbase is None else a.value / wheelbase.value
    value = (1 - share) * ends[0].value + share * ends[1].value
    return Quantity(value, math.hypot((1 - share) * ends[0].std, share * ends[1].std), "vehicle file")


def _series(vehicle: Vehicle, suspension: Quantity, track: Quantity) -> tuple[Quantity, float]:
    """Roll stiffness of the body against the road, and its ratio to the suspension's: the tyres give as well."""
    tyre = vehicle.get("tire_vertical_rate_npm")
    if tyre is None:
        ratio, spread = TYRE_RATIO
        words = f"{suspension.source}; tyres in series taken as {ratio:g} ± {spread:g}"
    else:
        tyres = tyre.value * track.value**2
        ratio = tyres / (tyres + suspension.value)
        spread = ratio * (1 - ratio) * math.hypot(tyre.std / tyre.value, 2 * track.std / track.value)
        words = f"{suspension.source}; tyres in series"
    rigid = rigid_tyres(vehicle)
    spread = math.hypot(spread, math.sqrt(rigid * (1 - rigid)) * (1 - ratio))
    ratio += rigid * (1 - ratio)
    value = suspension.value * ratio
    return Quantity(
        value, value * math.hypot(suspension.std / suspension.value, spread / ratio), words
    ), ratio


def known_of(vehicle: Vehicle) -> BrakeRollVehicle | None:
    """What the vehicle file gives; None without a mass."""
    book = _Ledger(vehicle)
    masses = _masses(book, vehicle)
    if masses is None:
        return None
    tracks = [q for a in ("front", "rear") if (q := vehicle.get(f"track_{a}_m")) is not None]
    track = tracks[0] if tracks else Quantity(*TYPICAL_TRACK, "usual for road cars")
    stiffness = damping = inertia = None
    given = stiffness_prior(vehicle)
    if given is not None:
        stiffness, ratio = _series(vehicle, Quantity(given.value, given.std, given.source), track)
        book.note("roll stiffness against the road", stiffness, "N·m/rad")
        damper = damping_prior(vehicle)
        damping = (
            Quantity(0.07 * stiffness.value, 0.03 * stiffness.value, "usual for road cars")
            if damper is None
            else Quantity(damper.value * ratio, damper.std * ratio, damper.source)
        )
        book.note("roll damping", damping, "N·m·s/rad")
        inertia = _inertia(vehicle, masses[0].value, track)
        book.note("roll inertia", inertia, "kg·m²")
    front = _front(vehicle, masses[0])
    if front is not None:
        book.note("CG to front axle (loaded)", front, "m")
    centre = book.note("roll axis above ground, under the CG", _centre(vehicle), "m")
    radius = book.usual("wheel_radius_m", usual_radius(vehicle), "m")
    return BrakeRollVehicle(
        mass=masses[0],
        nominal=masses[1],
        front=front,
        wheelbase=book.known("wheelbase_m", "m"),
        radius=radius,
        wheel_inertia=book.usual("wheel_inertia_kgm2", usual_wheel_inertia(vehicle, radius.value), "kg·m²"),
        drag_area=book.usual("drag_area_m2", usual_drag(vehicle), "m²"),
        gain=book.known("brake_gain_nmppa", "N·m/Pa"),
        brake_front=book.usual("brake_front_share", BRAKE_FRONT, ""),
        stiffness=stiffness,
        damping=damping,
        inertia=inertia,
        centre=centre,
        track=track,
        assumptions=tuple(book.entries),
    )


def _inertia(vehicle: Vehicle, mass: float, track: Quantity) -> Quantity:
    """Roll inertia of the loaded vehicle: the file's is the empty one's, which a load changes by some ten percent."""
    stated = vehicle.get("roll_inertia_kgm2")
    if stated is not None:
        return Quantity(stated.value, math.hypot(stated.std, 0.1 * stated.value), stated.source)
    prior = measured_roll_inertia(mass, track.value)
    if prior is not None:
        return Quantity(prior.value, prior.std, prior.source)
    value = mass * (0.38 * track.value) ** 2
    return Quantity(value, 0.3 * value, "usual radius of gyration: 0.38 of the track")
