"""Vertical forces in another unit than the log says: what they carry against the mass in the vehicle file.

Struts, tyres or axles in kgf under a header that says newtons carry a tenth of any such vehicle, and every balance of forces and moments alone
still closes: a mass of 194 kg and inertias of a fifth come out with intervals of some per cent. No load, wheel that is missing or
wrong figure of a file makes four times too much or too little at once, so a unit that explains it is named. Which of two that are next to
each other (kgf, daN) it is the log does not say, so the signals are left out until a mapping file does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.checks.check import as_applied
from parsers.drive import Decision, Drive
from parsers.quantiles import median
from parsers.signals import WHEELS
from parsers.units import STANDARD_GRAVITY
from pipelines.prepare.decided import decided
from pipelines.vehicles.mass_limits import LEAST_SPRUNG, loaded_limits
from pipelines.vehicles.vehicle import Vehicle

UNITS = (("kN", 1000.0), ("kgf", STANDARD_GRAVITY), ("daN", 10.0), ("lbf", 4.448))
"""What newtons are taken for, and N in it."""
BEYOND = 2.0
"""Beyond what the vehicle file allows by that factor nothing else explains it."""
NEAR = 1.2
"""What a unit explains it leaves within the limits by that."""
AXLE = (0.28, 0.85)
"""Share of the mass on one axle of two."""
ZEROED = 0.5
"""Median deviation from the median, as a share of it, from which on the weight is not in the forces: no unit makes a vehicle of them."""


@dataclass(frozen=True)
class _Carried:
    """names: signals of one kind; share: least and most share of the vehicle's mass that stands on them."""

    names: tuple[str, ...]
    share: tuple[float, float]

    @property
    def text(self) -> str:
        if len(self.names) == 1:
            return f"{self.names[0]} carries"
        return f"{self.names[0]} {'to' if len(self.names) > 2 else 'and'} {self.names[-1]} carry"


def _kinds(drive: Drive) -> Iterator[_Carried]:
    """Sets of forces that are there as a whole: four wheels, else an axle's two; both axles, else one."""
    for kind, least in (("suspension_force", LEAST_SPRUNG), ("tire_normal_force", 1.0)):
        axles = [tuple(f"{kind}_{w}" for w in WHEELS if w[0] == end) for end in "fr"]
        yield from _of_axles(drive, axles, least)
    yield from _of_axles(drive, [("axle_load_front",), ("axle_load_rear",)], 1.0)


def _of_axles(drive: Drive, axles: list[tuple[str, ...]], least: float) -> Iterator[_Carried]:
    there = [
        names for names in axles if all(n in drive.signals and len(drive.signals[n].values) for n in names)
    ]
    if len(there) == len(axles):
        yield _Carried(tuple(name for names in there for name in names), (least, 1.0))
    elif there:
        yield _Carried(there[0], (least * AXLE[0], AXLE[1]))


def _fault(drive: Drive, carried: _Carried, mass_kg: tuple[float, float], stated_kg: float) -> list[Decision]:
    columns = [drive.signals[name].values for name in carried.names]
    middles = [median(column) for column in columns]
    sways = sum(median(np.abs(column - middle)) for column, middle in zip(columns, middles, strict=True))
    kilos = abs(sum(middles)) / STANDARD_GRAVITY
    low, high = carried.share[0] * mass_kg[0], carried.share[1] * mass_kg[1]
    beyond = kilos <= low / BEYOND or kilos >= high * BEYOND
    # NaN, where a signal has no values, is neither
    if not beyond or not sways < ZEROED * kilos * STANDARD_GRAVITY:
        return []
    small = [name for name, newtons in UNITS if low / NEAR < kilos * newtons < high * NEAR]
    large = [name for name, newtons in UNITS if low / NEAR < kilos / newtons < high * NEAR]
    if not small and not large:
        return []
    found, taken = (" or ".join(small), "N") if small else ("N", " or ".join(large))
    return [
        Decision(
            name, "unit", f"{name} is in {found}, not in {taken}, or the mass in the vehicle file is wrong",
            "left out: say the unit in a mapping file, or mend the vehicle file",
            f"{carried.text} {kilos:.4g} kg in the median, the vehicle file states {stated_kg:.4g} kg empty", applied=True,
        )
        for name in carried.names
    ]  # fmt: skip


def forces_in_newtons(drive: Drive, vehicle: Vehicle, *, fix: bool = True) -> Drive:
    """The drive without forces that are surely in another unit, and a decision for each; itself where the file states no mass.

    fix=False: only said.
    """
    mass, limits = vehicle.get("mass_kg"), loaded_limits(vehicle)
    if mass is None or limits is None:
        return drive
    said = [each for carried in _kinds(drive) for each in _fault(drive, carried, limits, mass.value)]
    left = {each.signal for each in said} if fix else set()
    return decided(
        drive, as_applied(said, fix=fix), {name: s for name, s in drive.signals.items() if name not in left}
    )
