"""What is known before the log of springs, bars, stops, dampers, dry friction and the deflections that show them."""

from __future__ import annotations

import numpy as np

from pipelines.joint.vehicle.book import AXLES, Book
from pipelines.models.roll import GRAVITY
from pipelines.results import Assumption
from pipelines.vehicles.anti_roll import silent_bar
from pipelines.vehicles.kinds import kind_of, usual_load
from pipelines.vehicles.kinematics import TRAVEL_M, free_travel, kink, spring_curve
from pipelines.vehicles.spring_base import narrowing, rigid_axle, usual_narrowing
from pipelines.vehicles.vehicle import Vehicle

CORNERS = ("fl", "fr", "rl", "rr")

ZERO_M = 0.001
"""Zero error of a deflection sensor."""

READ_N = 8.0
"""What a zero that was read on the empty vehicle is off by beside the reading: what springs and bushes creep by."""

STUCK = 0.018
"""Dry friction that holds a wheel at rest, over its load (spread): a car's springs stick by 1 to 3 % of it, either way."""

SLIDING = {False: (0.018, 0.014), True: (0.03, 0.02)}
"""Dry friction of a moving wheel over its load, mean and spread: by whether leaf springs or a live axle carry it."""

YIELDING = (0.5, 0.3)
"""Share of dry friction that gives by some 4 mm before it slides, the rest by less than one."""

SURELY = 0.005
"""Least spread of a stated bar over its axle's springs: rubber carries it, and nought may be what nobody looked up."""

STOP_A_METRE = 15.0
"""1/m: spread of a bump stop's force over the spring's rate, a m² of travel in which one may be touched."""

STOP_POWER = 1.5
STATED_STOP = (25.0, 20.0)
"""m^-1/2: the same a m^1.5 of travel into a stop whose place the file has, mean and spread: foams of a hundred spring rates a m², and
stops of three to six spring rates from the first touch."""


BELLOWS = (0.8, 0.3)
"""Growth of the rate of a spring that levels itself over that of the weight on it. Air at constant volume and its outside pressure: 0.85 to
0.95; gas of constant mass behind oil: above 1; pumps in dampers beside a steel spring: half of it."""
CARRIES = {"front": 0.85, "rear": 1.5}
"""Growth of an axle's sprung weight over a load's share of the vehicle's mass: six tenths of a load rest on the rear axle."""

FAR_M = 10.0

USUAL_CURVE = ((0.01, 0.02), (0.02, 0.04))
"""Square and cube of a spring's force over its linear part at TRAVEL_M, mean and spread: wheel rates rise with travel rather than fall,
at rear axles by a third where a load reaches their stops."""


LEAF_CURVE = ((0.05, 0.07), (0.05, 0.08))
"""The same of a rigid rear axle that carries loads: leaf springs of two stages rise by a half to all of their rate, others by little."""


def usual_curve(vehicle: Vehicle, axle: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Square and cube of an axle's spring force where no rig measured them."""
    leaves = axle == "rear" and kind_of(vehicle) != "car" and rigid_axle(vehicle, axle)
    return LEAF_CURVE if leaves else USUAL_CURVE


def _bars(book: Book) -> None:
    """Roll stiffness of each axle beside springs on the wheels' track: anti-roll bars, less what springs that stand closer lack.

    Stated, or what the stated roll stiffness leaves, which then binds all parts of it as a relation, or hardly known.
    """
    vehicle = book.vehicle
    springs = {a: 0.5 * book.rows[f"spring_{a}"][0] * book.rows[f"track_{a}"][0] ** 2 for a in AXLES}
    stated = {a: vehicle.get(f"anti_roll_stiffness_{a}_nmprad") for a in AXLES}
    # a bar that nobody states holds in its own spread how close the springs may stand
    narrow = {a: (narrowing if stated[a] is None else usual_narrowing)(vehicle, a) for a in AXLES}
    lacks = {a: (1 - narrow[a][0] ** 2) * springs[a] for a in AXLES}
    unsure = {a: 2 * narrow[a][0] * narrow[a][1] * springs[a] for a in AXLES}
    total = vehicle.get("roll_stiffness_nmprad")
    told = sum(q.value - lacks[a] for a, q in stated.items() if q is not None)
    left = None if total is None else total.value - sum(springs.values()) - told
    silent = [a for a in AXLES if stated[a] is None]
    for axle, share in zip(AXLES, (0.6, 0.4), strict=True):
        known, name, title = stated[axle], f"bar_{axle}", f"anti-roll bar, {axle}, N·m/rad"
        if known is not None:
            std = max(float(np.hypot(known.std, unsure[axle])), SURELY * springs[axle])
            book.keys[name] = f"anti_roll_stiffness_{axle}_nmprad"
            book.put(name, known.value - lacks[axle], std, book.keys[name], known.source)
        elif total is not None and left is not None:
            part = left if len(silent) == 1 else _shared(left, share, axle)
            # wide: the stated sum binds them (`stated`), and is not to count twice
            book.put(name, part, 0.3 * springs[axle], title, "roll_stiffness_nmprad less springs")
        else:
            mean, spread = (part * springs[axle] for part in silent_bar(vehicle, axle))
            book.put(name, mean - lacks[axle], float(np.hypot(spread, unsure[axle])), title)


def _shared(left: float, share: float, axle: str) -> float:
    """An axle's part of what a stated roll stiffness leaves beside the springs: what it lacks is a rigid rear axle's."""
    if left >= 0:
        return share * left
    return left if axle == "rear" else 0.0


def levelled_n(vehicle: Vehicle, kilos: float) -> float:
    """N: how far a wheel's spring force may be from what its deflection says, where springs level themselves: a load's share."""
    usual = usual_load(vehicle, kilos)
    return 0.4 * GRAVITY * float(np.hypot(usual.mean, usual.std))


def levels(vehicle: Vehicle, axle: str) -> bool:
    """Whether the axle's springs keep the body's height under any load."""
    return vehicle.self_levelling == "both" or (vehicle.self_levelling == "rear" and axle == "rear")


def loaded_rate(
    axle: str, rate: tuple[float, float], load: tuple[float, float], kilos: float
) -> tuple[float, float]:
    """Mean and spread of the rate under load, N/m, of springs that level themselves. rate: of the empty vehicle; load: kg."""
    more, unsure = (CARRIES[axle] * x / kilos for x in load)
    grows, spread = BELLOWS
    factor, off = 1 + grows * more, float(np.hypot(grows * unsure, spread * np.hypot(more, unsure)))
    return factor * rate[0], float(np.hypot(factor * rate[1], off * rate[0]))


def _as_loaded(book: Book, axle: str, kilos: float) -> None:
    """The unknown is the rate of the drive: stated is the empty vehicle's."""
    said = (
        f"springs that level themselves: {BELLOWS[0]:g} ± {BELLOWS[1]:g} of what the weight on them grows by"
    )
    mean, std = loaded_rate(axle, book.rows[f"spring_{axle}"], book.rows["load"], kilos)
    book.put(f"spring_{axle}", mean, std, f"spring rate, {axle}, under load, N/m", said)


def _zero_words(vehicle: Vehicle) -> str:
    """How well the deflections' zero is known, for the report."""
    if vehicle.deflection_zero == "loaded":
        return "as open as a load"
    stated = [vehicle.sensors.get(f"suspension_deflection_{wheel}_m") for wheel in CORNERS]
    spreads = [1e3 * (ZERO_M if zero is None else zero.std) for zero in stated]
    least, most = f"{min(spreads):g}", f"{max(spreads):g}"
    return f"{least} mm" if least == most else f"{least} to {most} mm"


def _curve_words(vehicle: Vehicle) -> tuple[str, str]:
    """What the springs' curves are taken for, and from where, for the report."""
    told = [spring_curve(vehicle.quantities, axle) is not None for axle in AXLES]
    if all(told):
        return "from the rates 50 mm above and below ride height", "vehicle file"
    usual = [
        "{:.0f} ± {:.0f} % (square), {:.0f} ± {:.0f} % (cube) at 50 mm".format(
            *(100 * x for pair in usual_curve(vehicle, axle) for x in pair)
        )
        for axle in AXLES
    ]
    words = ["as stated" if known else text for known, text in zip(told, usual, strict=True)]
    if words[0] == words[1]:
        return words[0], "usual; unknowns of the fit"
    return "; ".join(f"{a}: {w}" for a, w in zip(AXLES, words, strict=True)), "usual; unknowns of the fit"


def _curve(book: Book, axle: str, rate: float) -> None:
    """How an axle's wheel rate changes with travel: what is usual, and what a rig found, each by its weight.

    Springs that may have a kink are none of the usual ones: what the rig found alone.
    """
    found = spring_curve(book.vehicle.quantities, axle)
    bent = kink(book.vehicle.quantities, axle) > 0
    for power, (name, (mean, std)) in enumerate(
        zip(("square", "cube"), usual_curve(book.vehicle, axle), strict=True), start=1
    ):
        usual, spread = rate * mean / TRAVEL_M**power, rate * std / TRAVEL_M**power
        if found is not None:
            told, unsure = found[power - 1][0], max(found[power - 1][1], 1e-3 * spread)
            weight = 1.0 if bent else spread**2 / (spread**2 + unsure**2)
            usual, spread = usual + weight * (told - usual), unsure * weight**0.5
        book.put(f"{name}_{axle}", usual, spread)


def _free(book: Book, axle: str, told: bool) -> None:
    """Travel from where the empty vehicle stands to the bump stop, m; beyond all travel where the file does not tell it."""
    clearance = book.vehicle.get(f"bump_stop_clearance_{axle}_m")
    if clearance is None or not told:
        book.put(f"free_{axle}", FAR_M, 0.0)
    else:
        book.put(
            f"free_{axle}", clearance.value, clearance.std, f"bump_stop_clearance_{axle}_m", clearance.source
        )


def suspension(book: Book, kilos: float) -> bool:
    """Springs, bars, dampers, friction; whether the spring rates are known."""
    vehicle = book.vehicle
    corner = 0.23 * kilos
    free = free_travel(vehicle)
    springs = all(vehicle.get(f"spring_rate_{axle}_npm") is not None for axle in AXLES)
    for axle in AXLES:
        book.quantity(f"spring_{axle}", f"spring_rate_{axle}_npm", corner * 70.0, corner * 40.0)
    _bars(book)
    for axle in AXLES:
        if levels(vehicle, axle):
            _as_loaded(book, axle, kilos)
        rate = book.rows[f"spring_{axle}"][0]
        _curve(book, axle, rate)
        # half a spring's force more, 30 mm into it, where nobody knows where it begins
        book.put(
            f"stop_{axle}", *((0.0, rate * STOP_A_METRE) if free is None else (rate * x for x in STATED_STOP))
        )
        _free(book, axle, free is not None)
        usual = 0.3 * 2 * np.sqrt(rate * corner)
        known = vehicle.get(f"damper_rate_{axle}_nspm")
        mean, spread = (usual, 0.5) if known is None else (known.value, 0.3)
        # dampers hold rebound more than bump; a knee takes some of both
        book.put(f"bump_{axle}", 0.75 * mean, spread * mean)
        book.put(f"rebound_{axle}", 1.2 * mean, spread * mean)
        share, spread = SLIDING[rigid_axle(vehicle, axle)]
        book.put(f"friction_{axle}", share * GRAVITY * corner, spread * GRAVITY * corner)
    # a zero that is off by a travel twists the bars as well; springs that level themselves are off by a force alone
    book.put("zero_twists", float(not levels(vehicle, "rear")), 0.0)
    # how much of it turns round within millimetres only
    book.put("yielding", *YIELDING)
    stuck = STUCK * GRAVITY * corner
    for wheel in CORNERS:
        rate = book.rows[f"spring_{'front' if wheel[0] == 'f' else 'rear'}"][0]
        stated = vehicle.sensors.get(f"suspension_deflection_{wheel}_m")
        zero = float(np.hypot(ZERO_M * rate, 20.0) if stated is None else np.hypot(stated.std * rate, READ_N))
        axle = "front" if wheel[0] == "f" else "rear"
        if levels(vehicle, axle) or vehicle.deflection_zero == "loaded":
            zero = levelled_n(vehicle, kilos)
        book.put(f"zero_{wheel}", 0.0, zero)
        book.put(f"stuck_{wheel}", 0.0, stuck)
        book.put(f"scale_{wheel}", 1.0, 0.01)
    book.assumptions.append(
        Assumption(
            "zero and scale error of a deflection sensor, friction at rest",
            f"{_zero_words(vehicle)}, 1 % and {stuck:.0f} N a wheel",
            "usual; unknowns of the fit",
        )
    )
    book.assumptions.append(
        Assumption(
            "curvature of the springs",
            *_curve_words(vehicle),
        )
    )
    return springs
