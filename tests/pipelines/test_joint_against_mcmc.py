"""The verdict's mean, spread and interval against long runs of a plain sampler, where relations are sharp, curved, mirrored.

The chains move the unknowns that the answers or the relations depend on; the others stay N(0, 1) whatever is measured. Along
a ridge that opens out (moments known, no mass) such chains do not agree in any time; there the weighted prior is the reference.
Whole drives' relations: `test_joint_drive_against_mcmc.py`, and longer ones in `benchmarks/joint_mcmc.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.inference import infer
from pipelines.joint.information import slopes
from pipelines.joint.posterior import Joint, find_mode, log_density, values_at
from pipelines.joint.sampling.sample import sample
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import of_output, vehicle
from tests.pipelines.long_mcmc import Figures, figures_of, run_chains

SHOWN = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "roll_stiffness_nmprad")
LAPLACE = 0.15
"""Error of a mean, in standard deviations, that is allowed besides chance: a normal approximation is kept where a profile
departs by less than half a nat from it."""


def _moment(o: dict[str, FloatArray]) -> FloatArray:
    return o["mass_kg"] * o["cg_height_m"]


def _place(o: dict[str, FloatArray]) -> FloatArray:
    return o["mass_kg"] * o["cg_to_front_axle_m"]


def _roll(o: dict[str, FloatArray]) -> FloatArray:
    """m h / (I + m h²) of the roll equation: the same for an arm h and for I / (m h)."""
    body = o["mass_kg"] * o["roll_arm_m"]
    return body / (o["roll_inertia_kgm2"] + body * o["roll_arm_m"])


def _sharp() -> list[Evidence]:
    return [
        of_output(lambda o: o["mass_kg"], 2150.0, 12.0, carrier="springs"),
        of_output(_moment, 2150 * 0.66, 18.0, carrier="deflections"),
        of_output(_place, 2150 * 1.36, 20.0, carrier="rest"),
    ]


def _curved() -> list[Evidence]:
    return [
        of_output(_moment, 2150 * 0.68, 10.0, carrier="deflections"),
        of_output(_place, 2150 * 1.36, 15.0, carrier="rest"),
    ]


def _mirrored() -> list[Evidence]:
    return [of_output(_roll, 0.86, 0.01, kind="roll", carrier="horizon")]


def _long_run(joint: Joint) -> dict[str, Figures]:
    _, gradients = slopes(joint)
    k = len(joint.u)
    moves = np.abs(joint.covariance - np.eye(k)).max(axis=1) > 1e-9
    for name in SHOWN:
        moves |= gradients[name] != 0
    active = np.flatnonzero(moves)
    density = log_density(joint)

    def whole(v: FloatArray) -> FloatArray:
        u = np.tile(joint.u, (len(v), 1))
        u[:, active] = v
        return u

    rng = np.random.default_rng(5)
    shape = joint.covariance[np.ix_(active, active)]
    starts = rng.multivariate_normal(joint.u[active], shape, 2000)
    starts = starts[density(whole(starts)) > -joint.cost - 3 * len(active)][:64]
    ran = run_chains(lambda v: density(whole(v)), starts, shape, rng, 4000, thin=5)
    values = values_at(joint.known, whole(ran.flat()))
    out = outputs_of(values, joint.given)
    return {name: figures_of(out[name].reshape(ran.draws.shape[:2])) for name in SHOWN}


def _weighted_prior(joint: Joint, rows: int) -> dict[str, tuple[Figures, tuple[float, float]]]:
    """From draws of the prior, weighted: exact for few relations, where chains creep along a ridge that opens out.

    Within bounds that hold all but one draw in 400 at either end, given beside: one load in a thousand rests on its bump stops, and
    would hold most of the roll stiffness' variance.
    """
    density, rng = log_density(joint), np.random.default_rng(6)
    weights: list[FloatArray] = []
    values: list[FloatArray] = []
    for _ in range(rows // 5000):
        u = rng.standard_normal((5000, len(joint.u)))
        weight = np.exp(density(u) + 0.5 * np.sum(u**2, axis=1))
        u, weight = u[weight > 0], weight[weight > 0]
        out = outputs_of(values_at(joint.known, u), joint.given)
        weights.append(weight)
        values.append(np.array([np.broadcast_to(out[name], len(u)) for name in SHOWN]))
    weight, columns = np.concatenate(weights), np.concatenate(values, axis=1)
    count = np.sum(weight) ** 2 / np.sum(weight**2)
    assert count > 500
    even = columns[:, rng.choice(len(weight), (4000, 16), p=weight / weight.sum())]
    found = {}
    for name, draws in zip(SHOWN, even, strict=True):
        ends = (float(np.quantile(draws, 0.0025)), float(np.quantile(draws, 0.9975)))
        f = figures_of(np.clip(draws, *ends))
        error = f.std / np.sqrt(count)
        known = replace(f, error_mean=error, error_std=error, error_low=2.7 * error, error_high=2.7 * error)
        found[name] = known, ends
    return found


def _near(
    long: Figures, value: float, std: float, low: float, high: float, *, narrow: float, number: float
) -> None:
    """Agrees within four Monte-Carlo errors of both, a Laplace error for the mean, and a share of the spread."""
    own = long.std / np.sqrt(number)
    assert value == pytest.approx(long.mean, abs=LAPLACE * long.std + 4 * np.hypot(long.error_mean, own))
    assert std == pytest.approx(long.std, abs=narrow * long.std + 4 * np.hypot(long.error_std, 0.7 * own))
    # an end of the interval is, by the density there, about 2.7 times as uncertain as the mean
    for end, truth, error in ((low, long.low, long.error_low), (high, long.high, long.error_high)):
        assert end == pytest.approx(truth, abs=2 * LAPLACE * long.std + 4 * np.hypot(error, 2.7 * own))


def test_where_relations_are_sharp_the_verdict_is_what_long_chains_say() -> None:
    car = vehicle()
    found = infer(_sharp(), car, np.random.default_rng(4))
    assert found is not None
    joint = find_mode((*_sharp(), *stated_relations(car)), before_the_log(car))
    for name, long in _long_run(joint).items():
        entry = found.parameters[name]
        if entry.status == "not_identifiable":
            # gives back what was known before
            continue
        assert long.r_hat < 1.05
        assert entry.value is not None
        assert entry.std is not None
        assert entry.low is not None
        assert entry.high is not None
        wide = found.record.inflation
        ends = (entry.value + (end - entry.value) / wide for end in (entry.low, entry.high))
        _near(long, entry.value, entry.std / wide, *ends, narrow=0.05, number=800)
    assert found.parameters["mass_kg"].status == "identified"


@pytest.mark.parametrize("relations", [_curved, _mirrored])
def test_sampled_posteriors_are_the_weighted_prior(relations: Callable[[], list[Evidence]]) -> None:
    car = vehicle()
    joint = find_mode((*relations(), *stated_relations(car)), before_the_log(car))
    drawn = sample(log_density(joint), [(joint.u, joint.covariance)], np.random.default_rng(7))
    out = outputs_of(values_at(joint.known, drawn.draws), joint.given)
    assert drawn.effective > 300
    for name, (long, ends) in _weighted_prior(joint, 400_000).items():
        x = np.clip(out[name], *ends)
        low, high = np.quantile(x, (0.025, 0.975))
        _near(long, float(x.mean()), float(x.std()), low, high, narrow=0.1, number=0.5 * drawn.effective)


def test_chains_agree_with_a_known_gaussian() -> None:
    covariance = np.diag([0.01, 1.0, 4.0, 0.25])
    starts = np.random.default_rng(1).multivariate_normal(np.ones(4), 4 * covariance, 64)

    def density(u: FloatArray) -> FloatArray:
        return -0.5 * np.sum((u - 1) ** 2 / np.diag(covariance), axis=1)

    ran = run_chains(density, starts, np.eye(4), np.random.default_rng(2), 3000, thin=3)
    for column in range(4):
        got = figures_of(ran.draws[:, :, column])
        std = np.sqrt(covariance[column, column])
        assert got.r_hat < 1.03
        assert got.error_mean < 0.05 * std
        assert got.mean == pytest.approx(1, abs=5 * got.error_mean)
        assert got.std == pytest.approx(std, abs=5 * got.error_std)
        assert got.high - got.low == pytest.approx(3.92 * std, rel=0.05)
    assert 0.15 < ran.accepted < 0.4
