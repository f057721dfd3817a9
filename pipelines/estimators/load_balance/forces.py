"""The suspension's vertical forces at the wheels, by each carrier that shows them: their terms in a balance."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pipelines.joint.vehicle.body import empty_corner, even_factor, held_rate
from pipelines.joint.vehicle.laden import side_moment
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS, Body, Values
from pipelines.models.braking import AIR_DENSITY
from pipelines.models.roll import GRAVITY

Terms = dict[str, float]


def add(terms: Terms, name: str, value: float) -> None:
    """Add to a coefficient."""
    terms[name] = terms.get(name, 0.0) + value


def add_swing(terms: Terms, axis: str, amount: float, p: Values) -> None:
    """Adds amount * the body's angular acceleration about an axis: as sensors show it, or as springs are taken to make it of the accelerations."""
    add(terms, f"{axis}_acc", amount)
    add(terms, f"guessed_{axis}_acc", amount * p["guessed_swing"])


def add_shafts(terms: Terms, amount: float, p: Values, body: Body, head: str = "") -> None:
    """Adds amount * what shafts pull while the brakes are on, N: by the log's drive torque, else what an engine holds back as a rule."""
    add(terms, f"{head}drive_on", amount * even_factor(p["drive_scale"]) / p["radius"])
    add(terms, f"{head}held_on", -amount * body.mass * p["engine_drag"])
    add(terms, f"{head}held_fx", amount * body.mass * p["recovered"])


def air_pressure(p: Values) -> float:
    """Of the air at 1 m/s, Pa."""
    return 0.5 * AIR_DENSITY * p["air"]


def _axle(wheel: str) -> str:
    return "front" if wheel[0] == "f" else "rear"


def _zero(p: Values, axle: str, wheel: str, other: str) -> float:
    """What a wheel's force is off by where the deflections' zeros are, N: by the travel that a zero is off by, the bar as well as the spring.

    Springs that level themselves are off by a force, and twist no bar.
    """
    bar = p[f"bar_{axle}"] / p[f"track_{axle}"] ** 2
    twist = p["zero_twists"] * bar / p[f"spring_{axle}"]
    return p[f"zero_{wheel}"] + twist * (p[f"zero_{wheel}"] - p[f"zero_{other}"])


def _by_deflection(p: Values, lever: Sequence[float], terms: Terms) -> None:
    """Adds lever * S of the four wheels, S from the deflections.

    What springs that stand closer together than the wheels lack in roll is in the bar; what is not linear in them, and the dampers and dry
    friction beside them, have levers of their own, and columns by the travel there (`data`).
    """
    for i, wheel in enumerate(CORNERS):
        axle, arm = _axle(wheel), lever[i]
        apart = p[f"spring_base_{axle}"]
        inside = 0.5 * ((1 + apart) * arm + (1 - apart) * lever[i ^ 1])
        side = 1.0 if wheel[1] == "l" else -1.0
        bar = p[f"bar_{axle}"] / p[f"track_{axle}"] ** 2
        other = wheel[0] + ("r" if wheel[1] == "l" else "l")
        add(terms, f"d_{wheel}", arm * p[f"scale_{wheel}"] * (p[f"spring_{axle}"] + bar))
        add(terms, f"d_{other}", -arm * p[f"scale_{other}"] * bar)
        add(terms, f"d2_{wheel}", inside * p[f"square_{axle}"])
        add(terms, f"d3_{wheel}", inside * p[f"cube_{axle}"])
        add(terms, f"stop_{wheel}", inside * p[f"stop_{axle}"])
        add(terms, f"bump_{wheel}", inside * p[f"bump_{axle}"])
        add(terms, f"rebound_{wheel}", inside * p[f"rebound_{axle}"])
        add(terms, f"stick_{wheel}", inside * p[f"friction_{axle}"] * (1 - p["yielding"]))
        add(terms, f"yield_{wheel}", inside * p[f"friction_{axle}"] * p["yielding"])
        cross = side * GRAVITY * p["empty_mass"] * p["empty_y"] / (p["track_front"] + p["track_rear"])
        add(terms, "one", arm * (empty_corner(p, axle) + cross + _zero(p, axle, wheel, other)))
        add(terms, "rest", inside * p[f"stuck_{wheel}"])
        add(terms, f"scrub_{axle}", arm * held_rate(p, axle))


def by_side_path(p: Values, body: Body, kind: str, terms: Terms) -> None:
    """Adds what the wheels' sideways paths make of the weight on them (`side_moment`); by forces the roll is theirs over the stiffness."""
    for wheel in CORNERS:
        axle, side = _axle(wheel), 1.0 if wheel[1] == "l" else -1.0
        eased = side * side_moment(p, body, axle) / p[f"track_{axle}"]
        if kind == "deflection":
            add(terms, f"d_{wheel}", eased * p[f"scale_{wheel}"])
        else:
            rate = p[f"spring_{axle}"] + 2 * p[f"bar_{axle}"] / p[f"track_{axle}"] ** 2
            add(terms, f"{kind}_{wheel}", eased / rate)


def _by_sensor(kind: str) -> Callable[[Values, Sequence[float], Terms], None]:
    def add_all(p: Values, lever: Sequence[float], terms: Terms) -> None:
        for i, wheel in enumerate(CORNERS):
            add(terms, f"{kind}_{wheel}", lever[i] * p[f"{kind}_scale_{_axle(wheel)}"])
            add(terms, "one", lever[i] * p[f"{kind}_zero_{wheel}"])

    return add_all


def _by_axle(p: Values, lever: Sequence[float], terms: Terms) -> None:
    for axle, arm in zip(AXLES, (lever[0], lever[2]), strict=True):
        add(terms, f"axle_{axle}", arm * p[f"axle_scale_{axle}"])
        add(terms, "one", 2 * arm * p[f"axle_zero_{axle[0]}l"])


FORCES: dict[str, Callable[[Values, Sequence[float], Terms], None]] = {
    "deflection": _by_deflection,
    "suspension": _by_sensor("suspension"),
    "tyre": _by_sensor("tyre"),
    "axle": _by_axle,
}


def stiffness_of(kind: str, p: Values, lever: Sequence[float], bars: bool) -> float:
    """What the forces of a balance scale with."""
    if kind != "deflection":
        return 0.5 * (p[f"{kind}_scale_front"] + p[f"{kind}_scale_rear"])
    total = 0.0
    for i, wheel in enumerate(CORNERS):
        axle = _axle(wheel)
        bar = p[f"bar_{axle}"] / p[f"track_{axle}"] ** 2
        total += lever[i] ** 2 * p[f"scale_{wheel}"] * (p[f"spring_{axle}"] + (2 * bar if bars else 0.0))
    return total
