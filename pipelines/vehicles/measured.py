"""The measured vehicles: CG heights and inertias, the body styles that their table names, and which of them a battery drives."""

from __future__ import annotations

import difflib
import io
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np

from pipelines.results import FloatArray

if TYPE_CHECKING:
    import polars as pl

COMBUSTION = "combustion"
POWERTRAINS = (COMBUSTION, "hybrid", "battery")
"""What a vehicle file's `powertrain` may be: hybrid with or without a plug, battery without an engine."""

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
    """The table of CG heights, one entry a vehicle: body, label, powertrain (n,) text; mass, height, track (n,) in kg and m."""

    body: tuple[str, ...]
    label: tuple[str, ...]
    powertrain: tuple[str, ...]
    mass: FloatArray
    height: FloatArray
    track: FloatArray


@dataclass(frozen=True)
class Inertias:
    """The table of inertias: body (n,) text as the table has it, mass (n,) kg, track (n,) m, roll and pitch (n,) kg·m²; product (n,):
    integral of x z over the mass in axes forward and up, over the yaw inertia, nan where it was not measured."""

    body: tuple[str, ...]
    mass: FloatArray
    track: FloatArray
    roll: FloatArray
    pitch: FloatArray
    product: FloatArray


def _table(name: str) -> pl.DataFrame:
    import polars as pl  # a vehicle file is read without: a conversion asks for its wheel radius alone

    data = resources.files("pipelines.vehicles.data").joinpath(name).read_bytes()
    return pl.read_csv(io.BytesIO(data), infer_schema_length=None)


def _column(frame: pl.DataFrame, name: str) -> FloatArray:
    import polars as pl

    return np.asarray(frame.get_column(name).cast(pl.Float64).to_numpy(), dtype=np.float64)


@cache
def measured_vehicles() -> Measured:
    """The 1 270 measured CG heights."""
    import polars as pl

    name = ["make", "model", "model_year"]
    frame = _table("measured_cg_heights.csv").join(
        _table("electrified.csv"), on=name, how="left", maintain_order="left"
    )
    label = frame.select(
        pl.concat_str([pl.col(c).cast(pl.String) for c in ("make", "model", "model_year")], separator=" ")
    )
    return Measured(
        tuple(frame.get_column("body").to_list()),
        tuple(label.to_series().to_list()),
        tuple(frame.get_column("powertrain").fill_null(COMBUSTION).to_list()),
        _column(frame, "mass_kg"),
        _column(frame, "cg_height_m"),
        _column(frame, "average_track_m"),
    )


@cache
def measured_inertias() -> Inertias:
    """The 204 measured inertias; the track follows from SSF = T / (2 h).

    The table's product of inertia is in axes with z down (SAE): it is largest in minivans, low in front and tall behind, and
    of the other sign in pickups, whose bed is low. Here z is up.
    """
    frame = _table("measured_inertias.csv")
    track = 2 * _column(frame, "cg_height_m") * _column(frame, "static_stability_factor")
    return Inertias(
        tuple(frame.get_column("body").to_list()),
        _column(frame, "mass_kg"),
        track,
        _column(frame, "roll_inertia_kgm2"),
        _column(frame, "pitch_inertia_kgm2"),
        -_column(frame, "roll_yaw_product_kgm2") / _column(frame, "yaw_inertia_kgm2"),
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
