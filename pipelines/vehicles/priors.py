"""Priors from measured vehicles: CG height by body style and mass, roll and pitch inertia by mass and size.

A prior is the prediction of a regression over the measured vehicles for one more vehicle: its spread is the scatter
about the line and the line's own uncertainty. Outside the measured range there is no prior: a lorry's height is not
extrapolated from passenger cars.
"""

from __future__ import annotations

import difflib
import io
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
import polars as pl

from pipelines.results import FloatArray, Prior, Standing

RANGE_MARGIN = 1.15
BEYOND = 0.6
"""Relative spread of a height for each 100 % by which a mass lies outside those of the measured vehicles of its style."""
"""How far beyond the lightest and heaviest measured vehicle a prior is still given (a loaded vehicle is heavier)."""

MIN_GROUP = 10
"""Body styles with fewer measured vehicles than this take the regression over all of them."""

_BODIES: dict[str, str] = {
    "sedan": "Sedan", "saloon": "Sedan", "limousine": "Sedan", "notchback": "Sedan", "fastback": "Sedan",
    "suv": "SUV", "crossover": "SUV", "cuv": "SUV", "sportutility": "SUV", "offroad": "SUV",
    "pickup": "Pickup", "pickuptruck": "Pickup", "lighttruck": "Pickup", "ute": "Pickup",
    "hatchback": "Hatchback", "hatch": "Hatchback", "compact": "Hatchback", "citycar": "Hatchback",
    "minivan": "Minivan", "mpv": "Minivan", "peoplecarrier": "Minivan",
    "wagon": "Wagon", "stationwagon": "Wagon", "estate": "Wagon", "kombi": "Wagon", "touring": "Wagon",
    "coupe": "Coupe", "coupé": "Coupe", "sportscar": "Coupe", "sports": "Coupe",
    "convertible": "Convertible", "cabriolet": "Convertible", "roadster": "Convertible", "cabrio": "Convertible",
    "van": "Van", "cargovan": "Van", "panelvan": "Van", "transporter": "Van",
}  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """The table of CG heights, one entry a vehicle: body, label (n,) text; mass, height, track (n,) in kg and m."""

    body: tuple[str, ...]
    label: tuple[str, ...]
    mass: FloatArray
    height: FloatArray
    track: FloatArray


@dataclass(frozen=True)
class Inertias:
    """The table of inertias: mass (n,) kg, track (n,) m, roll and pitch (n,) kg·m²."""

    mass: FloatArray
    track: FloatArray
    roll: FloatArray
    pitch: FloatArray


def _table(name: str) -> pl.DataFrame:
    data = resources.files("pipelines.vehicles.data").joinpath(name).read_bytes()
    return pl.read_csv(io.BytesIO(data), infer_schema_length=None)


def _column(frame: pl.DataFrame, name: str) -> FloatArray:
    return np.asarray(frame.get_column(name).cast(pl.Float64).to_numpy(), dtype=np.float64)


@cache
def measured_vehicles() -> Measured:
    """The 1 270 measured CG heights."""
    frame = _table("measured_cg_heights.csv")
    label = frame.select(
        pl.concat_str([pl.col(c).cast(pl.String) for c in ("make", "model", "model_year")], separator=" ")
    )
    return Measured(
        tuple(frame.get_column("body").to_list()),
        tuple(label.to_series().to_list()),
        _column(frame, "mass_kg"),
        _column(frame, "cg_height_m"),
        _column(frame, "average_track_m"),
    )


@cache
def measured_inertias() -> Inertias:
    """The 204 measured inertias; the track follows from SSF = T / (2 h)."""
    frame = _table("measured_inertias.csv")
    track = 2 * _column(frame, "cg_height_m") * _column(frame, "static_stability_factor")
    return Inertias(
        _column(frame, "mass_kg"),
        track,
        _column(frame, "roll_inertia_kgm2"),
        _column(frame, "pitch_inertia_kgm2"),
    )


def near_body(body: str) -> str | None:
    """The body style that a text nearly spells ("Hatchbak" -> "Hatchback"), None where it is known or like none."""
    plain = "".join(c for c in body.casefold() if c.isalpha())
    near = [] if plain in _BODIES else difflib.get_close_matches(plain, _BODIES, n=1, cutoff=0.8)
    return _BODIES[near[0]] if near else None


def known_body(body: str | None) -> str | None:
    """The measured body style that a vehicle file's `body` means, or None."""
    if body is None:
        return None
    return _BODIES.get("".join(c for c in body.casefold() if c.isalpha()))


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


def measured_cg_height(body: str | None, mass_kg: float | None) -> Prior | None:
    """CG height above ground of an empty vehicle by body style and mass; None where the tables say nothing.

    Without a known body style: all measured vehicles by mass. With neither, or for a mass outside the measured
    range (815-3 598 kg, with 15 % margin): None.
    """
    table = measured_vehicles()
    style = known_body(body)
    chosen = np.ones(len(table.height), dtype=bool)
    who = f"{len(table.height)} measured vehicles"
    if style is not None:
        same = np.array([b == style for b in table.body])
        if same.sum() >= MIN_GROUP:
            chosen, who = same, f"{int(same.sum())} measured vehicles of body style {style}"
    elif mass_kg is None or body is not None:
        # a body style that nobody measured (bus, lorry, robot) is not a passenger car of the same mass
        return None
    mass, height = table.mass[chosen], table.height[chosen]
    if mass_kg is None:
        return Prior(float(height.mean()), float(height.std(ddof=1)), who)
    if not _in_range(mass_kg, table.mass):
        return None
    centre = mass.mean()
    design = np.column_stack([np.ones_like(mass), mass - centre])
    value, std = _predict(design, height, np.array([1.0, mass_kg - centre]))
    # a line through passenger cars says little of a vehicle heavier or lighter than all of them
    beyond = max(mass_kg / float(mass.max()), float(mass.min()) / mass_kg, 1.0) - 1
    return Prior(value, math.hypot(std, BEYOND * beyond * value), f"{who}, at {mass_kg:.0f} kg")


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


def measured_pitch_inertia(mass_kg: float | None) -> Prior | None:
    """Pitch inertia of the whole vehicle about its CG by mass; None outside the measured range."""
    return _inertia(measured_inertias().pitch, mass_kg, None, "pitch")


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
