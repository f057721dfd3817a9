"""The batch's parts joined with what is known of the vehicle: parameters with intervals, status and reasons."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.brake_roll.lateral import LateralFit
from pipelines.estimators.brake_roll.mass import MassFit
from pipelines.estimators.brake_roll.slip import SlipFit
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.estimators.roll_map.answers import (
    Coefficients,
    from_draws,
    likelihood_of,
    status_against,
    unknown,
)
from pipelines.estimators.roll_map.posterior import Posterior, sample_posterior
from pipelines.estimators.roll_map.vehicle import VehiclePart
from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.prepare.bends import LEANING_STD
from pipelines.results import FloatArray, Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

SOURCE = ("brake_roll_batch",)

GAIN_ERROR = 0.03
FRICTION = 0.1
"""Of the roll per lateral acceleration: curved bars and bump stops that no straight line holds; and what dry friction
in the suspension may hold back, in m/s² of lateral acceleration: a large share of a gentle drive's, a small one of a
slalom's."""

LOADED_SPRINGS = 0.03
"""Of the roll stiffness: the vehicle file's is the empty vehicle's, and springs stiffen under load."""

HEIGHT_ERROR = 0.01
"""Of the height: what the model leaves out once every part agrees."""

FEWEST_EFFECTIVE = 60.0
"""Draws with weight below which the parts and what is known exclude each other: the parts are then widened."""


@dataclass(frozen=True)
class Found:
    """What the parts gave; None with the reason in words where one gave nothing. bends: see `bends_share`."""

    slip: SlipFit | None
    lateral: LateralFit | None
    mass: MassFit | None
    why_slip: str
    why_lateral: str
    why_mass: str
    bends: float = 1.0


def gain_spread(lateral: LateralFit) -> float:
    """Relative standard deviation of the roll per lateral acceleration, with what the straight line leaves out."""
    own = math.hypot(GAIN_ERROR, FRICTION / max(lateral.liveliness, 0.1))
    return math.hypot(lateral.std / lateral.gain, own)


def _roll_posterior(
    lateral: LateralFit, before: VehiclePart, widen: float, rng: np.random.Generator
) -> Posterior:
    """Draws weighted by the roll per lateral acceleration and the stiffness' prior; lag and inertia are left out."""
    assert before.draws is not None
    a = 1 / lateral.gain
    relative = widen * gain_spread(lateral)
    far = np.array([1e3, 1e3, 1e2])
    mean = np.array([a, 8.0, 1.0])
    covariance = np.diag([(relative * a) ** 2, (100 * far[1]) ** 2, (100 * far[2]) ** 2])
    coefficients = Coefficients(("a", "b", "c"), mean, covariance, np.array([a, 8.0, 1.0]), far)
    likelihood = likelihood_of(coefficients, against_axles=False)
    # b is not told: it only has to stay a number
    information = likelihood.information.copy()
    linear = likelihood.linear.copy()
    information[1, 1] += 1 / 2.0**2
    linear[1] += 8.0 / 2.0**2
    likelihood = replace(likelihood, information=information, linear=linear)
    stiffness = before.rates[0]
    if stiffness is not None:
        wide = math.hypot(stiffness.std, LOADED_SPRINGS * stiffness.value)
        stiffness = replace(stiffness, std=wide)
    return sample_posterior(before.draws, likelihood, stiffness, None, rng)


def _flat(before: VehiclePart) -> Posterior:
    """The draws as they were."""
    draws = before.draws
    assert draws is not None
    weight = draws.possible / max(float(draws.possible.sum()), 1.0)
    values = {"cg_height_m": draws.height, "mass_kg": draws.mass}
    return Posterior(values, np.asarray(weight, dtype=np.float64), float(draws.possible.sum()))


def _normal(values: FloatArray, mean: float, std: float) -> FloatArray:
    return np.asarray(-0.5 * ((values - mean) / std) ** 2)


def _joined(found: Found, before: VehiclePart, widen: float, rng: np.random.Generator) -> Posterior:
    """The draws weighted by all parts, each widened by a factor."""
    rolled = found.lateral is not None
    base = _roll_posterior(found.lateral, before, widen, rng) if found.lateral is not None else _flat(before)
    if not rolled or base.effective <= 0:
        base = _flat(before)
    with np.errstate(divide="ignore"):
        log = np.log(base.weight)
    if found.slip is not None:
        log = log + _normal(base.values["cg_height_m"], found.slip.height, widen * found.slip.std)
    if found.mass is not None:
        log = log + _normal(base.values["mass_kg"], found.mass.mass, widen * found.mass.std)
    weight = np.exp(log - float(np.max(log)))
    weight /= weight.sum()
    return Posterior(base.values, weight, float(1 / np.sum(weight**2)))


def answer(
    found: Found,
    before: VehiclePart,
    known: BrakeRollVehicle,
    vehicle: Vehicle,
    rng: np.random.Generator,
) -> tuple[dict[str, ParameterEstimate], str]:
    """Parameters, and a sentence on which parts they are from."""
    widen = 1.0
    posterior = _joined(found, before, widen, rng)
    while posterior.effective < FEWEST_EFFECTIVE and widen < 8:
        widen *= 2
        posterior = _joined(found, before, widen, rng)
    said = _said(found, known, widen)
    parameters = {"roll_gradient_degpg": _gradient(found, vehicle)}
    parameters["cg_height_m"] = _height(found, before, posterior, vehicle, said, rng)
    parameters["mass_kg"] = _mass(found, before, posterior, vehicle)
    parameters["roll_stiffness_nmprad"] = _stiffness(found, before, posterior, vehicle)
    return parameters, said


def _said(found: Found, known: BrakeRollVehicle, widen: float) -> str:
    """Which parts spoke, and what they gave."""
    parts: list[str] = []
    if found.slip is not None:
        s = found.slip
        parts.append(
            f"{s.stops} stop{'s' if s.stops > 1 else ''} of up to {s.strongest / GRAVITY:.2f} g gave {s.height:.2f} ± {s.std:.2f} m"
        )
    if found.lateral is not None:
        lean = found.lateral.gain * GRAVITY * DEGREES
        word = "" if known.stiffness is not None else " (no roll stiffness is known: no height from it)"
        parts.append(f"cornering gave {lean:.2f} deg of roll per g{word}")
    if found.mass is not None:
        parts.append(f"the longitudinal balance gave {found.mass.mass:.0f} ± {found.mass.std:.0f} kg")
    missing = [why for why in (found.why_slip, found.why_lateral, found.why_mass) if why]
    text = "; ".join((*parts, *missing))
    if widen > 1:
        text += f"; these and the vehicle file exclude each other: all were widened {widen:.0f} times"
    return text


GRADIENT_DOUBT = 0.04
MASS_DOUBT = 0.022
"""Relative model errors of the roll gradient and of the mass that the fits' residuals do not show."""

ORDER: tuple[Identification, ...] = ("identified", "weak", "not_identifiable")


def _gradient(found: Found, vehicle: Vehicle) -> ParameterEstimate:
    name = "roll_gradient_degpg"
    reference = vehicle.reference.get(name)
    if found.lateral is None:
        return unknown(name, found.why_lateral, None, reference)
    scale = GRAVITY * DEGREES
    value = found.lateral.gain * scale
    # friction and banked bends, of which the fit's residual knows little
    std = value * math.hypot(gain_spread(found.lateral), GRADIENT_DOUBT, LEANING_STD * found.bends)
    status: Identification = "identified" if std < 0.08 * value else "not_identifiable"
    reason = "from the log alone: roll against the road per g of sensed lateral acceleration"
    if status != "identified":
        own, lean = gain_spread(found.lateral), LEANING_STD * found.bends
        if own > 0.5 * lean:
            reason += "; little cornering in relation to noise, offsets and scale errors"
        if lean > 0.5 * own:
            reason += "; roads lean into their bends, and this drive's cornering may be theirs"
    if status == "not_identifiable":
        return unknown(name, reason, None, reference)
    low, high = max(value - 1.96 * std, 0.0), value + 1.96 * std
    return ParameterEstimate(name, value, std, low, high, status, reason, None, reference, SOURCE)


def _height(
    found: Found,
    before: VehiclePart,
    posterior: Posterior,
    vehicle: Vehicle,
    said: str,
    rng: np.random.Generator,
) -> ParameterEstimate:
    """CG height of the whole vehicle."""
    values = posterior.values["cg_height_m"]
    values = values * (1 + HEIGHT_ERROR * rng.standard_normal(len(values)))
    prior = before.priors.get("cg_height_m")
    rolled = found.lateral is not None and before.rates[0] is not None
    nothing = not rolled and found.slip is None
    reasons: dict[Identification, str] = {
        "identified": said,
        "weak": f"{said}; {_limit(found)}",
        "not_identifiable": f"{said}; {_limit(found)}",
    }
    ceiling: Identification = "not_identifiable" if nothing else "identified"
    made = from_draws(
        "cg_height_m",
        values,
        posterior.weight,
        prior,
        reasons,
        vehicle.reference.get("cg_height_m"),
        ceiling,
    )
    return replace(made, sources=SOURCE)


def _limit(found: Found) -> str:
    """What would tell more."""
    if found.slip is None and found.lateral is None:
        return "it needs straight stops with brake pressure and true speed, or cornering with a known roll stiffness"
    if found.slip is None:
        return "from cornering alone it hangs on roll stiffness, roll axis and load"
    return "from slips it hangs on brake distribution, CG place and on how alike front and rear tyres are"


def _mass(found: Found, before: VehiclePart, posterior: Posterior, vehicle: Vehicle) -> ParameterEstimate:
    """Mass: from the balance; roll and slips alone do not hold it."""
    prior = before.priors.get("mass_kg")
    reference = vehicle.reference.get("mass_kg")
    if found.mass is None:
        return unknown("mass_kg", f"{found.why_mass}; slips and roll do not hold the mass", prior, reference)
    parts = [*(["brakes"] if found.mass.braked else []), *(["engine"] if found.mass.driven else [])]
    text = f"longitudinal balance of {' and '.join(parts) or 'the air'} against accel_x"
    limit = (
        "it is known no better than the scale of the torques (brake_gain_nmppa with its std, drive torque)"
    )
    reasons: dict[Identification, str] = {
        "identified": text,
        "weak": f"{text}; {limit}",
        "not_identifiable": f"{text}; {limit}",
    }
    made = from_draws("mass_kg", posterior.values["mass_kg"], posterior.weight, prior, reasons, reference)
    if made.value is None or made.std is None or made.status == "not_identifiable":
        return replace(made, sources=SOURCE)
    # a torque's scale moves with temperature and load within a drive, and bends cost torque that no signal tells
    std = math.hypot(made.std, MASS_DOUBT * made.value)
    status = max(made.status, status_against(std, made.value, prior), key=ORDER.index)
    return replace(
        made, std=std, low=made.value - 1.96 * std, high=made.value + 1.96 * std, inner=(), status=status,
        sources=SOURCE, reason=reasons[status],
    )  # fmt: skip


def _stiffness(
    found: Found, before: VehiclePart, posterior: Posterior, vehicle: Vehicle
) -> ParameterEstimate:
    """Roll stiffness of the suspension: from cornering, with the height and mass that are known."""
    name = "roll_stiffness_nmprad"
    prior, reference = before.rates[0], vehicle.reference.get(name)
    if found.lateral is None or name not in posterior.values:
        return unknown(name, found.why_lateral or "no roll motion", prior, reference)
    text = "from cornering, with what is known of height and mass"
    reasons: dict[Identification, str] = {
        "identified": text,
        "weak": f"{text}: these limit it",
        "not_identifiable": f"{text}: these limit it",
    }
    made = from_draws(name, posterior.values[name], posterior.weight, prior, reasons, reference)
    return replace(made, sources=SOURCE if made.status != "not_identifiable" else made.sources)
