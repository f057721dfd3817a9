"""What is usual of vehicles of a kind, where a file is silent: wheels, axles, drag. Means and standard deviations, SI.

Cars' figures are those of their size, which their mass tells; lorries and buses have other wheels and axles altogether: a drive axle with
twin tyres weighs a tonne, and its roll centre lies where its springs are.
"""

from __future__ import annotations

from pipelines.vehicles.kinds import Kind, kind_of
from pipelines.vehicles.measured import known_body
from pipelines.vehicles.vehicle import Vehicle

Spread = tuple[float, float]

STRUT_SCALE, STRUT_ZERO_N = 0.008, 40.0
"""What a strut's force sensor may be wrong by (standard deviations): share of the force, and N; of zeros also what they drift from drive to
drive."""

TALL_WHEELS = frozenset(("SUV", "Pickup"))
LIGHT_HEAVY_KG = 5000.0
"""Empty mass up to which a heavy vehicle stands on a van's wheels, and is not much larger than one."""

UNSPRUNG: dict[Kind, tuple[Spread, Spread]] = {
    "car": ((0.052, 0.013), (0.052, 0.013)),
    "carrier": ((0.052, 0.013), (0.07, 0.022)),
    "heavy": ((0.07, 0.02), (0.115, 0.03)),
}
"""Of the empty mass, front and rear axle: a driven rigid axle is twice as heavy as links and hubs."""

RADIUS_M: dict[Kind, tuple[float, float, float, float]] = {
    "car": (0.322, 1500.0, 0.3, 0.022), "carrier": (0.335, 2000.0, 0.12, 0.025), "heavy": (0.36, 3500.0, 0.35, 0.04),
}  # fmt: skip
"""Rolling radius at a mass, that mass in kg, the power of the mass that it goes with, and its spread in m."""
TALLER, LARGEST_M = 1.1, 0.51

ROLL_CENTER: dict[bool, Spread] = {False: (0.09, 0.06), True: (0.25, 0.15)}
"""m above ground: of independent suspensions, and of live axles, which leaf springs hold at their own height and linkages lower."""
HEAVY_ROLL_CENTER: tuple[Spread, Spread] = ((0.42, 0.2), (0.62, 0.2))
"""The same of lorries and buses, front and rear: some have independent front wheels."""

ROLL_AXIS: dict[Kind, Spread] = {"car": (0.08, 0.07), "carrier": (0.15, 0.1), "heavy": (0.52, 0.18)}

CAMBER: dict[bool, Spread] = {False: (0.65, 0.25), True: (0.8, 0.18)}
"""How upright links hold the wheels, mean of both axles; with a live rear axle, whose wheels stay upright."""
HEAVY_CAMBER: Spread = (0.9, 0.12)

DRAG_M2: dict[Kind, Spread] = {"car": (0.75, 0.2), "carrier": (1.4, 0.5), "heavy": (4.8, 1.5)}
PICKUP_DRAG_M2, BOX_DRAG_M2 = (1.1, 0.3), (2.6, 1.2)
"""Drag area: a motorhome, or what weighs 3.5 to 5 t, is between a van and a lorry."""

TYRE_NPM, TYRE_NPM_KG, HEAVY_TYRE_NPM_KG = 150e3, 45.0, 115.0
"""A tyre's vertical rate at no mass and what each kg of the empty vehicle adds to it: 190 kN/m under a small car, 250 under an SUV; and
what it is a kg under lorries and buses, whose tyres are blown up to 8 bar."""

ROLLING: dict[Kind, Spread] = {"car": (0.012, 0.004), "carrier": (0.012, 0.004), "heavy": (0.008, 0.003)}


def _mass(vehicle: Vehicle) -> float:
    mass = vehicle.get("mass_kg")
    return 1800.0 if mass is None else mass.value


def usual_unsprung(vehicle: Vehicle, axle: str, kilos: float) -> Spread:
    """kg of an axle with its wheels, of an empty vehicle of so many kg."""
    mean, std = UNSPRUNG[kind_of(vehicle)][axle == "rear"]
    return mean * kilos, std * kilos


def usual_unsprung_share(vehicle: Vehicle) -> Spread:
    """Of the empty mass, both axles: what makes one of them heavy does the other."""
    front, rear = UNSPRUNG[kind_of(vehicle)]
    return front[0] + rear[0], front[1] + rear[1]


def usual_radius(vehicle: Vehicle) -> Spread:
    """Rolling radius of a wheel, m."""
    if vehicle.get("mass_kg") is None:
        return 0.33, 0.03
    kind, style = kind_of(vehicle), known_body(vehicle.body)
    at, kilos, power, spread = RADIUS_M["car" if style in TALL_WHEELS and kind != "heavy" else kind]
    taller = TALLER if style in TALL_WHEELS and kind != "heavy" else 1.0
    return min(taller * at * (_mass(vehicle) / kilos) ** power, LARGEST_M), spread


def usual_tyre_rate(vehicle: Vehicle) -> Spread:
    """Vertical rate of one of four tyres, N/m: twin tyres are one."""
    mass = _mass(vehicle)
    car = TYRE_NPM + TYRE_NPM_KG * mass
    if kind_of(vehicle) == "heavy":
        heavy = max(car, HEAVY_TYRE_NPM_KG * mass)
        return heavy, 0.25 * heavy
    return car, 0.17 * car


def usual_wheel_inertia(vehicle: Vehicle, radius_m: float) -> Spread:
    """Of one wheel with what turns with it, kg m²: mean of all, twin tyres counted in."""
    mean = 1.1 * (radius_m / 0.33) ** 4.5 * (1.5 if kind_of(vehicle) == "heavy" else 1.0)
    return mean, 0.35 * mean


def usual_drag(vehicle: Vehicle) -> Spread:
    """Drag area, m²."""
    kind, style = kind_of(vehicle), known_body(vehicle.body)
    if style == "Pickup" and kind != "heavy":
        return PICKUP_DRAG_M2
    boxed = kind == "carrier" and style is None and vehicle.body is not None
    return BOX_DRAG_M2 if boxed or (kind == "heavy" and _mass(vehicle) < LIGHT_HEAVY_KG) else DRAG_M2[kind]


def usual_rolling(vehicle: Vehicle) -> Spread:
    """Rolling resistance, N a N."""
    return ROLLING[kind_of(vehicle)]


def usual_roll_center(vehicle: Vehicle, axle: str, rigid: bool) -> Spread:
    """Height of an axle's roll centre above ground, m. rigid: whether a beam joins its wheels."""
    return HEAVY_ROLL_CENTER[axle == "rear"] if kind_of(vehicle) == "heavy" else ROLL_CENTER[rigid]


def usual_roll_axis(vehicle: Vehicle) -> Spread:
    """Height of the roll axis below the CG, m, where neither axle's roll centre is known."""
    return ROLL_AXIS[kind_of(vehicle)]


def usual_camber(vehicle: Vehicle, rigid: bool) -> Spread:
    """How upright links hold the wheels, mean of both axles. rigid: whether the rear axle is."""
    return HEAVY_CAMBER if kind_of(vehicle) == "heavy" else CAMBER[rigid]


def usual_track(vehicle: Vehicle) -> Spread:
    """m between the wheels of an axle."""
    return (1.95, 0.15) if kind_of(vehicle) == "heavy" else (1.55, 0.08)


def usual_wheelbase(vehicle: Vehicle) -> Spread:
    """m."""
    return {"car": (2.7, 0.2), "carrier": (3.2, 0.35), "heavy": (4.6, 1.0)}[kind_of(vehicle)]


ENGINE_DRAG: dict[str | None, tuple[float, float]] = {"battery": (0.5, 0.6), "hybrid": (0.3, 0.5)}
"""m/s² that the motor adds to the brakes while they are on: charging takes up to a third of g, and blending leaves it to the driven axle."""


def usual_engine_drag(vehicle: Vehicle) -> tuple[float, float]:
    """What an engine in gear, or a motor, adds to the brakes where no log tells its torque, m/s²: mean and spread."""
    return ENGINE_DRAG.get(vehicle.powertrain, (0.05, 0.12))


RECOVERY: dict[str | None, tuple[float, float]] = {"battery": (0.15, 0.25), "hybrid": (0.1, 0.2)}
"""Of a stop's force: pedals that are blended have the motor take more of a harder stop, up to what battery and tyres bear."""


def usual_recovery(vehicle: Vehicle) -> tuple[float, float]:
    """Share of the deceleration that a motor makes beside `usual_engine_drag`: mean and spread; none of an engine's."""
    return RECOVERY.get(vehicle.powertrain, (0.0, 0.0))
