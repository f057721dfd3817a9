"""What is known before the log: every unknown of the balances with its mean and spread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pipelines.joint.vehicle.body import TYRE_SHARE, Body, Values, body_of
from pipelines.joint.vehicle.book import AXLES, Book
from pipelines.joint.vehicle.feet import hub_low
from pipelines.joint.vehicle.links import inertias, links
from pipelines.joint.vehicle.load_places import LoadPlace, in_words, places, usual_height
from pipelines.joint.vehicle.poles import poles
from pipelines.joint.vehicle.remembered import Remembered
from pipelines.joint.vehicle.suspension import CORNERS, suspension
from pipelines.models.roll import GRAVITY
from pipelines.results import Assumption, FloatArray
from pipelines.vehicles.kinds import LOAD_SPREAD, LOAD_SPREAD_STD, kind_of, usual_load
from pipelines.vehicles.priors import measured_cg_height
from pipelines.vehicles.spring_base import narrowing, rigid_axle
from pipelines.vehicles.usual import (
    usual_drag,
    usual_engine_drag,
    usual_radius,
    usual_recovery,
    usual_rolling,
    usual_track,
    usual_tyre_rate,
    usual_unsprung,
    usual_wheel_inertia,
    usual_wheelbase,
)
from pipelines.vehicles.vehicle import Vehicle

__all__ = [
    "AXLES",
    "BY_SPRINGS",
    "CORNERS",
    "SPRINGS_CARRY",
    "TOWED",
    "TYRE_SHARE",
    "Body",
    "Known",
    "Values",
    "before_the_log",
    "body_of",
]

FORCE_BASE = (0.96, 0.09)
"""How far apart the springs of a live axle stand, over the track, where the file is silent: load cells may sit in leaf springs at
three quarters of it, or their forces are those at the wheels already."""

ASKEW = 0.014
"""rad about each axis that an inertial unit sits askew: brackets and boards are held to 2 degrees."""

BY_SPRINGS = "axle_by_springs"
"""Of axle loads: 0 what the tyres carry, 1 what the springs do."""

TOWED = "towed"
"""Mass of a trailer, kg."""

TRAILER_DRAG_M2 = (0.6, 0.6)
"""What a trailer adds to the drag area, where nobody says."""

SPRINGS_CARRY = (1.0, 0.3)
"""Of axle loads by springs: an axle's links carry more or less than the mean of both, by their slopes and the brakes' share."""

FORCE_SENSORS = {"suspension": (0.006, 40.0), "tyre": (0.006, 50.0), "axle": (0.01, 60.0)}
"""Scale error of an axle's sensors together, and zero of a wheel's in N: strain gauges and measuring wheels are calibrated to 0.8 %
each, load sensors in springs to about one per cent. What the two of an axle differ by is a zero beside these."""

CROSSTALK = {("pitch", "tyre"): 0.02, ("roll", "tyre"): 0.015}
"""Spread of a balance's gain by measuring wheels, beyond other balances': one per cent of the force along or across reads as a vertical
one, with the half wheelbase or half track as its lever, where load transfer has the CG's height."""

NOD_STUCK = (0.25, 0.25)
"""Share of the nod that dry friction takes where all of it lies within the friction's own give, mean and spread: by a gyro, whose sum does not
tell where in it the springs stand. Two fifths in steady circles; none where a slalom shakes the springs all the while."""


@dataclass(frozen=True)
class Known:
    """The unknowns before the log. names, mean, std: (k,), SI; assumptions for the report; springs: rates known; places: of the
    load; keys: unknown -> the vehicle file's key that states it."""

    names: tuple[str, ...]
    mean: FloatArray
    std: FloatArray
    assumptions: tuple[Assumption, ...]
    springs: bool
    mass: bool
    places: tuple[LoadPlace, ...] = ()
    keys: Mapping[str, str] = field(default_factory=dict)

    def at(self, u: FloatArray) -> Remembered[float]:
        """Values for (k,) deviations in standard deviations."""
        return Remembered(zip(self.names, (self.mean + self.std * u).tolist(), strict=True))

    def index(self, name: str) -> int:
        """Row of an unknown."""
        return self.names.index(name)


ANY_H, TALL_H = (0.8, 0.3), (1.0, 0.3)
"""m above ground: an empty vehicle's CG where no measured vehicle is like it, and that of lorries and buses."""

WOUND = 0.25
"""Spread of the height at which held brakes leave a stop's force pushing on the body, over the pitch centre's: a sixth of the force
stays between the axles, on links of which one axle's may dive and lift more than the other's."""


def _geometry(book: Book) -> None:
    vehicle = book.vehicle
    book.quantity("wheelbase", "wheelbase_m", *usual_wheelbase(vehicle))
    other = vehicle.get("track_front_m") or vehicle.get("track_rear_m")
    track = usual_track(vehicle) if other is None else (other.value, max(other.std, 0.015))
    for axle in AXLES:
        book.quantity(f"track_{axle}", f"track_{axle}_m", *track)
        ratio, std = narrowing(vehicle, axle)
        book.put(f"spring_base_{axle}", ratio, std)
        # forces in springs that nobody says stand between the wheels of a live axle
        unsaid = rigid_axle(vehicle, axle) and vehicle.get(f"spring_base_{axle}_m") is None
        book.put(f"force_base_{axle}", *(FORCE_BASE if unsaid else (1.0, std / ratio)))
    book.quantity("radius", "wheel_radius_m", *usual_radius(vehicle))
    book.quantity(
        "wheel_inertia", "wheel_inertia_kgm2", *usual_wheel_inertia(vehicle, book.rows["radius"][0])
    )
    book.quantity("tyre_rate", "tire_vertical_rate_npm", *usual_tyre_rate(vehicle))
    # how much of the axles' dry friction holds the body's nodding: the road shakes each wheel by itself
    book.put("rub", 0.6, 0.4)


def _empty(book: Book) -> float:
    """The empty vehicle; its mass in kg as the file or the usual has it."""
    vehicle = book.vehicle
    mass = book.quantity("empty_mass", "mass_kg", 1800.0, 900.0)
    kilos = 1800.0 if mass is None else mass.value
    length = book.rows["wheelbase"][0]
    for axle in AXLES:
        usual = usual_unsprung(vehicle, axle, kilos)
        book.quantity(f"unsprung_{axle}", f"unsprung_mass_{axle}_kg", *usual)
    book.quantity("empty_x", "cg_to_front_axle_m", 0.46 * length, 0.06 * length)
    # a body or chassis that is twisted a little stands harder on one diagonal
    book.put("cross", 0.0, 0.004 * kilos)
    lateral = vehicle.get("cg_lateral_offset_m")
    even = (0.0, 0.012) if lateral is None else (lateral.value, lateral.std)
    source = "cars are built nearly even" if lateral is None else lateral.source
    book.put("empty_y", *even, "lateral place of the empty vehicle's CG, m", source)
    stated = vehicle.get("cg_height_m")
    prior = measured_cg_height(vehicle.body, None if mass is None else mass.value, vehicle.powertrain)
    if stated is not None:
        book.put("empty_h", stated.value, stated.std, "cg_height_m (empty)", stated.source)
        book.keys["empty_h"] = "cg_height_m"
    elif prior is not None:
        book.put("empty_h", prior.value, prior.std, "cg_height_m (empty)", prior.source)
    else:
        tall = TALL_H if kind_of(vehicle) == "heavy" else ANY_H
        book.put("empty_h", *tall, "cg_height_m (empty)", "no measured vehicle is like it")
    return kilos


def _load(book: Book, kilos: float) -> None:
    stated = book.vehicle.load.get("mass_kg")
    length, track = book.rows["wheelbase"][0], book.rows["track_front"][0]
    h = book.rows["empty_h"][0]
    if stated is None:
        usual = usual_load(book.vehicle, kilos)
        book.put("load", usual.mean, usual.std, "load, kg", book.vehicle.load_unsaid)
    else:
        book.put("load", stated.value, stated.std, "load, kg", stated.source)
    for name, mean, std in zip(("load_wide", "load_long"), LOAD_SPREAD, LOAD_SPREAD_STD, strict=True):
        book.put(name, mean, std)
    where = "seats, boot, roof: anywhere in or on the vehicle"
    high, unsure = usual_height(book.vehicle)
    # people sit on the front half and before the rear axle, luggage lies above it or behind
    for name, key, title, open_ in (
        ("load_x", "behind_front_axle_m", "load behind the front axle, m", (0.6 * length, 0.35 * length)),
        ("load_y", "left_m", "load left of the middle, m", (0.0, 0.16 * track)),
        ("load_h", "height_m", "load above ground, m", (high * h, unsure * h)),
    ):
        told = book.vehicle.load.get(key)
        if told is None:
            book.put(name, *open_, title, in_words(book.vehicle) if name == "load_h" else where)
        else:
            book.put(name, told.value, told.std, title, told.source)


def _sensors(book: Book) -> None:
    length, h = book.rows["wheelbase"][0], book.rows["empty_h"][0]
    places = (
        ("imu_x", "imu_behind_front_axle_m", 0.5 * length, 0.4),
        ("imu_y", "imu_left_m", 0.0, 0.2),
        ("imu_h", "imu_above_ground_m", 0.8 * h, 0.2),
    )
    for name, key, mean, std in places:
        known = book.vehicle.sensors.get(key)
        if known is None:
            book.put(
                name, mean, std, f"[sensors] {key}", "the vehicle file is silent: anywhere near the middle"
            )
        else:
            book.put(name, known.value, known.std, key, known.source)
    for axis in ("roll", "pitch", "yaw"):
        book.put(f"askew_{axis}", 0.0, ASKEW)
    for axis in ("x", "y", "z"):
        book.put(f"offset_{axis}", 0.0, 0.08 if axis != "z" else 0.02)
    book.assumptions.append(
        Assumption(
            "mounting and offsets of the inertial unit",
            "0.8 deg about each axis; 0.08 m/s² (0.02 m/s² vertical, of which the drive's mean is gravity)",
            "usual; unknowns of the fit",
        )
    )
    usual = 0.25 * GRAVITY * book.rows["empty_mass"][0]
    for kind, (scale, zero) in FORCE_SENSORS.items():
        for axle in AXLES:
            book.put(f"{kind}_scale_{axle}", 1.0, scale)
        for wheel in CORNERS:
            book.put(f"{kind}_zero_{wheel}", 0.0, float(np.hypot(zero, scale * usual)))
    # whether axle loads are what springs carry, and not tyres: 0 or 1, and in doubt where nobody says (`doubts`)
    by = book.vehicle.axle_load_by == "springs"
    book.put(BY_SPRINGS, *(SPRINGS_CARRY if by else (0.0, 0.01)))
    # wheels, hubs and tyres take part in quick motion in their own ways: an inertia is seen no better than this
    for axis, share in (("pitch", 0.06), ("roll", 0.15)):
        book.put(f"swing_{axis}", 0.0, share)
    # dampers have knees and friction: the rate that a drive shows is that of its own speeds
    book.put("damping_factor", 1.0, 0.15)
    # what swings (hubs that lean, tyres, a load that gives) is not the rigid vehicle's inertia: no roll motion tells that better
    book.put("inertia_factor", 1.0, 0.08)
    for relation in ("pitch", "roll", "vertical"):
        for kind in (
            "deflection",
            "suspension",
            "tyre",
            "axle",
            *(["attitude"] if relation == "pitch" else []),
        ):
            book.put(f"late_{relation}_{kind}", 0.0, 0.05)
            book.put(f"gain_{relation}_{kind}", 0.0, CROSSTALK.get((relation, kind), 0.005))


def _long(book: Book, kilos: float) -> None:
    """Drag, rolling, torque scales, lift."""
    vehicle = book.vehicle
    book.quantity("drag", "drag_area_m2", *usual_drag(vehicle))
    # 0 to 40 °C and up to some hundred metres above the sea; and wind: 2 m/s along a drive of 20 m/s is a fifth of the drag, of which
    # a route's turns take about half
    book.put("air", 1.0, 0.12)
    book.put("drag_height", *((1.4, 0.4) if kind_of(vehicle) == "heavy" else (0.7, 0.25)))
    for axle in AXLES:
        book.put(f"lift_{axle}", 0.0, 0.06)
    book.quantity("rolling", "rolling_resistance", *usual_rolling(vehicle))
    gain = vehicle.get("brake_gain_nmppa")
    value, std = (1.0, 1.0) if gain is None else (gain.value, gain.std)
    # pads fade and gains are of a data sheet: never surer than 3 %
    book.put("brake_gain", value, max(std, 0.03 * value))
    for name in ("drive_scale", "brake_scale"):
        book.put(
            name, 1.0, 0.04, name.replace("_", " torque ") + " of the log", "usual for estimated torques"
        )
    # torque by pressure and the log's own brake torque mean the same pads: how far they may differ, beside their scales
    book.put("pads", 0.0, 0.025)
    book.put("brake_zero", 0.0, 60.0)
    book.put("corner_drag", 0.003 * kilos, 0.003 * kilos)
    # 1: the road turns the wheels back, which unloads the front; 0: a force at the road alone
    book.put("rolling_shift", 0.7, 0.6)
    book.put("product", 0.0, 0.06 * kilos)
    # what brakes that hold wind up in the links: 6 mm of CG place at rest; dampers' one-sidedness and the like: 3 mm moving
    book.put("pitch_bias", 0.0, 0.003 * GRAVITY * kilos)
    book.put("pitch_wound", 0.0, 0.006 * GRAVITY * kilos)
    book.put("nod_wound", 0.0, WOUND * float(np.hypot(*book.rows["pitch_center_brake"])))
    book.put("nod_stuck", *NOD_STUCK)
    book.put("late_long", 0.0, 0.05)
    book.put("tilt", 1.0, 0.3)
    book.put("gain_long", 0.0, 0.01)
    # what an engine in gear, or a motor that charges, adds to the brakes where no log tells its torque, m/s²
    book.put("engine_drag", *usual_engine_drag(vehicle))


def _trailer(book: Book) -> None:
    """What is towed, kg: as stated, else nothing until a log that contradicts itself is asked for it (`pipelines.joint.ways.towed`)."""
    stated, drag = (book.vehicle.trailer.get(key) for key in ("mass_kg", "drag_area_m2"))
    towed = 0.0 if stated is None else stated.value
    book.put(TOWED, towed, 1.0 if stated is None else max(stated.std, 1.0))
    # how high it pulls, and how much of it pushes in braking: some have brakes of their own
    book.put("hitch", 0.4, 0.15)
    book.put("pushes", 0.7, 0.4)
    if towed > 0.0:
        more = TRAILER_DRAG_M2 if drag is None else (drag.value, drag.std)
        alone = book.rows["drag"]
        book.put("drag", alone[0] + more[0], float(np.hypot(alone[1], more[1])))
        book.assumptions.append(
            Assumption(
                "what the trailer adds to the drag area",
                f"{more[0]:.3g} ± {more[1]:.3g} m²",
                "usual" if drag is None else drag.source,
            )
        )


def before_the_log(vehicle: Vehicle) -> Known:
    """Every unknown of the balances with what the vehicle file, the measured vehicles or custom say of it."""
    book = Book(vehicle)
    _geometry(book)
    kilos = _empty(book)
    _load(book, kilos)
    springs = suspension(book, kilos)
    links(book)
    inertias(book, kilos)
    _sensors(book)
    _long(book, kilos)
    # how the body really swings over what springs as stated or usual have it do, where no sensor shows it
    book.put("guessed_swing", 1.0, 1.0)
    poles(book)
    book.put("recovered", *usual_recovery(vehicle))
    _trailer(book)
    book.put("hub_low", *hub_low(book))
    table = np.array(list(book.rows.values()))
    return Known(
        tuple(book.rows), table[:, 0], table[:, 1], tuple(book.assumptions), springs,
        vehicle.get("mass_kg") is not None, places(vehicle, {name: mean for name, (mean, _) in book.rows.items()}),
        book.keys,
    )  # fmt: skip
