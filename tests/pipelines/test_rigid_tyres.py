"""Tyres that give and tyres that do not: which of the two a drive's relations fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.special import expit

from pipelines.evidence import Evidence, Values
from pipelines.joint.inference import infer
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.reached import SURE
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.joint.ways.rigid_tyres import STIFFER, TEXT, TYRES, log_odds, rigid, rigid_odds
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())
RATE = float(KNOWN.mean[KNOWN.index(TYRES)])


def rigid_chance(soft: Joint, evidence: Sequence[Evidence], known: Known) -> tuple[float, Joint | None]:
    """The odds as a chance; nought where nothing is asked."""
    found = rigid_odds(soft, evidence, known)
    return (0.0, None) if found is None else (float(expit(found[0])), found[1])


def _give(millimetres: float, std: float) -> Evidence:
    """What a wheel's load presses its tyre in by, mm."""

    def predict(values: Values) -> FloatArray:
        found = np.asarray(5000.0 / np.asarray(values[TYRES]) * 1e3)
        return found[None] if np.ndim(found) else np.array([float(found)])

    return Evidence(
        "roll",
        "made up",
        "tyres' give",
        "by hand",
        np.array([millimetres]),
        np.array([[std**2]]),
        predict,
        (TYRES,),
    )


def test_rigid_is_thirty_times_as_stiff_and_nothing_else() -> None:
    hard = rigid(KNOWN)
    assert hard.at(np.zeros(len(hard.names)))[TYRES] == pytest.approx(STIFFER * RATE)
    others = np.arange(len(KNOWN.names)) != KNOWN.index(TYRES)
    assert np.array_equal(hard.mean[others], KNOWN.mean[others])
    assert KNOWN.mean[KNOWN.index(TYRES)] == RATE


def test_odds_are_those_of_one_unknown() -> None:
    """One figure of one unknown: the ratio of two integrals over its prior, by brute force."""
    evidence = [_give(12.0, 3.0)]
    soft, stiff = find_mode(evidence, KNOWN), find_mode(evidence, rigid(KNOWN))
    u = np.linspace(-4.5, 6, 20001)
    weights = np.exp(-0.5 * u * u)

    def integral(mean: float, std: float) -> float:
        r = (12.0 - 5e6 / (mean + std * u)) / 3.0
        return float(np.log(weights @ np.exp(-0.5 * r * r)))

    exact = integral(STIFFER * RATE, 0.05 * STIFFER * RATE) - integral(RATE, 0.2 * RATE)
    assert log_odds(soft, stiff) == pytest.approx(exact, abs=0.15)


@pytest.mark.parametrize(("give", "found"), [(5e6 / RATE, False), (0.6 * 5e6 / RATE, False), (0.0, True)])
def test_only_tyres_that_give_nothing_are_taken_as_rigid(give: float, found: bool) -> None:
    evidence = [_give(give, 1.5), linear({"load": 1.0}, 100.0, 10.0)]
    chance, _ = rigid_chance(find_mode(evidence, KNOWN), evidence, KNOWN)
    assert (chance > SURE) is found
    result = infer(evidence, vehicle(), np.random.default_rng(0))
    assert result is not None
    assert (TEXT in result.record.spoke_for) is found
    # what one estimator says alone stays as doubtful as its relation was with usual tyres
    assert (result.doubtful.get("by hand", 1.0) > 1.0) is found


def test_a_drive_that_does_not_know_the_tyres_is_not_asked() -> None:
    evidence = [linear({"load": 1.0}, 900.0, 10.0)]
    assert rigid_chance(find_mode(evidence, KNOWN), evidence, KNOWN) == (0.0, None)


def test_where_the_odds_leave_it_open_the_answer_holds_both() -> None:
    """Tyres between soft and rigid, on which a load's figure hangs: mean and spread are those of the two fits by their chances."""
    gradient, at = 5.0, 5e6 / RATE

    def predict(values: Values) -> FloatArray:
        give = 5e6 / np.asarray(values[TYRES])
        found = np.asarray(np.asarray(values["load"]) + gradient * give)
        return found[None] if np.ndim(found) else np.array([float(found)])

    hangs = Evidence(
        "vertical", "made up", "load and tyres", "by hand too", np.array([100.0 + gradient * at]), np.array([[4.0]]), predict,
        (TYRES, "load"),
    )  # fmt: skip
    evidence = [_give(0.0, at / 3.4), hangs, linear({"load": 1.0}, 130.0, 60.0)]
    soft = find_mode(evidence, KNOWN)
    chance, stiff = rigid_chance(soft, evidence, KNOWN)
    assert stiff is not None
    assert 0.2 < chance < SURE
    result = infer(evidence, vehicle(), np.random.default_rng(0))
    assert result is not None
    assert any("answers hold both" in words for words in result.record.spoke_for)
    row = KNOWN.index("load")
    ends = [(KNOWN.mean[row] + KNOWN.std[row] * j.u[row]) for j in (soft, stiff)]
    apart = ends[1] - ends[0]
    mass = result.parameters["mass_kg"]
    assert mass.value is not None
    assert mass.std is not None
    # two narrow heaps, a known way apart
    assert mass.std > 0.9 * apart * np.sqrt(chance * (1 - chance))
    assert mass.low is not None
    assert mass.high is not None
    assert mass.high - mass.low > 0.9 * apart


def test_a_stated_rate_speaks_for_tyres_that_give() -> None:
    """The same log: a file with the tyres' rate was not written by somebody whose tyres have none."""
    evidence = [_give(0.6 * 5e6 / RATE, 3.0), linear({"load": 1.0}, 100.0, 10.0)]
    silent, _ = rigid_chance(find_mode(evidence, KNOWN), evidence, KNOWN)
    told = before_the_log(vehicle(tire_vertical_rate_npm=(RATE, 0.149 * RATE)))
    stated, other = rigid_chance(find_mode(evidence, told), evidence, told)
    assert other is not None
    assert 0 < stated < 0.5 * silent
