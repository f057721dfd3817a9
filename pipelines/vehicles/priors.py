"""Priors from measured vehicles: CG height by body style and mass, roll and pitch inertia by mass and size.

A prior is the prediction of a regression over the measured vehicles for one more vehicle: its spread is the scatter
about the line and the line's own uncertainty. Outside the measured range there is no prior: a lorry's height is not
extrapolated from passenger cars.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from pipelines.drive_results import Standing
from pipelines.results import FloatArray, Prior
from pipelines.vehicles.measured import COMBUSTION, Measured, known_body, measured_inertias, measured_vehicles

RANGE_MARGIN = 1.15
"""How far beyond the lightest and heaviest measured vehicle a prior is still given (a loaded vehicle is heavier)."""
BEYOND = 0.6
"""Relative spread of a height for each 100 % by which a mass lies outside those of the measured vehicles of its style."""

SPORTS_SHARE, SPORTS_LOWER = 1 / 3, 0.11
"""Coupés that were measured are mostly saloons with two doors. The few sports cars among the measured ones (FR-S, 350Z, MR2 and, open,
MX-5, S2000, Z4) stand so much lower, and so many of those who say "coupé" may mean one."""

MIN_GROUP = 10
"""Body styles with fewer measured vehicles than this take the regression over all of them."""


def _predict(design: FloatArray, target: FloatArray, at: FloatArray) -> tuple[float, float]:
    """Least squares, and the mean and standard deviation of one new observation at `at`."""
    gram = np.linalg.inv(design.T @ design)
    beta = gram @ (design.T @ target)
    residual = target - design @ beta
    dof = len(target) - design.shape[1]
    variance = float(residual @ residual) / dof
    # a Student prediction has a larger spread than its scale when the group is small
    spread = variance * (1 + float(at @ gram @ at)) * dof / max(dof - 2, 1)
    return float(at @ beta), math.sqrt(spread)


def _in_range(mass_kg: float, measured: FloatArray) -> bool:
    return bool(measured.min() / RANGE_MARGIN <= mass_kg <= measured.max() * RANGE_MARGIN)


def _line(
    chosen: npt.NDArray[np.bool_], mass_kg: float | None, table: Measured
) -> tuple[float, float] | None:
    """Mean and spread of the CG height of one more vehicle like the chosen (n,); None where none of them is about as heavy."""
    mass, height = table.mass[chosen], table.height[chosen]
    if mass_kg is None:
        return float(height.mean()), float(height.std(ddof=1))
    if not _in_range(mass_kg, table.mass):
        return None
    centre = mass.mean()
    design = np.column_stack([np.ones_like(mass), mass - centre])
    value, std = _predict(design, height, np.array([1.0, mass_kg - centre]))
    # a line through passenger cars says little of a vehicle heavier or lighter than all of them
    beyond = max(mass_kg / float(mass.max()), float(mass.min()) / mass_kg, 1.0) - 1
    return value, math.hypot(std, BEYOND * beyond * value)


def _alike(style: str | None, combustion: bool, table: Measured) -> tuple[npt.NDArray[np.bool_], str]:
    """Which measured vehicles (n,) a prior is taken from, and they in words. combustion: those alone."""
    chosen, words = np.ones(len(table.height), dtype=bool), "measured vehicles"
    if combustion:
        chosen, words = np.array([p == COMBUSTION for p in table.powertrain]), "measured combustion vehicles"
    if style is not None:
        same = chosen & np.array([b == style for b in table.body])
        if same.sum() >= MIN_GROUP:
            chosen, words = same, f"{words} of body style {style}"
    return chosen, f"{int(chosen.sum())} {words}"


@cache
def _electrified(powertrain: str) -> tuple[float, float, int]:
    """Share by which the CG of such vehicles stands above that of combustion vehicles as heavy and of their style, its spread for one more,
    and of how many."""
    table = measured_vehicles()
    found = []
    for i in (i for i, p in enumerate(table.powertrain) if p == powertrain):
        line = _line(_alike(table.body[i], True, table)[0], float(table.mass[i]), table)
        if line is not None:
            found.append(float(table.height[i]) / line[0] - 1)
    mean, std = _predict(np.ones((len(found), 1)), np.array(found), np.ones(1))
    return mean, std, len(found)


def measured_cg_height(
    body: str | None, mass_kg: float | None, powertrain: str | None = None
) -> Prior | None:
    """CG height above ground of an empty vehicle by body style, mass and powertrain; None where the tables say nothing.

    Without a known body style: all measured vehicles by mass. With neither, or for a mass outside the measured
    range (815-3 598 kg, with 15 % margin): None. powertrain: one of `POWERTRAINS`; None: it may be any. A battery below the floor
    lowers the CG by up to a quarter, which the few measured ones tell by how far they stand off the combustion vehicles.
    """
    style = known_body(body)
    if style is None and (mass_kg is None or body is not None):
        # a body style that nobody measured (bus, lorry, robot) is not a passenger car of the same mass
        return None
    table = measured_vehicles()
    chosen, who = _alike(style, powertrain is not None, table)
    line = _line(chosen, mass_kg, table)
    if line is None:
        return None
    value, std = line
    at = "" if mass_kg is None else f", at {mass_kg:.0f} kg"
    if style == "Coupe":
        value, std = _with_sports_cars(value, std)
        at = f", a third of which may be sports cars ({100 * SPORTS_LOWER:.0f} % lower){at}"
    if powertrain in (None, COMBUSTION):
        return Prior(value, std, f"{who}{at}")
    departure, spread, count = _electrified(powertrain)
    lowered = (1 + departure) * value
    # the spread holds the scatter of vehicles of one style and mass already
    alike = style is not None and mass_kg is not None
    wide = max(spread * value, std) if alike else math.hypot(spread * value, std)
    return Prior(lowered, wide, f"{count} measured {powertrain} vehicles beside {who}{at}")


def _with_sports_cars(value: float, std: float) -> tuple[float, float]:
    """Mean and spread of a coupé's CG height, from those of the measured coupés: that of either kind, by its chance."""
    lower = SPORTS_LOWER * value
    return value - SPORTS_SHARE * lower, math.hypot(std, math.sqrt(SPORTS_SHARE * (1 - SPORTS_SHARE)) * lower)


def _inertia(target: FloatArray, mass_kg: float | None, track_m: float | None, name: str) -> Prior | None:
    table = measured_inertias()
    if mass_kg is None or not _in_range(mass_kg, table.mass):
        return None
    columns = [np.ones_like(table.mass), np.log(table.mass)]
    at = [1.0, math.log(mass_kg)]
    if track_m is not None:
        columns.append(np.log(table.track))
        at.append(math.log(track_m))
    log_value, log_std = _predict(np.column_stack(columns), np.log(target), np.array(at))
    value = math.exp(log_value)
    size = f"{mass_kg:.0f} kg" + ("" if track_m is None else f" and {track_m:.2f} m track")
    return Prior(value, value * log_std, f"{len(target)} measured {name} inertias, at {size}")


def measured_roll_inertia(mass_kg: float | None, track_m: float | None = None) -> Prior | None:
    """Roll inertia of the whole vehicle about its CG by mass and track; None outside the measured range."""
    return _inertia(measured_inertias().roll, mass_kg, track_m, "roll")


PITCH_RADIUS = (0.483, 0.03)
"""Radius of pitch inertia over the wheelbase, mean and spread. The table of inertias has no wheelbases; with their makers' for 24 of its
vehicles (cars, minivans, vans of 3.5 m, pickups, SUVs) it is 0.44 to 0.53, 0.483 ± 0.025. By mass alone a long van's is a quarter short."""


def measured_pitch_inertia(mass_kg: float | None, wheelbase_m: float | None = None) -> Prior | None:
    """Pitch inertia of the whole vehicle about its CG by mass and, where that is known, wheelbase; None outside the measured range."""
    by_mass = _inertia(measured_inertias().pitch, mass_kg, None, "pitch")
    if by_mass is None or mass_kg is None or wheelbase_m is None:
        return by_mass
    share, spread = PITCH_RADIUS
    value = mass_kg * (share * wheelbase_m) ** 2
    said = f"{share:g} ± {spread:g} of the wheelbase as radius, of measured vehicles, at {mass_kg:.0f} kg and {wheelbase_m:.2f} m"
    return Prior(value, 2 * spread / share * value, said)


_MEASURED_AS = {"Pickup": ("PU",), "SUV": ("MP",), "Minivan": ("VN",), "Van": ("VN",)}
"""Styles whose product of inertia is taken from their own kind (codes of the table of inertias); the others are cars."""
_CARS = ("2C", "2S", "3H", "4S", "5H", "SW")


def measured_product(body: str | None) -> tuple[float, float]:
    """I_xz/I_zz of one more vehicle of a body style, mean and spread, I_xz the integral of x z over the mass, x ahead and z up.

    Negative but for pickups, as most vehicles are low in front. Without a known style: over all 41 that were measured.
    """
    table, style = measured_inertias(), known_body(body)
    codes = None if style is None else _MEASURED_AS.get(style, _CARS)
    chosen = np.isfinite(table.product) & np.array([codes is None or code in codes for code in table.body])
    return _predict(np.ones((int(chosen.sum()), 1)), table.product[chosen], np.ones(1))


def standing(body: str | None, cg_height_m: float | None, mass_kg: float | None = None) -> Standing:
    """Where a CG height stands among the measured vehicles; the five nearest in mass of the same style."""
    table = measured_vehicles()
    style = known_body(body)
    same = np.array([b == style for b in table.body])
    group = table.height[same]
    percentile = None
    if cg_height_m is not None:
        reference = group if len(group) else table.height
        percentile = float(100 * np.mean(reference < cg_height_m))
    nearest: tuple[str, ...] = ()
    if mass_kg is not None:
        distance = np.abs(table.mass - mass_kg) + np.where(same, 0.0, 1e6 if same.any() else 0.0)
        nearest = tuple(
            f"{table.label[i]}: {table.mass[i]:.0f} kg, {table.height[i]:.3f} m"
            for i in np.argsort(distance, kind="stable")[:5]
        )
    return Standing(table.height, group, style, percentile, nearest)
