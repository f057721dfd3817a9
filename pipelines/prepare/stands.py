"""A drive's rests, cut into stands of a few seconds, and what the wheels carried at each.

Wheels that stand carry the weight and what their springs' friction holds, and no motion: a load that is put in or taken out shows
there, and nowhere as plainly. Deflections tell it by the spring rates, forces and axle loads by themselves.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.joint.vehicle.unknowns import AXLES
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import BoolArray
from pipelines.prepare.resample import on_grid
from pipelines.prepare.spans import runs
from pipelines.prepare.spikes import without_spikes
from pipelines.prepare.standstill import SPEEDS, find_standstill
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

RATE_HZ = 10.0
MOST_ROWS = 5_000_000
ROCKS_S, TRIM_S = 1.0, 0.3
"""Left out after a stop, while the body rocks, and before motion begins."""
STAND_S = 4.0
LEAST_S = 1.0
MOST_STANDS = 300
"""Beyond it rests are passed over evenly: a day of deliveries has no more stops than that."""

USUAL_KG = 1800.0
CARRIERS = ("tire_normal_force", "axle_load", "suspension_force", "suspension_deflection")
"""What tells static load, the most direct first."""


@dataclass(frozen=True)
class Stands:
    """Stands in the order of time. rest: (n,) number of the standstill that each is a piece of; begin_s, end_s: (n,) from the
    drive's start; along, across: (n,) what the accelerometers read, m/s², 0 where there are none. loads: carrier -> (n, 4) N at
    fl, fr, rl, rr, or (n, 2) at front and rear: of the sprung mass above the springs' zero, for deflections."""

    rest: NDArray[np.int64]
    begin_s: FloatArray
    end_s: FloatArray
    along: FloatArray
    across: FloatArray
    loads: dict[str, FloatArray]


def names_of(carrier: str) -> tuple[str, ...]:
    """Its signals, wheel by wheel or axle by axle."""
    return tuple(f"{carrier}_{place}" for place in (AXLES if carrier == "axle_load" else WHEELS))


def spring_rates(vehicle: Vehicle) -> tuple[FloatArray, float]:
    """Rate at each wheel, N/m, (4,), and the relative spread of the rates: stated, else as before any log (`joint.vehicle.unknowns`)."""
    mass = vehicle.get("mass_kg")
    corner = 0.23 * (USUAL_KG if mass is None else mass.value)
    rates, spread = [], []
    for axle in AXLES:
        known = vehicle.get(f"spring_rate_{axle}_npm")
        rate, std = (70.0 * corner, 40.0 * corner) if known is None else (known.value, known.std)
        rates += [rate, rate]
        spread.append(std / rate)
    return np.array(rates), max(spread)


def _pieces(still: BoolArray) -> list[tuple[int, int, int]]:
    """(number of the rest, first row, past the last) of every stand."""
    pieces = []
    for number, (first, past) in enumerate(runs(still)):
        begin = first if first == 0 else first + round(ROCKS_S * RATE_HZ)
        end = past - round(TRIM_S * RATE_HZ)
        if end - begin < LEAST_S * RATE_HZ:
            continue
        count = max(1, round((end - begin) / (STAND_S * RATE_HZ)))
        # a rest of hours tells no more than one of a minute, but must be cut finely enough to see a load change in it
        edges = np.linspace(begin, end, min(count, 20) + 1).astype(int)
        pieces += [(number, int(a), int(b)) for a, b in itertools.pairwise(edges)]
    if len(pieces) > MOST_STANDS:
        pieces = [pieces[i] for i in np.linspace(0, len(pieces) - 1, MOST_STANDS).astype(int)]
    return pieces


def find_stands(drive: Drive, vehicle: Vehicle) -> Stands | None:
    """The drive's stands; None without static loads, without a speed that tells rest, or with fewer than two stands."""
    usable = {name: s for name, s in drive.signals.items() if len(s.time_ns) > 1}
    carriers = [c for c in CARRIERS if all(name in usable for name in names_of(c))]
    if not carriers or not any(name in usable for name in SPEEDS):
        return None
    needed = [usable[name] for c in carriers for name in names_of(c)]
    start_ns = max(int(s.time_ns[0]) for s in needed)
    rows = int((min(int(s.time_ns[-1]) for s in needed) - start_ns) / 1e9 * RATE_HZ) + 1
    if not 2 <= rows <= MOST_ROWS:
        return None
    pieces = _pieces(find_standstill(drive, start_ns, rows, RATE_HZ)[0])
    if len(pieces) < 2:
        return None

    def levels(name: str) -> FloatArray:
        """(n,) the signal's median at each stand; NaN where it has holes there."""
        if name not in usable:
            return np.zeros(len(pieces))
        column = on_grid(without_spikes(usable[name])[0], start_ns, rows, RATE_HZ, 1, None, None)
        return np.array([float(np.median(column[a:b])) for _, a, b in pieces])

    rates, _ = spring_rates(vehicle)
    loads = {c: np.column_stack([levels(name) for name in names_of(c)]) for c in carriers}
    if "suspension_deflection" in loads:
        loads["suspension_deflection"] = loads["suspension_deflection"] * rates
    along, across = levels("accel_x"), levels("accel_y")
    good = np.all([np.isfinite(each).all(axis=1) for each in loads.values()], axis=0)
    number, first, past = (np.array(each)[good] for each in zip(*pieces, strict=True))
    if len(number) < 2:
        return None
    seconds = (start_ns - drive.start_ns) / 1e9
    return Stands(
        number, seconds + first / RATE_HZ, seconds + past / RATE_HZ, np.nan_to_num(along[good]), np.nan_to_num(across[good]),
        {name: each[good] for name, each in loads.items()},
    )  # fmt: skip


def weight_of(stands: Stands, carrier: str, vehicle: Vehicle) -> float:
    """What the vehicle weighs, N, as far as friction and drift go with it."""
    mass = vehicle.get("mass_kg")
    usual = GRAVITY * (USUAL_KG if mass is None else mass.value)
    if carrier in ("suspension_deflection", "suspension_force"):
        return usual
    return max(float(np.median(stands.loads[carrier].sum(axis=1))), 0.3 * usual)
