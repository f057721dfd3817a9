"""From the two stages to parameters with intervals, a status and its reason in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.roll_map.fit import RollFit
from pipelines.estimators.roll_map.model import WEAK_PRIOR
from pipelines.estimators.roll_map.open_slope import BY_NOISE, FRICTION, why_open
from pipelines.estimators.roll_map.posterior import (
    RollLikelihood,
    moments,
    pure_likelihood,
    quantiles,
    with_discrepancy,
)
from pipelines.models.roll import damping_ratio, roll_gradient_degpg, undamped_frequency_hz
from pipelines.parameters import PARAMETERS
from pipelines.results import INNER, OUTER, FloatArray, Identification, ParameterEstimate, Prior

IDENTIFIED, WEAK = 0.5, 0.9
"""Posterior spread over prior spread up to which a parameter counts as identified, and as weak."""

LOOSE = 0.12
"""Standard deviation over value beyond which nothing is called identified, however little was known before."""

IDENTIFIED_ALONE, WEAK_ALONE = 0.08, 0.2
"""The same for parameters without a prior: standard deviation over value."""

DISCREPANCY = {"b": 0.10, "c": 0.16, "rate_gain": 0.03}
DISCREPANCY_AXLES = {"b": 0.12, "c": 0.16, "rate_gain": 0.03}
"""Relative error of the linear two-state model itself: tyres in series under damped springs, dampers with a knee (b is
that of their working point), sensors' filters. For an angle against the horizon, and for one against the axles, whose
tyres' motion is not seen."""

LEFT_OVER, LEFT_OVER_AXLES = 0.01, 0.015
"""Share of the springs' moment that no linear model holds: dry friction (2-8 % of the moment at 0.3 g) less what the
fitted friction takes of it, curved bars, a load to one side. In phase with the angle it looks like stiffness (1 % of
a), a quarter turn away like damping (0.01 a / ω), half a turn away like inertia (0.01 a / ω²): slow motion tells
stiffness alone, however long it lasts. Half as much again against the axles, where all of the angle is the springs'."""

SOURCE = ("roll_map",)


@dataclass(frozen=True)
class Coefficients:
    """First stage, as the second and the report use it: names, mean (k,), covariance (k, k) with discrepancy.

    open_by: what leaves the steady slope open, in words.
    """

    names: tuple[str, ...]
    mean: FloatArray
    covariance: FloatArray
    prior_mean: FloatArray
    prior_std: FloatArray
    open_by: str = BY_NOISE


def coefficients_of(
    fit: RollFit,
    scale_std: float,
    against_axles: bool,
    mean: FloatArray | None = None,
    covariance: FloatArray | None = None,
) -> Coefficients:
    """a, b, c (and the rate gain) of a fit, with the model's own error and that of the angle's scale added.

    mean, covariance: of all parameters, where not the fit's own (running estimate).
    """
    names, x, pick = fit.names, fit.handed, fit.jacobian
    spread = pick @ (fit.covariance if covariance is None else covariance) @ pick.T
    if mean is not None:
        x = x + pick @ (mean - np.array([fit.values[k.name] for k in fit.known]))
    if fit.mixed is not None:
        # a running estimate is the heaviest model's, moved by as much as the mixture lies off it at the end
        x = x + (fit.mixed.mean - fit.handed)
        spread = fit.mixed.covariance if covariance is None else spread + fit.mixed.between
    table = DISCREPANCY_AXLES if against_axles else DISCREPANCY
    own = np.array([table.get(name, 0.0) for name in names]) * x
    share = LEFT_OVER_AXLES if against_axles else LEFT_OVER
    left = share * x[0] / max(fit.quickness, 0.1) ** np.arange(3)
    # in phase with the angle, friction is in either: the larger of both, and what roads add to it
    doubts = dict(fit.doubts)
    left[0] = math.hypot(max(share, doubts.pop(FRICTION, 0.0)), *doubts.values()) * x[0]
    own[:3] = np.hypot(own[:3], left)
    scaled = np.where(np.array(names) == "rate_gain", -x, x) * scale_std
    prior_mean, prior_std = np.array([WEAK_PRIOR[name] for name in names]).T
    levels = {name: math.exp(fit.values.get(f"log_{name}", -math.inf)) for name in ("bank", "roll_noise")}
    open_by = why_open(
        math.sqrt(spread[0, 0]) / x[0],
        fit.doubts,
        levels["bank"],
        levels["roll_noise"],
        angle="log_roll_noise" in fit.values,
    )
    gain = np.array(names) == "rate_gain"
    if gain.any():
        # its weak prior is about as wide as what it is unsure by; those of the others are far wider
        error = np.where(gain, np.hypot(own, scaled), 0.0)[:, None]
        x, spread = with_discrepancy(x, spread, prior_mean, prior_std, error)
    own, scaled = np.where(gain, 0.0, own), np.where(gain, 0.0, scaled)
    total = spread + np.diag(own**2) + np.outer(scaled, scaled)
    return Coefficients(names, x, total, prior_mean, prior_std, open_by)


def likelihood_of(coefficients: Coefficients, *, against_axles: bool) -> RollLikelihood:
    """The coefficients' likelihood without the weak priors of the fit."""
    c = coefficients
    information, linear = pure_likelihood(c.mean, c.covariance, c.prior_mean, c.prior_std)
    return RollLikelihood(
        information, linear, 1 / c.prior_std[:2] ** 2, c.prior_mean[:2], against_axles, c.mean
    )


def without_inertia(coefficients: Coefficients) -> Coefficients:
    """The same with b and c as unknown as before: for a c that no vehicle can have."""
    wide = coefficients.covariance.copy()
    for i in (1, 2):
        wide[i, i] += (100 * coefficients.prior_std[i]) ** 2
    return replace(coefficients, covariance=wide)


def status_against(std: float, value: float, prior: Prior | None) -> Identification:
    """What the log taught: posterior against prior spread, or spread against value where nothing was known."""
    if prior is not None and prior.std > 0:
        ratio, good, fair = std / prior.std, IDENTIFIED, WEAK
        good = good if std <= LOOSE * abs(value) else 0.0
    else:
        ratio, good, fair = std / max(abs(value), 1e-12), IDENTIFIED_ALONE, WEAK_ALONE
    return "identified" if ratio <= good else "weak" if ratio <= fair else "not_identifiable"


def unknown(name: str, reason: str, prior: Prior | None, reference: float | None) -> ParameterEstimate:
    """A parameter of which the log says nothing: the prior where there is one, else no figures."""
    if prior is None:
        return ParameterEstimate(
            name, None, None, None, None, "not_identifiable", reason, None, reference, ()
        )
    low, high = prior.value - 1.96 * prior.std, prior.value + 1.96 * prior.std
    if PARAMETERS[name].positive:
        low = max(low, 0.0)
    return ParameterEstimate(
        name, prior.value, prior.std, low, high, "not_identifiable", f"{reason}; the figures are the prior's", prior, reference, ("prior",)
    )  # fmt: skip


def from_draws(
    name: str,
    values: FloatArray,
    weight: FloatArray,
    prior: Prior | None,
    reasons: Mapping[Identification, str],
    reference: float | None,
    ceiling: Identification = "identified",
) -> ParameterEstimate:
    """Mean, spread, intervals and status of weighted draws; no figures where neither prior nor log know anything.

    ceiling: the best status that is allowed.
    """
    value, std = moments(values, weight)
    levels = np.array([*INNER, OUTER])
    ends = quantiles(values, weight, np.concatenate([0.5 - levels / 2, 0.5 + levels / 2]))
    *inner, (low, high) = zip(*(half.tolist() for half in np.split(ends, 2)), strict=True)
    status = status_against(std, value, prior)
    order: list[Identification] = ["identified", "weak", "not_identifiable"]
    status = order[max(order.index(status), order.index(ceiling))]
    if status == "not_identifiable" and prior is None:
        return unknown(name, reasons[status], None, reference)
    return ParameterEstimate(
        name, value, std, low, high, status, reasons[status], prior, reference, SOURCE, tuple(inner)
    )  # fmt: skip


def draw_coefficients(coefficients: Coefficients, rng: np.random.Generator, count: int) -> FloatArray:
    """(3, m) draws of a, b, c that are possible (all positive)."""
    root = np.linalg.cholesky(coefficients.covariance[:3, :3])
    drawn = coefficients.mean[:3, None] + root @ rng.standard_normal((3, count))
    return np.asarray(drawn[:, (drawn > 0).all(axis=0)])


def _alone(value: str, weak: str, missing: str) -> dict[Identification, str]:
    return {
        "identified": value,
        "weak": f"{value}; {weak}",
        "not_identifiable": f"not told by this drive: {missing}",
    }


STAY_RIGID = 0.03
"""Chance of tyres that do not give, after the drive, from which on their part of the roll is what usual tyres have and not what was
measured. A gyro beside the springs leaves rigid ones 0.00 to 0.02 where tyres give; where roads lean into their bends, or no gyro is
there, the chance beforehand is left: simulators with rigid tyres on such roads had gradients 17 to 20 % high, identified."""

SHARE_TOLD = 0.03
"""Spread of the suspension's share of the roll below which the drive has told it, rigid tyres or not."""


def tyres_untold(share: FloatArray) -> str:
    """In words, that nothing shows what tyres add to a roll against the axles; else empty, and where the roll is against the horizon.

    share: draws (n,) of the suspension's share of the roll, 1 for tyres that do not give.
    """
    gives = share < 1
    if not gives.any() or float(np.mean(gives)) > 1 - STAY_RIGID or float(np.std(share)) < SHARE_TOLD:
        return ""
    part = 1 - float(np.mean(share[gives]))
    return (
        f"the tyres' part of it ({part:.0%}) is what usual tyres add: neither the drive nor the vehicle file tells it, and tyres that "
        "hardly give would add next to nothing"
    )


def log_answers(
    coefficients: Coefficients,
    sensor: tuple[FloatArray, FloatArray, FloatArray],
    imu_known: bool,
    what: str,
    reference: Mapping[str, float],
    rng: np.random.Generator,
    *,
    tyres_stated: bool,
) -> dict[str, ParameterEstimate]:
    """Roll gradient, natural frequency and damping ratio: what the log gives without a vehicle file.

    sensor: draws (n,) of the accelerometer's height above the roll axis, and of factor and summand that turn the
    apparent c into the body's own. The factor is also what share of the roll against the horizon the roll against the
    axles is (1 where the angle is against the horizon): the gradient is told with the tyres' part. what: of which angle.
    """
    drawn = draw_coefficients(coefficients, rng, len(sensor[0]))
    count = drawn.shape[1]
    if count < 100:
        return {}
    a, _, c = drawn
    # what the tyres add to a roll against the axles is not in the log
    rate = (
        "the tyres' rate" if tyres_stated else "tyres of the usual rate (tire_vertical_rate_npm says theirs)"
    )
    source = "the log alone" if bool(np.all(sensor[1] == 1)) else f"the log and {rate}"
    untold = "" if tyres_stated else tyres_untold(sensor[1])
    gradient = from_draws(
        "roll_gradient_degpg",
        np.asarray(roll_gradient_degpg(a)) / sensor[1][:count],
        np.full(count, 1 / count),
        None,
        _alone(
            f"from {source}: roll {what} per g of sensed lateral acceleration (gravity's part included)",
            coefficients.open_by,
            coefficients.open_by,
        ),
        reference.get("roll_gradient_degpg"),
    )
    if untold and gradient.status != "not_identifiable":
        gradient = replace(gradient, status="weak", reason=f"{gradient.reason}; {untold}")
    z, factor, summand = (column[:count] for column in sensor)
    length = c * factor + summand + z
    possible = length > 0.05
    if possible.sum() < 100:
        return {gradient.name: gradient}
    return {gradient.name: gradient} | _dynamics(
        coefficients, drawn[:, possible], length[possible], factor[possible], imu_known, what, reference
    )


def spreads_in_words(coefficients: Coefficients) -> str:
    """How sure the motion is of inertia and damping, where it is not sure enough."""
    damping, inertia = np.sqrt(np.diag(coefficients.covariance)[1:3]) / np.maximum(
        coefficients.mean[1:3], 1e-9
    )
    told = {
        name: f"{spread:.0%}" for name, spread in (("inertia", inertia), ("damping", damping)) if spread <= 1
    }
    if not told:
        return "tells neither inertia nor damping"
    return "leaves " + " and ".join(
        f"{name} to ± {told[name]}" if name in told else f"{name} open" for name in ("inertia", "damping")
    )


def quick_enough(coefficients: Coefficients) -> tuple[bool, bool]:
    """Whether the motion told damping (b) and inertia (c): well below what is known of any road vehicle's.

    A relative limit alone will not do: it lets too large a damping pass, and a slow drive's is the model's error.
    """
    stds = np.sqrt(np.diag(coefficients.covariance))
    told_b = bool(stds[1] < 0.4 * coefficients.prior_std[1])
    return told_b, bool(stds[2] < 0.6 * coefficients.prior_std[2])


def _dynamics(
    coefficients: Coefficients,
    drawn: FloatArray,
    length: FloatArray,
    share: FloatArray,
    imu_known: bool,
    what: str,
    reference: Mapping[str, float],
) -> dict[str, ParameterEstimate]:
    """Natural frequency and damping ratio. length: (m,) draws of J / (m h), J about the roll axis.

    share: (m,) the suspension's share of the roll, by which tyres in series soften the mode, and by whose square they
    take from what the dampers see of it; 1 where the angle held the tyres' part.
    """
    a, b, _ = drawn
    flat = np.full(len(a), 1 / len(a))
    told_b, told_c = quick_enough(coefficients)
    weak = "the model's own error limits it (tyres, dampers with two slopes)"
    if not imu_known:
        weak = "the accelerometer's height is not known: give sensors.imu_above_ground_m"
    slow = f"the quick motion that there is {spreads_in_words(coefficients)}: more of quick steering (sine with dwell, 0.5-1 Hz and above) would"
    found: dict[str, ParameterEstimate] = {}
    for name, values, told, formula in (
        (
            "roll_natural_frequency_hz",
            undamped_frequency_hz(a, length, 0.0) * np.sqrt(share),
            told_c,
            "sqrt(K/J)/2π",
        ),
        (
            "roll_damping_ratio",
            damping_ratio(a, b, length, 0.0) * share**1.5,
            told_c and told_b,
            "D/(2 sqrt(K J))",
        ),
    ):
        text = f"from the log: {formula}, J about the roll axis, of roll {what}"
        words = _alone(text, weak, weak if told else slow)
        # the mode came out up to 12 % quick on simulated cars with friction and knees: told, and never surely
        ceiling: Identification = "weak" if told else "not_identifiable"
        found[name] = from_draws(name, values, flat, None, words, reference.get(name), ceiling)
    return found
