"""The verdict's entry of a parameter that a drive does not tell."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from pipelines.evidence import Evidence
from pipelines.joint.answers import Told, estimate_of, learned_of
from pipelines.joint.inference import _inflation
from pipelines.joint.information import NEVER_NEGATIVE, Spread, prior_spreads, slopes
from pipelines.joint.posterior import find_mode
from pipelines.joint.rests import OF_PART, OF_RATE, part_on_file, rate_on_file, rests_on
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.parameters import spread_text
from pipelines.results import ParameterEstimate, Share
from pipelines.vehicles.vehicle_file import parse_vehicle
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())


def pitch() -> list[Evidence]:
    """A relation of the pitch balance."""
    return [replace(linear({"load_h": 1.0}, 0.8, 0.1), kind="pitch")]


def rolling() -> list[Evidence]:
    """A relation of the roll balance."""
    return [replace(linear({"load_h": 1.0}, 0.8, 0.1), kind="roll")]


PRIOR = Spread(90e3, 2500.0, 90e3 + 2500.0 * norm.ppf(np.linspace(0, 1, 4001)[1:-1]))


def entry(name: str, std: float, value: float = 94e3) -> ParameterEstimate:
    """Before: 90 000 ± 2 500; after: value ± std."""
    told = Told(value, std, value - 1.96 * std, value + 1.96 * std, None)
    return estimate_of(name, told, PRIOR, (), None, ())


def test_a_stiffness_that_the_load_leaves_open_is_given_for_that_load() -> None:
    found = entry("roll_stiffness_nmprad", 4e3)
    assert (found.value, found.std, found.status) == (94e3, 4e3, "not_identifiable")
    assert found.low is not None
    assert found.low < 90e3
    assert found.prior is not None
    assert found.prior.value == 90e3


def test_a_stiffness_that_the_drive_does_not_tell_is_given_for_the_load_that_it_does() -> None:
    told = Told(94e3, 2400.0, 89.3e3, 98.7e3, None)
    upright = [replace(linear({"load": 1.0}, 60.0, 5.0), kind="vertical"), *rolling()]
    found = estimate_of("roll_stiffness_nmprad", told, PRIOR, (), None, upright)
    assert (found.value, found.std, found.status, found.sources) == (
        94e3,
        2400.0,
        "not_identifiable",
        ("prior",),
    )
    assert "under the load that this drive shows" in found.reason
    assert estimate_of("roll_stiffness_nmprad", told, PRIOR, (), None, rolling()).value == 90e3


@pytest.mark.parametrize("name", ["roll_inertia_kgm2", "pitch_inertia_kgm2"])
def test_an_inertia_that_the_drive_does_not_tell_is_given_for_the_load_that_it_does(name: str) -> None:
    told = Told(91e3, 2400.0, 86.3e3, 95.7e3, None)
    braked = [replace(linear({"load": 1.0}, 60.0, 5.0), kind="longitudinal"), *rolling(), *pitch()]
    found = estimate_of(name, told, PRIOR, (), None, braked)
    assert (found.value, found.std, found.status) == (91e3, 2400.0, "not_identifiable")
    assert "under the load that this drive shows" in found.reason
    # nothing of the mass seen, or no surer than before: what was known
    assert estimate_of(name, told, PRIOR, (), None, [*rolling(), *pitch()]).value == 90e3
    assert entry(name, 2600.0, 91e3).value == 90e3


def test_what_nothing_opened_is_given_with_what_was_known_before() -> None:
    for name, std in (("roll_stiffness_nmprad", 2400.0), ("cg_height_m", 2900.0)):
        found = entry(name, std, 92e3)
        assert (found.value, found.std, found.status) == (
            90e3,
            pytest.approx(2500.0, rel=0.01),
            "not_identifiable",
        )


@pytest.mark.parametrize(
    ("value", "std", "said"),
    [
        (91e3, 4e3, "leaves it more open than that did"),
        (93e3, 2400.0, "leaves it elsewhere than what was known before, and no surer"),
    ],
)
def test_what_a_drive_leaves_open_or_moves_is_given_as_it_leaves_it(
    value: float, std: float, said: str
) -> None:
    told = Told(value, std, value - 1.96 * std, value + 1.96 * std, None)
    found = estimate_of("cg_height_m", told, PRIOR, (), None, rolling())
    assert (found.value, found.low, found.status) == (value, value - 1.96 * std, "not_identifiable")
    assert found.reason.startswith("what this drive shows")
    assert said in found.reason
    assert "adds little" not in found.reason
    # one prior, in the verdict and in what was learned
    learned = learned_of("cg_height_m", told, PRIOR, (), (), whole=True)
    assert found.prior == learned.prior
    assert found.prior is not None
    assert found.prior.value == 90e3


def test_an_interval_that_holds_heights_below_the_ground_tells_nothing() -> None:
    told = Told(0.17, 0.2, -0.22, 0.56, None)
    wide = Spread(0.6, 1.0, 0.6 + np.random.default_rng(0).standard_normal(4000))
    found = estimate_of("cg_height_m", told, wide, (), None, rolling())
    assert found.status == "not_identifiable"
    above = estimate_of("cg_height_m", Told(0.6, 0.02, 0.56, 0.64, None), wide, (), None, rolling())
    assert above.status == "identified"


@pytest.mark.parametrize(("value", "std"), [(-1049.0, 3674.0), (280.0, 1714.0)])
@pytest.mark.parametrize("name", ["roll_inertia_kgm2", "roll_arm_m", "cg_to_front_axle_m"])
def test_figures_of_no_vehicle_are_not_given_for_what_was_known_before(
    name: str, value: float, std: float
) -> None:
    """A log that contradicts its file beyond doubt, as by an inverted torque, leaves any figure open: these were printed."""
    told = Told(value, std, value - 1.96 * std, value + 1.96 * std, None)
    found = estimate_of(name, told, PRIOR, (), None, rolling())
    assert (found.value, found.status, found.sources) == (90e3, "not_identifiable", ("prior",))
    assert (found.low, found.high) == PRIOR.interval
    assert found.reason.startswith("what this drive shows against the vehicle file is of no vehicle; ")
    aside = estimate_of("cg_lateral_offset_m", told, PRIOR, (), None, rolling())
    assert (aside.value, aside.low) == (value, told.low)


def test_two_figures_that_miss_by_chance_do_not_widen_every_answer() -> None:
    """chi² 3.4 of two comes every fifth time; 34 of twenty once in forty, and says that spreads are too narrow."""
    few = find_mode([linear({"load": 1.0}, 0.0, 1.0), linear({"load": 1.0}, 2.6, 1.0)], KNOWN)
    many = find_mode([linear({"load": 1.0}, 2.6 * (i % 2), 1.0) for i in range(20)], KNOWN)
    assert _inflation(few) < 1.12
    assert _inflation(many) == pytest.approx(1.19, abs=0.05)


def test_what_was_known_before_is_given_with_one_spread_for_std_and_interval() -> None:
    """Loads on their stops leave a long tail: the middle's spread would be far narrower than the interval beside it."""
    rng = np.random.default_rng(1)
    draws = np.where(rng.random(20_000) < 0.1, 150e3, 90e3) + 2500 * rng.standard_normal(20_000)
    told = Told(94e3, 16e3, 62e3, 126e3, None)
    found = estimate_of("roll_inertia_kgm2", told, Spread(90e3, 2500.0, draws), (), None, ())
    assert found.low is not None
    assert found.high is not None
    assert found.std == pytest.approx((found.high - found.low) / 3.92)
    assert found.prior is not None
    assert found.prior.std == found.std
    wide = Told(94e3, 60e3, -20e3, 210e3, None)
    low = estimate_of("roll_stiffness_nmprad", wide, Spread(90e3, 2500.0, draws), (), None, ()).low
    assert low == 0.0


def test_no_draw_before_the_log_weighs_or_holds_less_than_nothing() -> None:
    known = before_the_log(
        parse_vehicle("[vehicle]\nmass_kg = {value = 1500, std = 900}\n", Path("vehicle.toml"))
    )
    spreads = prior_spreads(known, (), np.random.default_rng(0))
    for name, spread in spreads.items():
        if name.endswith(NEVER_NEGATIVE):
            assert spread.interval[0] > 0, name


@pytest.mark.parametrize(
    ("std", "status"),
    [
        (900.0, "identified"),
        (1800.0, "identified"),
        (1900.0, "weak"),
        (2650.0, "weak"),
        (2900.0, "not_identifiable"),
    ],
)
def test_a_status_is_by_what_is_left_of_the_interval_before(std: float, status: str) -> None:
    """Loads leave long tails: the interval before is wider than 1.96 of its middle's spread."""
    draws = 90e3 + 2300.0 * np.random.default_rng(4).standard_t(3.0, 200_000)
    prior = Spread(90e3, 2750.0, draws)
    before = prior.interval[1] - prior.interval[0]
    assert before == pytest.approx(2 * 3.182 * 2300.0, rel=0.02)
    told = Told(90e3, std, 90e3 - 1.96 * std, 90e3 + 1.96 * std, None)
    assert estimate_of("cg_height_m", told, prior, (), None, pitch()).status == status


def test_what_was_known_before_has_the_interval_of_its_draws() -> None:
    draws = 90e3 + 2500.0 * np.random.default_rng(2).exponential(1.0, 20_000)
    told = Told(94e3, 2.4e3, 89.3e3, 98.7e3, None)
    found = estimate_of("cg_height_m", told, Spread(92e3, 2300.0, draws), (), None, ())
    assert (found.low, found.high) == pytest.approx((90e3 + 2500 * 0.0253, 90e3 + 2500 * 3.689), rel=2e-3)


def test_words_have_the_digits_of_the_table() -> None:
    """A spread stood as ± 35444 beside 80 000 ± 18 000."""
    spreads = (0.01634, 0.0998, 1.449, 12.0, 99.7, 1714.0, 9960.0, 35444.0, 1.26e6, math.inf)
    assert [spread_text(std).replace("\u202f", " ") for std in spreads] == [
        "0.016", "0.10", "1.4", "12", "100", "1700", "10 000", "35 000", "1 300 000", "inf",
    ]  # fmt: skip
    told = Told(80e3, 18e3, 44e3, 116e3, None)
    wide = Spread(90e3, 50e3, 90e3 + 50e3 * norm.ppf(np.linspace(0, 1, 4001)[1:-1]))
    share = Share("Roll balance", 1.0, 35444.0, 20e3)
    found = estimate_of("roll_stiffness_nmprad", told, wide, (share,), None, rolling())
    assert "Roll balance (± 35\u202f000 without it)" in found.reason


def test_the_files_figure_that_no_drive_checks_is_named_with_the_answer() -> None:
    """Weights at rest against the empty vehicle tell the load; a weighing of the axles tells the empty vehicle as well."""
    load = linear({"load": 1.0}, 150.0, 5.0)
    weighed = linear({"empty_x": 1.0}, 1.31, 0.002)
    stated = {"empty_x": "cg_to_front_axle_m", "empty_mass": "mass_kg"}
    for evidence, said in (([load], "cg_to_front_axle_m"), ([load, weighed], "")):
        joint = find_mode(evidence, KNOWN)
        gradient = slopes(joint)[1]["cg_to_front_axle_m"]
        assert part_on_file("cg_to_front_axle_m", gradient, joint, stated) == said
        assert part_on_file("cg_to_front_axle_m", gradient, joint, {"empty_mass": "mass_kg"}) == ""
    both = {f"roll_center_{axle}": f"roll_center_height_{axle}_m" for axle in ("front", "rear")}
    axis = linear({"roll_center_front": 0.5, "roll_center_rear": 0.5}, 0.1, 0.002)
    for evidence, said in (([load], " and ".join(both.values())), ([load, axis], "")):
        joint = find_mode(evidence, KNOWN)
        gradient = slopes(joint)[1]["roll_center_height_m"]
        assert part_on_file("roll_center_height_m", gradient, joint, both) == said
        assert part_on_file("roll_center_height_m", gradient, joint, dict([*both.items()][:1])) == ""
    told = Told(1.31, 0.01, 1.29, 1.33, None)
    prior = Spread(1.3, 0.1, 1.3 + 0.1 * np.random.default_rng(0).standard_normal(4000))
    said = OF_PART.format("cg_to_front_axle_m")
    found = estimate_of("cg_to_front_axle_m", told, prior, (), None, pitch(), (), said)
    assert found.status == "identified"
    assert found.reason.endswith("the file's cg_to_front_axle_m, which this drive hardly checks")


def test_a_rate_off_the_sheet_that_no_drive_checks_is_named_with_what_it_would_move() -> None:
    """A load by how far it presses springs: 10 % off in their rate is 10 % of the load; a log that shows the rate clears it."""
    row = KNOWN.index("spring_rear")
    rate, std = float(KNOWN.mean[row]), float(KNOWN.std[row])
    stated = {"spring_rear": "spring_rate_rear_npm"}
    # 300 kg press the springs: a rate that is a share too high tells that share more
    weighs = linear({"load": 1.0, "spring_rear": -300.0 / rate}, 0.0, 2.0)
    shown = linear({"spring_rear": 1.0}, rate, 0.1 * std)
    for evidence, said in (([weighs], "spring_rate_rear_npm"), ([weighs, shown], "")):
        joint = find_mode(evidence, KNOWN)
        gradient = slopes(joint)[1]["mass_kg"]
        spread = float(np.sqrt(gradient @ joint.covariance @ gradient))
        key, moved = rate_on_file(gradient, 0.2 * spread, joint, stated)
        assert key == said
        if said:
            assert moved == pytest.approx(30.0, rel=0.02)
            words = rests_on("mass_kg", gradient, 0.2 * spread, joint, stated)
            assert words == OF_RATE.format("spring_rate_rear_npm", "30")
        # what moves it by less than it is open is left unsaid
        assert rate_on_file(gradient, 25.0, joint, stated) == ("", 0.0)


def test_an_answer_that_takes_the_tails_away_alone_is_held_against_all_that_was_known() -> None:
    """The load's long tails go, its middle is as open as before: weak, with 1.296 ± 0.102 before 1.390 ± 0.109 and no bit gained it was."""
    draws = 1.3 + 0.1 * np.random.default_rng(6).standard_t(1.5, 100_000)
    prior = Spread(1.3, 0.1, draws[np.abs(draws - 1.3) < 2.0])
    std = 0.11
    assert prior.std < std < 0.6 * prior.whole_std
    told = Told(1.35, std, 1.35 - 1.96 * std, 1.35 + 1.96 * std, None)
    entry = estimate_of("cg_to_front_axle_m", told, prior, (), None, pitch())
    share = Share("Pitch balance", 0.4, 0.2, 0.15)
    learned = learned_of("cg_to_front_axle_m", told, prior, (share,), ())
    assert entry.status == "weak"
    assert entry.prior is not None
    assert entry.prior.std == learned.prior.std == prior.whole_std
    assert learned.bits == pytest.approx(np.log2(prior.whole_std / std))
    assert learned.shares == (share,)
