"""What the tyre normal force of a wheel is made of: the mapping's regressors, and the forms made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.signals import WHEELS
from pipelines.models.suspension_map import (
    ACROSS,
    BEHIND,
    GRAVITY,
    dry_friction,
    eta_lateral,
    eta_longitudinal,
)
from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import MapData, rate_of, second_rate_of


@dataclass(frozen=True)
class Regressor:
    """unit: of its coefficient. meaning: in words. doubt: share of the coefficient that is open outside the training's range."""

    unit: str
    meaning: str
    doubt: float = 0.3


REGRESSORS: Mapping[str, Regressor] = {
    "one": Regressor("N", "weight of the wheel and the sensors' zeros", 0.0),
    "carried": Regressor("1", "force that the suspension carries: strut force, or that of the springs", 0.02),
    "hub": Regressor("kg", "vertical acceleration of the wheel: its mass"),
    "weight": Regressor("kg", "g and the vertical acceleration of the wheel: its mass, (146)"),
    "lateral_eta": Regressor("1", "force on the axle x a_y/g x eta_1: roll centre height over track, (147), (149)"),
    "longitudinal_eta": Regressor("1", "force on the side x a_x/g x eta_2: pitch centre height over wheelbase, (148), (150)"),
    "lateral": Regressor("1", "force on the axle x a_y/g: what the links carry of the lateral load transfer"),
    "longitudinal": Regressor("1", "force on the side x a_x/g: what the links carry of the longitudinal load transfer"),
    "own_lateral": Regressor("1", "own force x a_y/g: the outer wheel takes more of the side force"),
    "accelerating": Regressor("1", "force on the side x a_x/g while driving"),
    "braking": Regressor("1", "force on the side x a_x/g while braking"),
    "yawing": Regressor("m", "force on the axle / g x yaw acceleration: side force that turns the vehicle"),
    "drag": Regressor("N·s²/m²", "speed squared: lift, and the drive force against drag"),
    "friction_in": Regressor("N", "dry friction while the wheel goes in"),
    "friction_out": Regressor("N", "dry friction while the wheel goes out"),
    "deflection": Regressor("N/m", "springs that the force sensor does not feel (bushings)"),
    "bar": Regressor("N/m", "deflection against the axle's other wheel: an anti-roll bar beside the force sensor"),
    "stiffening": Regressor("N/m³", "deflection cubed: springs that stiffen"),
    "damping_in": Regressor("N·s/m", "speed of the deflection, going in"),
    "damping_out": Regressor("N·s/m", "speed of the deflection, going out"),
}  # fmt: skip
"""Every regressor, by its name in a map file."""

_PUBLISHED = ("carried", "weight", "lateral_eta", "longitudinal_eta")
_TRANSFER = ("one", "carried", "hub", "lateral", "longitudinal")
_INTERACTION = (
    "one", "carried", "hub", "lateral", "own_lateral", "accelerating", "braking", "yawing", "drag"
)  # fmt: skip
_FRICTION = ("friction_in", "friction_out", "bar")
_DAMPING = ("damping_in", "damping_out")

STRUT_FORMS: Mapping[str, tuple[str, ...]] = {
    "published": _PUBLISHED,
    "transfer": _TRANSFER,
    "interaction": _INTERACTION,
    "friction": (*_INTERACTION, *_FRICTION),
    "full": (*_INTERACTION, *_FRICTION, "deflection", *_DAMPING),
}
"""With the suspension's forces measured: (146)-(150) as printed, and linear forms with eta = 1, richer one by one."""

SPRING_FORMS: Mapping[str, tuple[str, ...]] = {
    "springs": ("one", "deflection", "bar", "hub", "lateral", "longitudinal", *_DAMPING),
    "springs_friction": (
        "one", "deflection", "bar", "friction_in", "friction_out", *_DAMPING, *_INTERACTION[2:]
    ),
    "springs_stiffening": (
        "one", "deflection", "bar", "stiffening", "friction_in", "friction_out", *_DAMPING, *_INTERACTION[2:]
    ),
}  # fmt: skip
"""With deflections alone: springs, bar, dampers and friction stand for the forces."""

FORMS: Mapping[str, Mapping[str, tuple[str, ...]]] = {"struts": STRUT_FORMS, "springs": SPRING_FORMS}
"""By what tells the suspension's force."""


@dataclass(frozen=True)
class Shape:
    """What the regressors need beside the signals. friction_travel_m: deflection over which dry friction turns over.

    ride_height_m: h_s of (149)-(150). track_m: B of (149).
    """

    friction_travel_m: float = 0.002
    ride_height_m: float = 0.21
    track_m: float = 1.6


@dataclass(frozen=True)
class Springs:
    """Static force over deflection of a wheel: preload N, rate N/m, stiffening N/m³, bar N/m (against the other wheel)."""

    preload: float
    rate: float
    stiffening: float
    bar: float


def carried_by_struts(data: MapData) -> dict[str, FloatArray]:
    """Suspension force of each wheel as measured; wheel -> (n,) N."""
    return {w: data.columns[f"suspension_force_{w}"] for w in WHEELS}


def carried_by_springs(data: MapData, springs: Mapping[str, Springs]) -> dict[str, FloatArray]:
    """Suspension force of each wheel as its deflection tells it, without dampers and friction; wheel -> (n,) N."""
    found = {}
    for wheel in WHEELS:
        law, own = springs[wheel], data.columns[f"suspension_deflection_{wheel}"]
        apart = own - data.columns[f"suspension_deflection_{ACROSS[wheel]}"]
        found[wheel] = law.preload + law.rate * own + law.stiffening * own**3 + law.bar * apart
    return found


def shared_columns(data: MapData) -> dict[str, FloatArray]:
    """What all wheels share: accelerations, yaw acceleration, speed squared; only what the log has."""
    c = data.columns
    found = {name: c[name] for name in ("accel_x", "accel_y") if name in c}
    if "yaw_rate" in c:
        found["yaw_accel"] = rate_of(c["yaw_rate"], data.starts, data.rate_hz)
    if "speed" in c:
        found["speed2"] = c["speed"] ** 2
    if "accel_z" in c:
        # in the mean of a drive the specific force is g: what lies between is the sensor's offset and tilt
        found["heave"] = c["accel_z"] - float(np.mean(c["accel_z"]))
    return found


def wheel_columns(
    data: MapData,
    wheel: str,
    carried: Mapping[str, FloatArray],
    shape: Shape,
    shared: Mapping[str, FloatArray] | None = None,
) -> dict[str, FloatArray]:
    """Every regressor of a wheel that the drive has; name -> (n,), in the units of `REGRESSORS`.

    carried: wheel -> (n,) force that the suspension carries. What the links carry scales with the mean force on the
    wheel's axle and side in this drive, so that another load needs no other coefficients.
    """
    common = shared_columns(data) if shared is None else shared
    mean = {w: float(np.mean(values)) for w, values in carried.items()}
    axle, side = mean[wheel] + mean[ACROSS[wheel]], mean[wheel] + mean[BEHIND[wheel]]
    found = {"one": np.ones(data.size), "carried": carried[wheel]}
    found |= _transfer(common, carried[wheel], axle, side)
    found |= _deflected(data, wheel, shape)
    hub = _hub(data, wheel, common)
    if hub is not None:
        found["hub"], found["weight"] = hub, GRAVITY + hub
    if data.has(DEFLECTION_NAMES) and "accel_y" in common and "accel_x" in common:
        found |= _published(data, common, axle, side, shape)
    return found


DEFLECTION_NAMES: tuple[str, ...] = tuple(f"suspension_deflection_{w}" for w in WHEELS)


def _transfer(
    common: Mapping[str, FloatArray], own: FloatArray, axle: float, side: float
) -> dict[str, FloatArray]:
    found: dict[str, FloatArray] = {}
    if "accel_y" in common:
        found["lateral"] = axle / GRAVITY * common["accel_y"]
        found["own_lateral"] = own * common["accel_y"] / GRAVITY
    if "accel_x" in common:
        pull = side / GRAVITY * common["accel_x"]
        found["longitudinal"] = pull
        found["accelerating"], found["braking"] = np.maximum(pull, 0.0), np.minimum(pull, 0.0)
    if "yaw_accel" in common:
        found["yawing"] = axle / GRAVITY * common["yaw_accel"]
    if "speed2" in common:
        found["drag"] = common["speed2"]
    return found


def _deflected(data: MapData, wheel: str, shape: Shape) -> dict[str, FloatArray]:
    own = data.columns.get(f"suspension_deflection_{wheel}")
    other = data.columns.get(f"suspension_deflection_{ACROSS[wheel]}")
    if own is None or other is None:
        return {}
    velocity = rate_of(own, data.starts, data.rate_hz)
    dry = dry_friction(own, data.starts, shape.friction_travel_m)
    return {
        "friction_in": np.maximum(dry, 0.0),
        "friction_out": np.minimum(dry, 0.0),
        "deflection": own,
        "bar": own - other,
        "stiffening": own**3,
        "damping_in": np.maximum(velocity, 0.0),
        "damping_out": np.minimum(velocity, 0.0),
    }


def _hub(data: MapData, wheel: str, common: Mapping[str, FloatArray]) -> FloatArray | None:
    """Vertical acceleration of the wheel, m/s², 0 at rest: measured, else body plus deflection; None without either."""
    measured = data.columns.get(f"accel_z_unsprung_{wheel}")
    if measured is not None:
        return measured
    deflection = data.columns.get(f"suspension_deflection_{wheel}")
    if deflection is None:
        return None
    # the body's own acceleration is that of its middle: pitch and roll move a corner little more
    inwards = second_rate_of(deflection, data.starts, data.rate_hz)
    return inwards + common.get("heave", np.zeros(data.size))


def _published(
    data: MapData, common: Mapping[str, FloatArray], axle: float, side: float, shape: Shape
) -> dict[str, FloatArray]:
    """Load transfer with eta of (149)-(150); axle and side as in (147)-(148), in N."""
    corner = {w: data.columns[name] for w, name in zip(WHEELS, DEFLECTION_NAMES, strict=True)}
    mean = np.mean([corner[w] for w in WHEELS], axis=0)
    heave = (mean - float(np.median(mean))) / shape.ride_height_m
    lean = (corner["rl"] - corner["rr"]) / shape.track_m
    a_y = common["accel_y"]
    return {
        "lateral_eta": axle / GRAVITY * a_y * eta_lateral(a_y, heave, lean),
        "longitudinal_eta": side / GRAVITY * common["accel_x"] * eta_longitudinal(a_y, heave),
    }
