"""What is known of the vehicle before the log, as many draws: masses, heights, inertia, load, tyres, springs.

Everything that the vehicle file states comes in with its spread; everything it is silent about comes from the
measured vehicles or from a stated assumption. The draws keep what belongs together: a load changes the mass, the
height and the inertia at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pipelines.joint.ways.rigid_tyres import CHANCE, STATED_CHANCE
from pipelines.prepare.roll_angle import TYPICAL_TRACK
from pipelines.results import Assumption, FloatArray, Prior
from pipelines.vehicles.anti_roll import closer_springs, usual_bar
from pipelines.vehicles.kinds import DRIVER, LOAD_SPREAD, usual_load
from pipelines.vehicles.priors import measured_cg_height, measured_roll_inertia
from pipelines.vehicles.spring_base import spring_base
from pipelines.vehicles.usual import usual_roll_axis, usual_tyre_rate, usual_unsprung_share
from pipelines.vehicles.vehicle import Quantity, Vehicle

LOAD_HEIGHT_RATIO = (1.1, 0.3)
ROOF_SHARE = 0.3
ROOF_RATIO = (2.0, 2.9)
HUB_HEIGHT = (0.32, 0.03)
IMU_HEIGHT = (0.5, 0.2)
TYRE_RATIO = (0.83, 0.04)
ANY_HEIGHT = (0.9, 0.4)
GYRATION_SHARE = (0.38, 0.06)
TAIL = 5.0
"""Where the vehicle file is silent: mean and standard deviation (kg, m; shares of mass, of height, of
track). TAIL: degrees of freedom of the measured heights about their mean."""

STIFFER = 100.0
"""How much stiffer tyres that do not give are."""


def _figure(value: float) -> str:
    """A figure for prose: four digits, never with an exponent."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"


@dataclass(frozen=True)
class VehicleDraws:
    """Draws of the loaded vehicle, each (n,): SI. height: of the whole vehicle; arm: sprung CG above the roll axis.

    body_inertia: of the sprung mass about its own CG. imu: accelerometer above the roll axis. tyre_roll: roll
    stiffness of the tyres in N·m/rad.
    """

    mass: FloatArray
    sprung: FloatArray
    unsprung: FloatArray
    hub: FloatArray
    height: FloatArray
    sprung_height: FloatArray
    roll_axis: FloatArray
    arm: FloatArray
    inertia: FloatArray
    body_inertia: FloatArray
    imu: FloatArray
    tyre_roll: FloatArray
    possible: np.ndarray


@dataclass
class _Book:
    """Draws quantities and writes down what was assumed."""

    rng: np.random.Generator
    count: int
    assumptions: list[Assumption] = field(default_factory=list)

    def normal(self, mean: float, std: float) -> FloatArray:
        return np.asarray(mean + std * self.rng.standard_normal(self.count))

    def tailed(self) -> FloatArray:
        """Student's draws of unit spread, for measured heights: 1 % of the vehicles sit beyond three standard
        deviations (electric ones with the battery in the floor, 4-5 below), where a normal law has 0.3 %."""
        scale = math.sqrt((TAIL - 2) / TAIL)
        return np.asarray(scale * self.rng.standard_t(TAIL, self.count))

    def known(self, name: str, quantity: Quantity, unit: str) -> FloatArray:
        self.assumptions.append(
            Assumption(
                name, f"{_figure(quantity.value)} ± {_figure(quantity.std)} {unit}".rstrip(), quantity.source
            )
        )
        return self.normal(quantity.value, quantity.std)

    def assumed(self, name: str, pair: tuple[float, float], unit: str, source: str) -> FloatArray:
        self.assumptions.append(
            Assumption(name, f"{_figure(pair[0])} ± {_figure(pair[1])} {unit}".rstrip(), source)
        )
        return self.normal(*pair)


SILENT = "the vehicle file is silent: usual for road vehicles"


def _empty_height(book: _Book, vehicle: Vehicle, mass: float) -> tuple[FloatArray, str | None]:
    stated = vehicle.get("cg_height_m")
    if stated is not None:
        return book.known("cg_height_m (empty)", stated, "m"), stated.source
    prior = measured_cg_height(vehicle.body, mass, vehicle.powertrain)
    if prior is not None:
        book.assumptions.append(
            Assumption("cg_height_m (empty)", f"{prior.value:.4g} ± {prior.std:.3g} m", prior.source)
        )
        return prior.value + prior.std * book.tailed(), prior.source
    book.assumptions.append(
        Assumption("cg_height_m (empty)", "anything from 0.3 to 2.5 m", "no measured vehicle is like it")
    )
    ratio = ANY_HEIGHT[1] / ANY_HEIGHT[0]
    return np.asarray(ANY_HEIGHT[0] * np.exp(book.normal(0.0, ratio))), None


def _load(book: _Book, vehicle: Vehicle, empty_height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mass and height of the load."""
    stated = vehicle.load.get("mass_kg")
    if stated is not None:
        mass = np.maximum(book.known("load mass", stated, "kg"), 0.0)
    else:
        driver = np.maximum(book.normal(*DRIVER), 40.0)
        usual = usual_load(vehicle, vehicle.quantities["mass_kg"].value)
        further = np.minimum(book.rng.exponential(usual.further, book.count), usual.most)
        mass = np.asarray(driver + further)
        text = f"a driver of {DRIVER[0]:g} ± {DRIVER[1]:g} kg and 0-{usual.most:.0f} kg more ({usual.further:.0f} kg in the mean)"
        book.assumptions.append(Assumption("load mass", text, vehicle.load_unsaid))
    height = vehicle.load.get("height_m")
    if height is not None:
        return mass, np.maximum(book.known("load height", height, "m"), 0.1)
    if stated is None or stated.value > 0:
        text = (
            f"{LOAD_HEIGHT_RATIO[0]:g} ± {LOAD_HEIGHT_RATIO[1]:g} of the empty vehicle's CG height; what is beside the driver "
            f"is on the roof ({ROOF_RATIO[0]:g}-{ROOF_RATIO[1]:g} of it) with a chance of {ROOF_SHARE:g}"
        )
        book.assumptions.append(
            Assumption("load height", text, "the vehicle file states none: seats, boot or roof")
        )
    inside = np.maximum(book.normal(*LOAD_HEIGHT_RATIO), 0.3)
    above = np.where(
        book.rng.random(book.count) < ROOF_SHARE, book.rng.uniform(*ROOF_RATIO, book.count), inside
    )
    person = np.minimum(mass, DRIVER[0]) / np.maximum(mass, 1.0)
    return mass, empty_height * (person * inside + (1 - person) * above)


def _unsprung(book: _Book, vehicle: Vehicle, mass: FloatArray) -> FloatArray:
    front, rear = vehicle.get("unsprung_mass_front_kg"), vehicle.get("unsprung_mass_rear_kg")
    if front is not None and rear is not None:
        return book.known("unsprung mass, front", front, "kg") + book.known("unsprung mass, rear", rear, "kg")
    share = book.assumed("unsprung mass", usual_unsprung_share(vehicle), "of the empty mass", SILENT)
    return mass * np.clip(share, 0.03, 0.3)


def _roll_axis(book: _Book, vehicle: Vehicle) -> FloatArray:
    front, rear = vehicle.get("roll_center_height_front_m"), vehicle.get("roll_center_height_rear_m")
    if front is None or rear is None:
        known = front or rear
        if known is None:
            return book.assumed("roll axis above ground, under the CG", usual_roll_axis(vehicle), "m", SILENT)
        wide = Quantity(known.value, math.hypot(known.std, 0.05), "vehicle file, one axle only")
        return book.known("roll axis above ground, under the CG", wide, "m")
    a, wheelbase = vehicle.get("cg_to_front_axle_m"), vehicle.get("wheelbase_m")
    share = 0.5 if a is None or wheelbase is None else a.value / wheelbase.value
    ahead = book.known("roll centre height, front", front, "m")
    behind = book.known("roll centre height, rear", rear, "m")
    return np.asarray((1 - share) * ahead + share * behind)


def _track(vehicle: Vehicle) -> Quantity | None:
    tracks = [q for key in ("track_front_m", "track_rear_m") if (q := vehicle.get(key)) is not None]
    if not tracks:
        return None
    return Quantity(sum(q.value for q in tracks) / len(tracks), max(q.std for q in tracks), "vehicle file")


INERTIA_NAMES = ("roll_inertia_kgm2 (empty)", "roll radius of gyration")
"""How the assumption on the roll inertia is called: of the whole vehicle about its CG, as on data sheets and in the
measured table."""


def _inertia(book: _Book, vehicle: Vehicle, mass: FloatArray, track: Quantity | None) -> FloatArray:
    stated = vehicle.get("roll_inertia_kgm2")
    if stated is not None:
        return book.known(INERTIA_NAMES[0], stated, "kg·m²")
    prior = measured_roll_inertia(float(np.mean(mass)), None if track is None else track.value)
    if prior is not None:
        return book.assumed(INERTIA_NAMES[0], (prior.value, prior.std), "kg·m²", prior.source)
    width = TYPICAL_TRACK[0] if track is None else track.value
    share = book.assumed(INERTIA_NAMES[1], GYRATION_SHARE, "of the track", SILENT)
    return mass * (np.maximum(share, 0.2) * width) ** 2


def rigid_tyres(vehicle: Vehicle) -> float:
    """Chance that tyres do not give at all, as on rims and in many a simulator, by what the vehicle file says of them and of the log."""
    if vehicle.real:
        return 0.0
    return CHANCE if vehicle.get("tire_vertical_rate_npm") is None else STATED_CHANCE


def _tyres(book: _Book, vehicle: Vehicle, track: Quantity | None) -> FloatArray:
    rate = vehicle.get("tire_vertical_rate_npm")
    rigid = book.rng.random(book.count) < rigid_tyres(vehicle)
    width = track or Quantity(*TYPICAL_TRACK, "usual track")
    name = "tire_vertical_rate_npm (a tyre, four in all)"
    if rate is not None:
        each = book.known(name, rate, "N/m")
    else:
        each = book.assumed(name, usual_tyre_rate(vehicle), "N/m", SILENT)
    stiffness = np.maximum(each, 0.2 * np.median(each)) * book.normal(width.value, width.std) ** 2
    return np.where(rigid, STIFFER * stiffness, stiffness)


def draw_vehicle(
    vehicle: Vehicle, rng: np.random.Generator, count: int
) -> tuple[VehicleDraws, tuple[Assumption, ...], str | None]:
    """Draws of the loaded vehicle, what was assumed, and where the CG height's prior is from (None: from nowhere).

    Needs `mass_kg` in the vehicle file.
    """
    book = _Book(rng, count)
    stated_mass = vehicle.quantities["mass_kg"]
    empty = np.maximum(book.known("mass_kg (empty)", stated_mass, "kg"), 0.3 * stated_mass.value)
    empty_height, height_source = _empty_height(book, vehicle, stated_mass.value)
    load, load_height = _load(book, vehicle, empty_height)
    unsprung = _unsprung(book, vehicle, empty)
    radius = vehicle.get("wheel_radius_m")
    hub = (
        book.known("hub height", radius, "m")
        if radius
        else book.assumed("hub height", HUB_HEIGHT, "m", SILENT)
    )
    track = _track(vehicle)
    if track is None:
        book.assumptions.append(Assumption("track", f"{TYPICAL_TRACK[0]:g} ± {TYPICAL_TRACK[1]:g} m", SILENT))
    empty_inertia = _inertia(book, vehicle, empty, track)
    roll_axis = _roll_axis(book, vehicle)
    above_ground = vehicle.sensors.get("imu_above_ground_m")
    imu = (
        book.known("accelerometer above ground", above_ground, "m")
        if above_ground
        else book.assumed(
            "accelerometer above ground", IMU_HEIGHT, "m", "the vehicle file has no imu_above_ground_m"
        )
    )
    tyre_roll = _tyres(book, vehicle, track)
    mass = empty + load
    height = (empty * empty_height + load * load_height) / mass
    sprung = mass - unsprung
    sprung_height = (mass * height - unsprung * hub) / sprung
    shared = empty * load / mass * (load_height - empty_height) ** 2
    width = TYPICAL_TRACK[0] if track is None else track.value
    inertia = empty_inertia + shared + LOAD_SPREAD[0] * width**2 * load
    half_track = width / 2
    hubs = unsprung * (half_track**2 + (hub - height) ** 2)
    body_inertia = inertia - hubs - sprung * (sprung_height - height) ** 2
    arm = sprung_height - roll_axis
    possible = (
        (arm > 0.05)
        & (sprung > 0.4 * mass)
        & (body_inertia > 0.2 * inertia)
        & (height > 0.15)
        & (height < 3.0)
    )
    draws = VehicleDraws(
        mass, sprung, unsprung, hub, height, sprung_height, roll_axis, arm, inertia, body_inertia,
        imu - roll_axis, tyre_roll, possible,
    )  # fmt: skip
    return draws, tuple(book.assumptions), height_source


def _per_axle(vehicle: Vehicle, rate: str) -> Quantity | None:
    """Roll stiffness (or damping) of both axles from a wheel's rate and the track; None if incomplete."""
    value = square = 0.0
    for axle in ("front", "rear"):
        spring = vehicle.get(f"{rate}_{axle}_{'npm' if rate == 'spring_rate' else 'nspm'}")
        track = spring_base(vehicle, axle)
        if spring is None or track is None:
            return None
        part = 0.5 * spring.value * track.value**2
        value += part
        square += part**2 * ((spring.std / spring.value) ** 2 + (2 * track.std / track.value) ** 2)
    return Quantity(value, math.sqrt(square), "vehicle file")


def _bars(vehicle: Vehicle) -> tuple[float, float, str]:
    """Roll stiffness of the anti-roll bars, N m/rad: mean, std, words. Silent ones are alike: both axles' or neither's are stiff."""
    value = square = unsure = 0.0
    silent = []
    for axle in ("front", "rear"):
        stated = vehicle.get(f"anti_roll_stiffness_{axle}_nmprad")
        if stated is not None:
            less, unsure_base = closer_springs(vehicle, axle)
            value, square = value + stated.value - less, square + stated.std**2 + unsure_base**2
            continue
        usual = usual_bar(axle, vehicle)
        value, unsure = value + usual.value, unsure + usual.std
        silent.append(axle)
    if not silent:
        return value, math.sqrt(square), "anti-roll bars"
    which = "anti-roll bars" if len(silent) == 2 else f"{silent[0]} anti-roll bar"
    return value, math.hypot(math.sqrt(square), unsure), f"usual {which}, which it does not state (0 = none)"


def stiffness_prior(vehicle: Vehicle) -> Prior | None:
    """Roll stiffness of the suspension (body against axles): stated, or from springs, track and bars."""
    stated = vehicle.get("roll_stiffness_nmprad")
    if stated is not None:
        return Prior(stated.value, stated.std, "vehicle file")
    springs = _per_axle(vehicle, "spring_rate")
    if springs is None:
        return None
    bars, spread, words = _bars(vehicle)
    return Prior(
        springs.value + bars, math.hypot(springs.std, spread), f"vehicle file: springs and track, {words}"
    )


def damping_prior(vehicle: Vehicle) -> Prior | None:
    """Roll damping of the suspension: stated, or from damper rates and track."""
    stated = vehicle.get("roll_damping_nmsprad")
    if stated is not None:
        return Prior(stated.value, stated.std, "vehicle file")
    dampers = _per_axle(vehicle, "damper_rate")
    if dampers is None:
        return None
    # a damper's rate is that of one speed and knows nothing of friction, which the estimate holds as well
    std = math.hypot(dampers.std, 0.2 * dampers.value)
    return Prior(dampers.value, std, "vehicle file: damper rates and track")
