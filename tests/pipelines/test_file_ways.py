"""A figure of the vehicle file that is wrong: asked beside rigid tyres and wrong scales, and where relations contradict each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.stated_figures import OFTEN_WRONG
from pipelines.joint.file_check import LOAD, STATED, UNSPRUNG
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import UNKNOWN, Reached, reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.file_ways import BAR, OPEN, file_ways, opened
from pipelines.joint.ways.rigid_tyres import NAME as RIGID
from pipelines.joint.ways.rigid_tyres import TYRES
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())
MASS = KNOWN.index("empty_mass")


def _reached(evidence: Sequence[Evidence], file: Vehicle | None = None) -> Reached:
    found = reach(evidence, file or vehicle(), np.random.default_rng(0))
    assert found is not None
    return found


def _rates(share: float, std: float = 100.0) -> list[Evidence]:
    """A log that has both spring rates at that share of the stated ones."""
    rates = {axle: share * float(KNOWN.mean[KNOWN.index(f"spring_{axle}")]) for axle in ("front", "rear")}
    return [
        replace(linear({f"spring_{axle}": 1.0}, rate, std, axle), carrier=f"{axle} springs")
        for axle, rate in rates.items()
    ]


def test_every_group_of_stated_figures_can_be_opened() -> None:
    assert OPEN.keys() == {*STATED, LOAD, UNSPRUNG}


def test_opening_widens_what_is_named_alone() -> None:
    free = opened(KNOWN, ["empty_mass"], (0.25, 0.0))
    others = np.arange(len(KNOWN.names)) != MASS
    assert np.array_equal(free.std[others], KNOWN.std[others])
    assert np.array_equal(free.mean, KNOWN.mean)
    assert free.std[MASS] == 0.25 * KNOWN.mean[MASS]
    assert np.array_equal(opened(KNOWN, ["empty_mass"], (0.0, 1.0)).std, KNOWN.std)


def test_a_bar_of_nought_may_be_any_bar() -> None:
    none = before_the_log(vehicle(anti_roll_stiffness_front_nmprad=(0.0, 0.0)))
    row = none.index("bar_front")
    assert none.std[row] > 0
    assert opened(none, ["bar_front"], (0.4, 0.0)).std[row] == pytest.approx(BAR * 0.5 * 35e3 * 1.6**2)


@pytest.mark.parametrize("seen", [1900.0, 1960.0, 2030.0])
def test_odds_are_those_of_two_integrals(seen: float) -> None:
    """One figure of one unknown under two priors, exactly."""
    evidence = [linear({"empty_mass": 1.0}, seen, 15.0)]
    told = {t: odds for t, odds, *_ in file_ways(find_mode(evidence, KNOWN), evidence, KNOWN, vehicle())}
    assert told.keys() == {t for t, keys in STATED.items() if any(vehicle().get(k) for k in keys)}

    def log_density(std: float) -> float:
        spread = std**2 + 15.0**2
        return float(-0.5 * (seen - 1900.0) ** 2 / spread - 0.5 * np.log(spread))

    chance = OFTEN_WRONG["stated mass"]
    exact = log_density(0.25 * 1900.0) - log_density(19.0) + np.log(chance / (1 - chance))
    assert told["stated mass"] == pytest.approx(exact, abs=1e-3)
    # what the log does not see stays as unlikely as it was
    # (with an inertia that is known by the square of the length, and follows it: roughly)
    assert told["stated tracks"] == pytest.approx(np.log(0.015 / 0.985), abs=1e-3)
    assert told["stated wheelbase"] == pytest.approx(np.log(0.003 / 0.997), abs=0.03)


def test_what_is_stated_as_exact_is_not_asked() -> None:
    exact = vehicle(mass_kg=(1900.0, 0.0))
    known = before_the_log(exact)
    evidence = [linear({"load": 1.0}, 100.0, 10.0)]
    assert "stated mass" not in {t for t, *_ in file_ways(find_mode(evidence, known), evidence, known, exact)}


def test_without_a_conflict_nothing_is_asked() -> None:
    found = _reached([*_rates(1.01), linear({"load": 1.0}, 100.0, 10.0)])
    assert found.found == ()
    assert found.others == ()


def test_a_conflict_is_that_of_the_figure_that_explains_it_or_of_something_else() -> None:
    found = _reached(_rates(0.6))
    assert found.found[0].startswith("stated spring rates wrong (odds 70%)")
    ((chance, other),) = found.others
    assert chance == pytest.approx(1 - UNKNOWN)
    row = other.known.index("spring_front")
    assert other.known.mean[row] + other.known.std[row] * other.u[row] == pytest.approx(0.6 * 35e3, rel=0.01)


def test_the_interval_holds_what_the_file_says_and_what_the_log_does() -> None:
    """A stiffness that hangs on the springs: neither figure is surely wrong."""

    def stiffness(share: float) -> tuple[float, float]:
        result = infer(_rates(share), vehicle(), np.random.default_rng(0))
        assert result is not None
        entry = result.parameters["roll_stiffness_nmprad"]
        assert entry.low is not None
        assert entry.high is not None
        return entry.low, entry.high

    low, high = stiffness(0.6)
    right = stiffness(1.0)
    assert low < 0.75 * right[0]
    assert high > 0.95 * right[0]


def test_one_cause_is_named_once() -> None:
    """By its own fit, and not again as a doubt of straight lines, which may name another."""
    result = infer(_rates(0.6), vehicle(), np.random.default_rng(0))
    assert result is not None
    assert any(text.startswith("stated spring rates wrong") for text in result.record.spoke_for)
    assert not any(text.startswith("stated") for text in result.record.far)


def _hard_tyres() -> Evidence:
    """A log whose tyres hardly give, mm under a wheel's load: rigid ones are heard, and no more."""

    def predict(values: Values) -> FloatArray:
        found = np.asarray(5e6 / np.asarray(values[TYRES]))
        return found[None] if np.ndim(found) else np.array([float(found)])

    usual = 5e6 / float(KNOWN.mean[KNOWN.index(TYRES)])
    return Evidence(
        "roll", "made up", "tyres' give", "by hand", np.array([0.25 * usual]), np.array([[(0.25 * usual) ** 2]]), predict, (TYRES,)
    )  # fmt: skip


def test_a_figure_that_is_asked_beside_tyres_leaves_something_else_open_too() -> None:
    """What looks like rigid tyres, and a conflict that one figure explains: it may be a channel that is late, or a road that banks."""
    soft = _reached([_hard_tyres(), linear({"load": 1.0}, 100.0, 10.0)])
    assert any(RIGID in words for words in soft.found)
    found = _reached([_hard_tyres(), *_rates(0.6)])
    assert "the answers hold" in found.found[0]
    assert found.found[0].startswith("stated spring rates wrong (odds 70%)")
    assert found.opened[0] == ""
    assert sum(chance for chance, _ in found.others) == pytest.approx(1 - UNKNOWN)
