"""What the axle loads told, for the joint posterior: the two moments as they were fitted, before any mass or height.

Beside them, where the log has a speed, the accelerometer's offset; and with both axles the mean of their sum. Scale and zero of
the load sensors are unknowns of the joint, as are masses, lengths, wheels and links; what only this relation has (how far
the body pitches over its wheels, where a tyre's patch sits) comes along as its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.answers import Draws, Errors
from pipelines.estimators.axle_load_gls.balance import Balance
from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.known import Pitch
from pipelines.estimators.load_balance.evidence import PATCH
from pipelines.estimators.load_balance.relations import TITLES
from pipelines.evidence import Evidence, FloatArray, Unknown, Values
from pipelines.joint.from_parameters import direct, evidence_of, hubs_past, loaded_body
from pipelines.joint.vehicle.laden import patch_lag
from pipelines.joint.vehicle.poles import POLES, pole_drop
from pipelines.joint.vehicle.unknowns import BY_SPRINGS
from pipelines.models.axle_load import GRAVITY

SOURCE = "axle_load_gls"
GAIN = "axle_pitch_gain"
PLACE_SHARE = 0.3
SUM_ERROR = 0.001
ARM_STD = 0.15
BODY = (
    "empty_mass", "empty_x", "empty_y", "empty_h", "load", "load_x", "load_y", "load_h", "unsprung_front",
    "unsprung_rear", "wheelbase", "radius", "hub_low", "spring_front", "spring_rear",
)  # fmt: skip
"""PLACE_SHARE: of the wheelbase, times the model's error: what the place may be wrong by. SUM_ERROR: what crests and the
like leave in the mean of both axles. ARM_STD: share by which the body's arm over the axis that it pitches about is off beside its
height and that axis, which are unknowns of the joint: the sprung mass's place in the whole, wheels that go along. BODY: what mass, place and height of the loaded vehicle come from."""


@dataclass(frozen=True)
class Seen:
    """One drive's fit. offset: of the accelerometer as the log shows it, m/s², with its doubt; None where it does not."""

    data: AxleData
    balance: Balance
    pitch: Pitch
    errors: Errors
    offset: tuple[float, float] | None
    wheelbase: float
    by_speed: bool


def carrier_of(data: AxleData) -> str:
    """The signals that carry it: of both axles, or of one alone."""
    front, rear = data.kinds
    if front is not None and front == rear:
        return TITLES[front]
    names = [f"{axle} {TITLES[kind]}" for axle, kind in (("front", front), ("rear", rear)) if kind]
    return " and ".join(names).replace("axle loads", "axle load")


def _errors_of(kind: str, axle: str, values: Values) -> tuple[float | FloatArray, float | FloatArray]:
    """Scale and zero in N of an axle's load."""
    left, right = (values[f"{kind}_zero_{axle[0]}{side}"] for side in "lr")
    return values[f"{kind}_scale_{axle}"], 2 * left if kind == "axle" else left + right


def _axles(seen: Seen) -> list[tuple[str, str, float, float]]:
    """(axle, kind, its share with sign, weight that was added) of each axle that is logged."""
    data = seen.data
    both = (("front", -data.share_front), ("rear", data.share_rear))
    return [
        (axle, kind, share, added)
        for (axle, share), kind, added in zip(both, data.kinds, data.added, strict=True)
        if kind is not None
    ]


def _static(seen: Seen, values: Values) -> list[tuple[float, float | FloatArray]]:
    """(share with sign, mean load as its sensor should show it, N) of each axle."""
    body = loaded_body(values)
    rear = body.mass * (body.whole_x + _rolled(values)) / values["wheelbase"]
    found: list[tuple[float, float | FloatArray]] = []
    for axle, kind, share, added in _axles(seen):
        carried = GRAVITY * (body.mass - rear if axle == "front" else rear)
        if kind == "suspension":
            carried = carried - GRAVITY * values[f"unsprung_{axle}"]
        scale, zero = _errors_of(kind, axle, values)
        found.append((share, (carried - zero) / scale + added))
    return found


def _rolled(values: Values) -> float | FloatArray:
    """How far rolling resistance moves what the scales show, m."""
    return values["rolling_shift"] * values["rolling"] * values["radius"]


def _transfer(seen: Seen, values: Values) -> float | FloatArray:
    """M_h as the sensors should show it: kg m of load times wheelbase a m/s² of the force that was fitted against."""
    body, gain = loaded_body(values), values[GAIN]
    links = 0.5 * (values["pitch_center_brake"] + values["pitch_center_drive"]) - pole_drop(values)
    patch = patch_lag(values) if _on_tyres(seen) else 0.0
    moment = body.mass * ((body.whole_h + patch) * (1 + gain) - links * gain)
    moment = moment + 4 * values["wheel_inertia"] / values["radius"]
    # springs do not see what the links carry
    moment = moment - _on_springs(seen, values) * (body.mass * links + hubs_past(values))
    if not seen.by_speed:
        moment = moment / (1 + gain)
    parts = [abs(share) / _errors_of(kind, axle, values)[0] for axle, kind, share, _ in _axles(seen)]
    told: float | FloatArray = moment * sum(parts) * seen.wheelbase / values["wheelbase"]
    return told


def _central(seen: Seen, values: Values) -> float | FloatArray:
    """M_c as the sensors should show it, without what an offset of the force puts into it; kg m."""
    return seen.wheelbase / GRAVITY * sum(share * load for share, load in _static(seen, values))


def _wrong_force(values: Values) -> float | FloatArray:
    """What a level accelerometer along the vehicle reads at rest, m/s²."""
    return -(values["offset_x"] + GRAVITY * values["askew_pitch"])


def _on_springs(seen: Seen, values: Values) -> float | FloatArray:
    """How much of the load is what springs carry: 0 to 1."""
    return seen.data.share_of("suspension") + seen.data.share_of("axle") * values[BY_SPRINGS]


def _on_tyres(seen: Seen) -> bool:
    """Whether the sensors may see what the tyres carry, not what the springs do."""
    return seen.data.share_of("suspension") == 0.0


def _names(seen: Seen) -> tuple[str, ...]:
    sensors = [
        name
        for axle, kind, _, _ in _axles(seen)
        for name in (
            f"{kind}_scale_{axle}",
            f"{kind}_zero_{axle[0]}l",
            *([] if kind == "axle" else [f"{kind}_zero_{axle[0]}r"]),
        )
    ]
    beside = ("rolling", "rolling_shift", "wheel_inertia", "pitch_center_brake", "pitch_center_drive", *POLES)
    force = () if seen.by_speed else ("offset_x", "askew_pitch")
    patch = (PATCH,) if _on_tyres(seen) else ()
    under = () if seen.data.share_of("tyre") == 1.0 else ("hubs_past", BY_SPRINGS)
    return (*BODY, *beside, *under, *force, *sensors, *patch)


def _covariance(seen: Seen) -> FloatArray:
    """(2, 2) of the moments: the fit's own with what force, road and model may be wrong by."""
    m_h, m_c = (float(v) for v in seen.balance.moments)
    errors, pitch = seen.errors, seen.pitch
    share = (errors.force_scale, errors.model, ARM_STD * pitch.gain)
    weight = sum(share * load for share, load in _loads(seen))
    place = errors.model * PLACE_SHARE * seen.wheelbase * weight / GRAVITY
    grade = m_h * errors.force_offset[1] / GRAVITY if seen.by_speed else 0.0
    own = np.array(
        [m_h**2 * sum(s**2 for s in share) + (m_c * seen.data.vertical_leak) ** 2, place**2 + grade**2]
    )
    return seen.balance.covariance + np.diag(own)


def _loads(seen: Seen) -> list[tuple[float, float]]:
    """Unsigned share and mean load of each axle, N; of one alone twice its load stands for the vehicle's weight."""
    data = seen.data
    both = ((data.share_front, data.front), (data.share_rear, data.rear))
    return [(2 * share, load) for share, load in both if load is not None]


def _moving(seen: Seen) -> Evidence:
    """Both moments, and the accelerometer's offset where the log shows it."""
    observed = [float(v) for v in seen.balance.moments]
    covariance = _covariance(seen)
    if seen.offset is not None:
        observed.append(seen.offset[0])
        # steady grade leans into the place as it leans into the offset, and so does the doubt of it
        covariance = np.block([[covariance, np.zeros((2, 1))], [np.zeros((1, 2)), seen.offset[1] ** 2]])

    def parameters(values: Values) -> list[float | FloatArray]:
        transfer, central = _transfer(seen, values), _central(seen, values)
        if seen.by_speed:
            return [transfer, central]
        wrong = _wrong_force(values)
        found = [transfer, central - transfer * wrong / GRAVITY]
        return found if seen.offset is None else [*found, wrong]

    return evidence_of(
        "pitch", carrier_of(seen.data), "load transfer and mean load of the axles", SOURCE, direct(observed, covariance),
        parameters, _names(seen), (Unknown(GAIN, seen.pitch.gain, seen.pitch.std),),
    )  # fmt: skip


def _standing(seen: Seen) -> Evidence:
    """The mean load alone, where the force along the road hardly changes."""
    data = seen.data
    force = float(np.mean(data.force()))
    blocks = max(2, int(data.size / (5 * data.rate_hz)))
    scatter = float(np.std([np.mean(p) for p in np.array_split(data.load, blocks)]))
    wrong = 0.0 if seen.by_speed else seen.errors.force_offset[1]
    usual = 0.22 * sum(share * load for share, load in _loads(seen)) / GRAVITY
    covariance = np.array(
        [[(scatter / GRAVITY) ** 2 + (usual * wrong / GRAVITY) ** 2 + _covariance(seen)[1, 1]]]
    )
    covariance[0, 0] -= seen.balance.covariance[1, 1]

    def parameters(values: Values) -> list[float | FloatArray]:
        return [_central(seen, values) + _transfer(seen, values) * force / GRAVITY]

    mean = seen.wheelbase * float(np.mean(data.load)) / GRAVITY
    return evidence_of(
        "pitch", carrier_of(data), "mean load of the axles", SOURCE, direct([mean], covariance), parameters,
        _names(seen), (Unknown(GAIN, seen.pitch.gain, seen.pitch.std),),
    )  # fmt: skip


def _carried(seen: Seen) -> Evidence:
    """The mean of the sum of both axles."""
    data = seen.data
    total = (data.front or 0.0) + (data.rear or 0.0)
    share = float(np.mean(np.cos(data.grade_source.angle[data.rows])))

    def parameters(values: Values) -> list[float | FloatArray]:
        return [share * sum(load for _, load in _static(seen, values))]

    return evidence_of(
        "vertical", carrier_of(data), "sum of the axle loads", SOURCE, direct([total], np.array([[(SUM_ERROR * total) ** 2]])),
        parameters, _names(seen),
    )  # fmt: skip


def evidence(seen: Seen, draws: Draws, told: bool, still: bool) -> tuple[Evidence, ...]:
    """The relations of one drive. told: load transfer was seen; still: the force along the road hardly changed.

    None where the loads contradict the balance: they follow no force, or give a height or place that no vehicle has.
    """
    place = float(np.median(draws.axle)) / seen.wheelbase if draws.mass is not None else 0.5
    height = float(np.median(draws.height)) if draws.mass is not None else 0.3 * seen.wheelbase
    if not 0.05 < place < 0.95 or not (told or still):
        return ()
    if told and not 0.1 < height < 0.8 * seen.wheelbase:
        return ()
    found = [_moving(seen) if told else _standing(seen)]
    if draws.mass_measured:
        found.append(_carried(seen))
    return tuple(found)
