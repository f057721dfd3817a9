"""Deflections of a wrong scale: a balance takes them for other springs, a gyro on the same body sees them for what they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import expit

from pipelines.estimators.roll_map.answers import Coefficients
from pipelines.estimators.roll_map.evidence import SCALES, Motion, evidence_of
from pipelines.evidence import Evidence
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.weighed import WRONG_FILE
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.rigid_tyres import NAME as RIGID
from pipelines.joint.ways.spring_scale import springs_off
from pipelines.joint.ways.travel_scale import GYRO_BESIDE_SPRINGS, OPEN_STD, scale_odds, shown
from pipelines.joint.ways.travel_scale import NAME as SCALED
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, vehicle

FILE = vehicle(tire_vertical_rate_npm=(230e3, 10e3))
KNOWN = before_the_log(FILE)
QUICK = Motion(against_axles=True, banked_share=0.0, friction=0.0)
LOAD = linear({"load": 1.0}, 200.0, 10.0)


def _coefficients(gain: float | None, std: float = 0.03) -> Coefficients:
    """A fit that told nothing but the gyro's gain over the springs' own rate."""
    names = ("a", "b", "c") if gain is None else ("a", "b", "c", "rate_gain")
    mean = np.array([100.0, 6.0, 0.8, gain or 1.0])[: len(names)]
    weak = np.array([80.0, 6.0, 0.6, 0.15])[: len(names)]
    spread = np.diag(np.append(100 * weak[:3], [std][: len(names) - 3]) ** 2)
    return Coefficients(names, mean, spread, mean, weak)


def _seen(gain: float | None, file: Vehicle = FILE, motion: Motion = QUICK) -> tuple[Evidence, ...]:
    return evidence_of(_coefficients(gain), motion, file, "roll_map")


def _expected() -> float:
    """The gain of the file's own vehicle."""
    (only,) = _seen(1.2)
    return (
        float(only.predict(KNOWN.at(np.zeros(len(KNOWN.names))) | {"roll_rubs": 0.5})[-1] / only.observed[-1])
        * 1.2
    )


def _chance(evidence: Sequence[Evidence], file: Vehicle = FILE) -> float:
    """Of a wrong scale, over a right one."""
    known, whole = before_the_log(file), [*evidence, LOAD]
    found = scale_odds(find_mode(whole, known), whole, known)
    return 0.0 if found is None else float(expit(found[0]))


def test_what_is_seen_by_deflections_grows_as_their_scale_falls() -> None:
    whole = _coefficients(1.2)
    told = Coefficients(
        whole.names, whole.mean, np.diag((0.05 * whole.mean) ** 2), whole.mean, whole.prior_std
    )
    for only in evidence_of(told, QUICK, FILE, "roll_map"):
        assert set(SCALES) <= set(only.unknowns)
        values = KNOWN.at(np.zeros(len(KNOWN.names))) | {"roll_rubs": 0.5}
        other = values | dict.fromkeys(SCALES, 0.8)
        assert np.allclose(only.predict(other), 0.8 * only.predict(values))


def test_against_the_horizon_their_scale_is_nothing() -> None:
    whole = _coefficients(None)
    told = Coefficients(
        whole.names, whole.mean, np.diag((0.05 * whole.mean) ** 2), whole.mean, whole.prior_std
    )
    (only,) = evidence_of(told, Motion(False, 0.0, 0.0), FILE, "roll_map")
    assert not set(SCALES) & set(only.unknowns)


@pytest.mark.parametrize(("share", "low", "high"), [(1.0, 0.0, 0.015), (0.7, 0.95, 1.0), (1.45, 0.95, 1.0)])
def test_a_gyro_tells_a_wrong_scale(share: float, low: float, high: float) -> None:
    """share: of the gain that the file's vehicle has. 1 / share: by what the deflections show too much."""
    seen = _seen(share * _expected())
    assert low <= _chance(seen) <= high
    found = scale_odds(find_mode([*seen, LOAD], KNOWN), [*seen, LOAD], KNOWN)
    assert found is not None
    # the prior pulls it to 1 by next to nothing
    assert shown(found[1]) == pytest.approx(1 / share, rel=0.05)
    assert springs_off(found[1], (), FILE) == pytest.approx(abs(share - 1) if share != 1 else 0, abs=0.05)


@pytest.mark.parametrize(("chance", "told"), [(0.06, True), (0.04, False), (0.3, True)])
def test_a_wrong_scale_that_is_told_beside_the_right_one_leaves_deflections_open(
    chance: float, told: bool
) -> None:
    seen = [*_seen(0.8 * _expected()), LOAD]
    right = find_mode([*_seen(_expected()), LOAD], KNOWN)
    found = scale_odds(find_mode(seen, KNOWN), seen, KNOWN)
    assert found is not None
    share = springs_off(right, (), FILE, [(chance, found[1])])
    assert share == pytest.approx(chance**0.5 * 0.2 if told else 0.0, rel=0.25)


def test_the_odds_are_those_of_one_more_unknown() -> None:
    """All four scales bound to each other: two integrals over their mean, by brute force."""
    seen = linear(dict.fromkeys(SCALES, 0.25), 0.8, 0.05)
    gyro = replace(seen, carrier=GYRO_BESIDE_SPRINGS)
    found = scale_odds(find_mode([gyro], KNOWN), [gyro], KNOWN)
    assert found is not None
    s = np.linspace(-2, 3, 500_001)

    def integral(std: float) -> float:
        prior = np.exp(-0.5 * ((s - 1) / std) ** 2) / std
        return float(prior @ np.exp(-0.5 * ((s - 0.8) / 0.05) ** 2))

    each = float(KNOWN.std[KNOWN.index(SCALES[0])])
    common = 1 / np.sqrt(1 / OPEN_STD**2)
    exact = np.log(integral(common) / integral(each / 2)) + np.log(WRONG_FILE / (1 - WRONG_FILE))
    assert found[0] == pytest.approx(exact, abs=0.02)


def test_beside_a_gyro_other_springs_are_no_other_scale() -> None:
    """Rates at three quarters of the stated ones: half of a contradiction without a gyro, none of the scale's with one that goes with it."""
    rates = [
        replace(linear({f"spring_{a}": 1.0}, 0.75 * rate, 150.0, a), carrier=f"{a} springs")
        for a, rate in (("front", 35e3), ("rear", 38e3))
    ]
    alone = find_mode([*rates, LOAD], KNOWN)
    beside = find_mode([*rates, LOAD, *_seen(_expected())], KNOWN)
    assert springs_off(alone, doubts_of(alone, FILE), FILE) > 0.15
    assert springs_off(beside, doubts_of(beside, FILE), FILE) < 0.08


def test_without_a_gyro_nothing_tells() -> None:
    assert _seen(None) == ()
    assert _chance(()) == 0.0


def test_a_gain_by_roads_that_lean_says_little() -> None:
    """The same gain of flat ground and of bends alone: roads bank into their bends, and nobody knows by how much."""
    slow = Motion(against_axles=True, banked_share=1.0, friction=0.0)
    assert _chance(_seen(0.85)) > 0.95
    # a gyro that turns with the road is no relation at all
    assert _seen(0.85, motion=slow) == ()
    assert _chance(_seen(1.0, motion=slow)) < 0.1


def test_without_a_mass_the_gain_alone_is_handed_on() -> None:
    silent = Vehicle(body="SUV", quantities={k: q for k, q in FILE.quantities.items() if k != "mass_kg"})
    whole = _coefficients(0.8)
    sharp = Coefficients(
        whole.names, whole.mean, np.diag((0.01 * whole.mean) ** 2), whole.mean, whole.prior_std
    )
    (only,) = evidence_of(sharp, QUICK, silent, "roll_map")
    assert only.carrier == GYRO_BESIDE_SPRINGS
    assert len(only.observed) == 1
    assert _chance([only], silent) > 0.9
    assert evidence_of(sharp, Motion(False, 0.0, 0.0), silent, "roll_map") == ()


@pytest.mark.parametrize(("gain", "rate", "says"), [(0.8, True, SCALED), (1.0, False, RIGID)])
def test_too_much_travel_and_tyres_that_give_nothing_are_two_things(
    gain: float, rate: bool, says: str
) -> None:
    """A gain of 0.8 is nearer to rigid tyres' 1 than to 1.2, and is neither's."""
    file = FILE if rate else vehicle()
    reached = reach([*_seen(gain, file), LOAD], file, np.random.default_rng(0))
    assert reached is not None
    assert reached.found[0].startswith(says)
    assert reached.others == ()


def test_where_either_may_be_the_answers_hold_both() -> None:
    """A little less than rigid tyres show, of a vehicle whose tyres surely give: one of the two, and the log does not tell which."""
    reached = reach([*_seen(0.93), LOAD], FILE, np.random.default_rng(0))
    assert reached is not None
    assert {RIGID, SCALED} == {words.split(" (")[0] for words in reached.found}
    ((chance, _),) = reached.others
    assert 0.0 < chance <= 0.5


def test_the_cause_is_named_and_what_hangs_on_it_is_no_surer() -> None:
    """A load that the springs' travel alone tells: with the scale in doubt it is open."""

    def found(gain: float) -> tuple[float, tuple[str, ...]]:
        names = (*SCALES, "load")
        weigh = linear(dict.fromkeys(SCALES, 500.0) | {"load": 1.0}, 2000.0 + 200.0, 5.0)
        assert set(weigh.unknowns) == set(names)
        result = infer([weigh, *_seen(gain)], FILE, np.random.default_rng(0))
        assert result is not None
        mass = result.parameters["mass_kg"]
        assert mass.std is not None
        return mass.std, result.record.spoke_for

    (right, quiet), (wrong, said) = found(_expected()), found(0.75 * _expected())
    assert wrong > 2 * right
    assert any(SCALED in words for words in said)
    assert not any(SCALED in words for words in quiet)


@pytest.mark.parametrize(("share", "low", "high"), [(1.0, 0.0, 0.01), (0.75, 0.5, 1.0)])
def test_without_a_gyro_stated_springs_and_a_known_arm_contradict_it(
    share: float, low: float, high: float
) -> None:
    """Deflections that show a share of the travel, on springs and heights that are known to 2 %."""

    def seen(axle: str, rate: float) -> Evidence:
        wheels = {f"scale_{axle}{side}": 0.5 * rate for side in "lr"}
        sums = linear(
            {**wheels, f"spring_{'front' if axle == 'f' else 'rear'}": -1.0}, rate * (1 / share - 1), 700.0
        )
        return replace(sums, carrier=f"{axle} springs")

    assert low <= _chance([seen("f", 35e3), seen("r", 38e3)]) <= high
