"""What is known before the log: every unknown of the balances with its mean and spread."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipelines.joint.body import TYRE_SHARE, Body, Values, body_of
from pipelines.models.axle_load import patch_shift
from pipelines.models.roll import GRAVITY
from pipelines.results import Assumption, FloatArray
from pipelines.vehicles.priors import measured_cg_height, measured_pitch_inertia, measured_roll_inertia
from pipelines.vehicles.vehicle import Quantity, Vehicle

__all__ = [
    "AXLES",
    "CORNERS",
    "TYRE_SHARE",
    "Body",
    "Known",
    "Values",
    "before_the_log",
    "body_of",
]

SILENT = "the vehicle file is silent: usual for road vehicles"
AXLES = ("front", "rear")
CORNERS = ("fl", "fr", "rl", "rr")

ZERO_M = 0.0012
"""Zero error of a deflection sensor."""

FORCE_SENSORS = {"suspension": (0.006, 40.0), "tyre": (0.006, 50.0), "axle": (0.01, 60.0)}
"""Scale error of an axle's sensors together, and zero of a wheel's in N: strain gauges and measuring wheels are calibrated to 0.8 %
each, load sensors in springs to about one per cent. What the two of an axle differ by is a zero beside these."""

PITCH_CENTER = (0.12, 0.08)
"""m above ground, where the vehicle file has no pitch_center_height_m: from no anti-dive to 40 %."""


@dataclass(frozen=True)
class Known:
    """The unknowns before the log. names, mean, std: (k,), SI; assumptions for the report; springs: rates known."""

    names: tuple[str, ...]
    mean: FloatArray
    std: FloatArray
    assumptions: tuple[Assumption, ...]
    springs: bool
    mass: bool

    def at(self, u: FloatArray) -> dict[str, float]:
        """Values for (k,) deviations in standard deviations."""
        return dict(zip(self.names, (self.mean + self.std * u).tolist(), strict=True))

    def index(self, name: str) -> int:
        """Row of an unknown."""
        return self.names.index(name)


@dataclass
class _Book:
    """Collects unknowns and says what was assumed."""

    vehicle: Vehicle
    rows: dict[str, tuple[float, float]] = field(default_factory=dict)
    assumptions: list[Assumption] = field(default_factory=list)

    def put(self, name: str, mean: float, std: float, said: str = "", source: str = SILENT) -> None:
        """One unknown; said: its name in the report, empty for what needs no line there."""
        self.rows[name] = (mean, max(std, 1e-12))
        if said:
            self.assumptions.append(Assumption(said, f"{mean:.4g} ± {std:.3g}", source))

    def quantity(self, name: str, key: str, mean: float, std: float, said: str = "") -> Quantity | None:
        """One unknown from the vehicle file, or the usual where the file is silent."""
        known = self.vehicle.get(key)
        if known is None:
            self.put(name, mean, std, said or key)
        else:
            self.put(name, known.value, known.std, key, known.source)
        return known


def _geometry(book: _Book) -> None:
    vehicle = book.vehicle
    book.quantity("wheelbase", "wheelbase_m", 2.7, 0.2)
    other = vehicle.get("track_front_m") or vehicle.get("track_rear_m")
    track = (1.55, 0.08) if other is None else (other.value, max(other.std, 0.015))
    for axle in AXLES:
        book.quantity(f"track_{axle}", f"track_{axle}_m", *track)
    book.quantity("radius", "wheel_radius_m", 0.33, 0.03)
    book.quantity("wheel_inertia", "wheel_inertia_kgm2", 1.2, 0.4)
    mass = vehicle.get("mass_kg")
    # tyres are chosen to give about as much under any vehicle
    usual = 125.0 * (1800.0 if mass is None else mass.value)
    book.quantity("tyre_rate", "tire_vertical_rate_npm", usual, 0.2 * usual)
    # how much of the axles' dry friction holds the body's nodding: the road shakes each wheel by itself
    book.put("rub", 0.6, 0.4)


def _empty(book: _Book) -> float:
    """The empty vehicle; its mass in kg as the file or the usual has it."""
    vehicle = book.vehicle
    mass = book.quantity("empty_mass", "mass_kg", 1800.0, 900.0)
    kilos = 1800.0 if mass is None else mass.value
    length = book.rows["wheelbase"][0]
    for axle in AXLES:
        book.quantity(f"unsprung_{axle}", f"unsprung_mass_{axle}_kg", 0.047 * kilos, 0.012 * kilos)
    book.quantity("empty_x", "cg_to_front_axle_m", 0.46 * length, 0.06 * length)
    # a body or chassis that is twisted a little stands harder on one diagonal
    book.put("cross", 0.0, 0.005 * kilos)
    lateral = vehicle.get("cg_lateral_offset_m")
    even = (0.0, 0.012) if lateral is None else (lateral.value, lateral.std)
    source = "cars are built nearly even" if lateral is None else lateral.source
    book.put("empty_y", *even, "lateral place of the empty vehicle's CG, m", source)
    stated = vehicle.get("cg_height_m")
    prior = measured_cg_height(vehicle.body, None if mass is None else mass.value)
    if stated is not None:
        book.put("empty_h", stated.value, stated.std, "cg_height_m (empty)", stated.source)
    elif prior is not None:
        book.put("empty_h", prior.value, prior.std, "cg_height_m (empty)", prior.source)
    else:
        book.put("empty_h", 0.8, 0.3, "cg_height_m (empty)", "no measured vehicle is like it")
    return kilos


def _load(book: _Book, kilos: float) -> None:
    stated, height = book.vehicle.load.get("mass_kg"), book.vehicle.load.get("height_m")
    length, track = book.rows["wheelbase"][0], book.rows["track_front"][0]
    h = book.rows["empty_h"][0]
    if stated is None:
        book.put("load", 0.10 * kilos, 0.12 * kilos, "load, kg", "the vehicle file has no [load]")
    else:
        book.put("load", stated.value, stated.std, "load, kg", stated.source)
    where = "seats, boot, roof: anywhere in or on the vehicle"
    book.put("load_x", 0.5 * length, 0.35 * length, "load behind the front axle, m", where)
    book.put("load_y", 0.0, 0.16 * track, "load left of the middle, m", where)
    if height is None:
        book.put("load_h", 1.45 * h, 0.65 * h, "load above ground, m", where)
    else:
        book.put("load_h", height.value, height.std, "load above ground, m", height.source)


def _bars(book: _Book) -> None:
    """Anti-roll bars: stated, or what the stated roll stiffness leaves beside the springs, or hardly known."""
    vehicle = book.vehicle
    springs = {a: 0.5 * book.rows[f"spring_{a}"][0] * book.rows[f"track_{a}"][0] ** 2 for a in AXLES}
    stated = {a: vehicle.get(f"anti_roll_stiffness_{a}_nmprad") for a in AXLES}
    total = vehicle.get("roll_stiffness_nmprad")
    left = None if total is None else max(total.value - sum(springs.values()), 0.0)
    for axle, share in zip(AXLES, (0.6, 0.4), strict=True):
        known = stated[axle]
        name = f"bar_{axle}"
        if known is not None:
            book.put(name, known.value, known.std, f"anti_roll_stiffness_{axle}_nmprad", known.source)
        elif total is not None and left is not None and not any(stated.values()):
            std = max(share * total.std, 0.1 * share * left)
            book.put(
                name,
                share * left,
                std,
                f"anti-roll bar, {axle}, N·m/rad",
                "roll_stiffness_nmprad less springs",
            )
        else:
            book.put(name, 0.6 * springs[axle], 0.5 * springs[axle], f"anti-roll bar, {axle}, N·m/rad")


def _suspension(book: _Book, kilos: float) -> bool:
    """Springs, bars, dampers, friction; whether the spring rates are known."""
    vehicle = book.vehicle
    corner = 0.23 * kilos
    springs = all(vehicle.get(f"spring_rate_{axle}_npm") is not None for axle in AXLES)
    for axle in AXLES:
        book.quantity(f"spring_{axle}", f"spring_rate_{axle}_npm", corner * 70.0, corner * 40.0)
    _bars(book)
    for axle in AXLES:
        rate = book.rows[f"spring_{axle}"][0]
        # of the rate at 50 mm: wheel rates rise with travel rather than fall
        book.put(f"square_{axle}", rate * 0.01 / 0.05, rate * 0.02 / 0.05)
        book.put(f"cube_{axle}", rate * 0.02 / 0.05**2, rate * 0.03 / 0.05**2)
        usual = 0.3 * 2 * np.sqrt(rate * corner)
        known = vehicle.get(f"damper_rate_{axle}_nspm")
        mean, spread = (usual, 0.5) if known is None else (known.value, 0.3)
        # dampers hold rebound more than bump; a knee takes some of both
        book.put(f"bump_{axle}", 0.75 * mean, spread * mean)
        book.put(f"rebound_{axle}", 1.2 * mean, spread * mean)
        book.put(f"friction_{axle}", 60.0, 50.0)
    for wheel in CORNERS:
        rate = book.rows[f"spring_{'front' if wheel[0] == 'f' else 'rear'}"][0]
        book.put(f"zero_{wheel}", 0.0, float(np.hypot(ZERO_M * rate, 20.0)))
        book.put(f"stuck_{wheel}", 0.0, 100.0)
        book.put(f"scale_{wheel}", 1.0, 0.01)
    book.assumptions.append(
        Assumption(
            "zero and scale error of a deflection sensor, friction at rest",
            f"{1e3 * ZERO_M:g} mm, 1 % and 100 N a wheel",
            "usual; unknowns of the fit",
        )
    )
    book.assumptions.append(
        Assumption(
            "curvature of the springs",
            "1 ± 2 % (square), 2 ± 3 % (cube) at 50 mm",
            "usual; unknowns of the fit",
        )
    )
    return springs


def _drive_jacking(book: _Book) -> tuple[float, float]:
    """Drop of the springs' force over the driving force: mean and spread.

    Links that carry `pitch_center_drive` of pitch moment at one axle do it by lifting the body there: over that axle's distance
    from the CG. A driven rigid axle's lift is a quarter of the driving force. With both axles driven it is unsure which lifts.
    """
    stated = book.vehicle.get("drive_front_share")
    front, front_std = (0.5, 0.5) if stated is None else (stated.value, stated.std)
    ahead = book.rows["empty_x"][0]
    behind = book.rows["wheelbase"][0] - ahead
    height, std = book.rows["pitch_center_drive"]
    lever = (1 - front) / behind - front / ahead
    unsure = (0.03, std * lever, height * front_std * (1 / behind + 1 / ahead), 0.2 * front * (1 - front))
    return height * lever, float(np.linalg.norm(unsure))


def _side_jacking(book: _Book) -> tuple[float, float]:
    """Lift of the body in bends over its mass, a (m/s²)² across, s²/m: mean and spread.

    The outer tyres take more of the side force, W (a/g)² 2 h/t of an axle's load W if forces go with loads, and the links
    to a roll centre at h_rc stand h_rc / (t/2) steep: 4 h h_rc / (g t²). How forces really go with loads, and how roll
    centres move as the body rises, make about half of it unsure.
    """
    track = 0.5 * (book.rows["track_front"][0] + book.rows["track_rear"][0])
    axis = 0.5 * (book.rows["roll_center_front"][0] + book.rows["roll_center_rear"][0])
    mean = 4 * book.rows["empty_h"][0] * max(axis, 0.0) / (GRAVITY * track**2)
    return mean, 0.004 + 0.5 * mean


def _links(book: _Book, kilos: float) -> None:
    """What the links carry: roll centres, pitch centre, jacking."""
    vehicle = book.vehicle
    for axle in AXLES:
        book.quantity(f"roll_center_{axle}", f"roll_center_height_{axle}_m", 0.09, 0.06)
    stated = vehicle.get("pitch_center_height_m")
    mean, std = PITCH_CENTER if stated is None else (stated.value, stated.std)
    source = "the vehicle file is silent: usual for road vehicles" if stated is None else stated.source
    book.put(
        "pitch_center_brake", mean, std, "pitch_center_height_m (links' part in braking: anti-dive)", source
    )
    driven = vehicle.get("pitch_center_height_drive_m")
    if driven is not None:
        mean, std, source = driven.value, driven.std, driven.source
    elif (share := vehicle.get("drive_front_share")) is not None and share.value > 0.9:
        mean, std, source = 0.7 * mean, float(np.hypot(std, 0.03)), "between none and that of braking"
    else:
        # a driven rigid axle takes the shaft's torque on its links
        mean, std, source = 0.1, 0.11, "some to all of what a driven rear axle's links may carry"
    book.put("pitch_center_drive", mean, std, "pitch_center_height_drive_m (anti-squat)", source)
    # 1: the wheels stay upright, as those of a rigid axle; independent ones lean with the body in part, and their couples
    # (inertia of the hubs, gyroscopes) then go into the springs in that part
    book.put("camber", 0.7, 0.25)
    radius = book.rows["radius"][0]
    # feet that are points of the body: 0; round wheels that stay over their patches: the radius, less what the links carry; a
    # model without gravity's part in pitching: the CG's height
    book.put(
        "pitch_path",
        0.6 * radius,
        0.6 * radius,
        "height about which the body pitches over its wheels, m",
        SILENT,
    )
    mass, rate = vehicle.get("mass_kg"), vehicle.get("tire_vertical_rate_npm")
    # a braked tyre's patch lags behind its axle, a driven one's runs ahead (`patch_shift`): by two thirds of the squash where no
    # power comes from nowhere, by nothing where torque is force on the loaded radius
    third = patch_shift(mass.value if mass else None, rate.value if rate else None)[0]
    book.put("patch_lag", 1.35 * third, 0.75 * third)
    # braking hubs lean on their side-view swing arms: half the wheelbase over an arm's length of what they carry at hub height
    # goes past the springs. Long arms of front axles 0.1 to 0.3, parallel links none, short arms that point at the middle all
    book.put("hubs_past", 0.1, 0.25)
    book.put("jack_brake", 0.0, 0.04)
    book.put("jack_drive", *_drive_jacking(book))
    book.put("jack_side", *_side_jacking(book))
    roll = measured_roll_inertia(kilos, book.rows["track_front"][0])
    pitch = measured_pitch_inertia(kilos)
    book.quantity(
        "roll_inertia",
        "roll_inertia_kgm2",
        *((roll.value, roll.std) if roll else (0.34 * kilos, 0.1 * kilos)),
    )
    book.quantity(
        "pitch_inertia",
        "pitch_inertia_kgm2",
        *((pitch.value, pitch.std) if pitch else (1.6 * kilos, 0.4 * kilos)),
    )
    for name in ("roll_inertia", "pitch_inertia"):
        # of the empty whole vehicle: what the load adds follows from its unknowns (`body_inertias`), but for its own shape
        mean, std = book.rows[name]
        book.put(name, mean, float(np.hypot(std, 0.03 * mean)))


def _sensors(book: _Book) -> None:
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
        book.put(f"askew_{axis}", 0.0, 0.0175)
    for axis in ("x", "y", "z"):
        book.put(f"offset_{axis}", 0.0, 0.08 if axis != "z" else 0.02)
    book.assumptions.append(
        Assumption(
            "mounting and offsets of the inertial unit",
            "1 deg about each axis; 0.08 m/s² (0.02 m/s² vertical, of which the drive's mean is gravity)",
            "usual; unknowns of the fit",
        )
    )
    usual = 0.25 * GRAVITY * book.rows["empty_mass"][0]
    for kind, (scale, zero) in FORCE_SENSORS.items():
        for axle in AXLES:
            book.put(f"{kind}_scale_{axle}", 1.0, scale)
        for wheel in CORNERS:
            book.put(f"{kind}_zero_{wheel}", 0.0, float(np.hypot(zero, scale * usual)))
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
            book.put(f"late_{relation}_{kind}", 0.0, 0.03)
            book.put(f"gain_{relation}_{kind}", 0.0, 0.01 if relation == "roll" else 0.007)


def _long(book: _Book, kilos: float) -> None:
    """Drag, rolling, torque scales, lift."""
    vehicle = book.vehicle
    book.quantity("drag", "drag_area_m2", 0.75, 0.2)
    book.put("drag_height", 0.7, 0.25)
    for axle in AXLES:
        book.put(f"lift_{axle}", 0.0, 0.06)
    book.quantity("rolling", "rolling_resistance", 0.012, 0.004)
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
    book.put("late_long", 0.0, 0.05)
    book.put("tilt", 1.0, 0.3)
    book.put("gain_long", 0.0, 0.01)


def before_the_log(vehicle: Vehicle) -> Known:
    """Every unknown of the balances with what the vehicle file, the measured vehicles or custom say of it."""
    book = _Book(vehicle)
    _geometry(book)
    kilos = _empty(book)
    _load(book, kilos)
    springs = _suspension(book, kilos)
    _links(book, kilos)
    _sensors(book)
    _long(book, kilos)
    table = np.array(list(book.rows.values()))
    return Known(
        tuple(book.rows), table[:, 0], table[:, 1], tuple(book.assumptions), springs,
        vehicle.get("mass_kg") is not None,
    )  # fmt: skip
