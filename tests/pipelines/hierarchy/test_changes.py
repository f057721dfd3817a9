"""Load changes as they are told: sizes, words, order of time, and what is not told."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.changes import CHANCE, OR_SPRINGS, load_changes
from pipelines.hierarchy.join import joined
from pipelines.hierarchy.records import DriveTold, LoadChange
from pipelines.results import FloatArray
from tests.pipelines.hierarchy.toy_fleet import BEFORE, SCALES, Drive, kept, of_moments, told, weighed, whole

SEEN = weighed(SCALES, (10.0, 20.0, 5.0, 15.0))
TRUTH = {name: mean for name, (mean, _) in BEFORE.items()}
DRIVER = np.array([80.0, 1.4, 0.35, 0.9])
LADEN = np.array([380.0, 2.35, 0.07, 1.0])


def drives(
    loads: Sequence[FloatArray], relations: Sequence[dict[str, float]] = SEEN, seed: int = 0
) -> list[DriveTold]:
    rng = np.random.default_rng(seed)
    found = []
    for number, load in enumerate(loads):
        relation = kept(Drive(load, {}), TRUTH, relations, rng.standard_normal(len(relations)))
        found.append(told(number, whole(relation), days=float(number)))
    return found


def changes(told_drives: Sequence[DriveTold]) -> tuple[LoadChange, ...]:
    whole_fleet = joined(told_drives)
    assert whole_fleet.posterior is not None
    return load_changes(whole_fleet.posterior, whole_fleet.drives)


def test_a_change_is_told_with_its_size_and_place() -> None:
    same, more = changes(drives([DRIVER, DRIVER, LADEN]))
    assert (same.drive_id, same.before) == ("d001", "d000")
    assert not same.detected
    assert same.probability > CHANCE
    assert more.detected
    assert more.probability < 1e-6
    mass, std = more.changes["mass_kg"]
    assert mass == pytest.approx(300.0, abs=3 * std)
    assert std < 20.0
    assert " kg more, at the rear" in more.text
    assert "farther back" in more.text
    height, spread = more.changes["cg_height_m"]
    assert 0.0 < spread < 0.03
    assert height > 0


def test_drives_that_scatter_more_than_their_errors_have_wider_changes() -> None:
    """As their answers do."""
    fleet = joined(drives([DRIVER, LADEN]))
    assert fleet.posterior is not None
    calm = replace(fleet.posterior, chi2=0.0)
    wild = replace(calm, chi2=4.0 * calm.figures)
    (before,), (after,) = (load_changes(posterior, fleet.drives) for posterior in (calm, wild))
    for name, (size, std) in before.changes.items():
        assert after.changes[name] == (pytest.approx(size), pytest.approx(2 * std))


def test_less_is_the_opposite_of_more() -> None:
    (up,), (down,) = changes(drives([DRIVER, LADEN])), changes(drives([LADEN, DRIVER]))
    assert " kg more" in up.text
    assert " kg less" in down.text
    assert down.changes["mass_kg"][0] == pytest.approx(-up.changes["mass_kg"][0], abs=60.0)
    # taken from the rear: its place is still the rear
    assert ", at the rear" in down.text


def test_what_would_be_noticed_is_said() -> None:
    (same,) = changes(drives([DRIVER, DRIVER]))
    assert "would be noticed in half the cases" in same.text
    kilos = float(same.text.split("a change of ")[1].split(" kg")[0])
    # two weighings of 10 kg each and four directions: 3.6 standard deviations of the difference, less what is shared by errors
    assert 15 < kilos < 80


def test_a_load_that_only_moved() -> None:
    moved = LADEN.copy()
    moved[1] = 1.2
    (change,) = changes(drives([LADEN, moved]))
    assert change.detected
    assert abs(change.changes["mass_kg"][0]) < 3 * change.changes["mass_kg"][1]
    assert change.text.startswith("the load lies otherwise")
    assert "farther forward" in change.text


def test_drives_that_do_not_see_the_load() -> None:
    (change,) = changes(drives([DRIVER, LADEN], [{"spring_front": 1e-3}]))
    assert (change.detected, change.probability) == (False, 1.0)
    assert "cannot be told" in change.text
    assert "suspension deflections" in change.text


def test_a_blind_drive_between_two_that_see() -> None:
    """The one after it is compared with the one before it, and it is said; the blind one itself cannot be told."""
    seeing = drives([DRIVER, DRIVER, LADEN])
    blind = drives([DRIVER, DRIVER, LADEN], [{"spring_front": 1e-3}])
    middle, last = changes([seeing[0], blind[1], seeing[2]])
    assert (middle.before, middle.detected, middle.probability) == ("d000", False, 1.0)
    assert (last.before, last.drive_id, last.detected) == ("d000", "d002", True)
    assert last.text.endswith("(against d000: the drive between does not see the load)")


def test_order_of_time_whatever_the_order_of_drives() -> None:
    ordered = drives([DRIVER, LADEN, LADEN, DRIVER, DRIVER])
    shuffled = list(ordered)
    random.Random(3).shuffle(shuffled)
    assert [d.drive_id for d in shuffled] != [d.drive_id for d in ordered]
    assert changes(shuffled) == changes(ordered)
    assert [c.detected for c in changes(ordered)] == [True, False, True, False]


def test_missing_dates_come_last_and_blind_drives_are_passed_over() -> None:
    first, second, third = drives([DRIVER, DRIVER, LADEN])
    undated = DriveTold(first.drive_id, None, {}, first.kept)
    silent = DriveTold("d900", "2024-01-02T12:00:00+00:00", {}, None)
    found = changes([undated, silent, third, second])
    assert [(c.before, c.drive_id) for c in found] == [("d001", "d002"), ("d002", "d000")]


def test_one_drive_has_nothing_to_be_compared_with() -> None:
    assert changes(drives([DRIVER])) == ()


def test_a_scale_that_drifts_is_no_load() -> None:
    """A torque scale 1 % off in one drive is within what scales drift; the same as 1 % more mass."""
    seen = [{"empty_mass": 0.02, "moment 0": 0.02, "drive_scale": 38.0}]
    before = BEFORE | {"drive_scale": (1.0, 0.04)}
    truth = TRUTH | {"drive_scale": 1.0}
    found = []
    for kilos in (200.0, 200.0 + 38.0 * 0.0126 / 0.02):
        loads = [np.array([m, 1.4, 0.0, 0.9]) for m in (200.0, kilos)]
        pair = [kept(Drive(load, {}), truth, seen, np.zeros(1), before=before) for load in loads]
        found.append(changes([told(n, whole(k), days=float(n)) for n, k in enumerate(pair)])[0])
    assert found[0].probability == pytest.approx(1.0, abs=1e-6)
    # one standard deviation of the drift of one drive: far from detected
    assert found[1].probability > 0.3


@pytest.mark.parametrize("weighed_too", [False, True])
def test_a_spring_that_may_have_changed_is_said(weighed_too: bool) -> None:
    """What the rear springs carry is told by their travel: 150 kg over the rear axle, or springs that lost a fifth. Scales tell which."""
    before = BEFORE | {"zero_rl": (0.0, 60.0), "zero_rr": (0.0, 60.0)}
    travel = [of_moments({"zero_rl": 1 / 20, "zero_rr": 1 / 20}, (0.0, 9.81 / 2.8 / 20, 0.0, 0.0))]
    scales = SEEN if weighed_too else []
    rng, found = np.random.default_rng(2), []
    for number, kilos in enumerate((80.0, 80.0, 230.0)):
        load = np.array([kilos, 2.8, 0.0, 0.9])
        truth = TRUTH | {"zero_rl": 0.0, "zero_rr": 0.0}
        relations = [*travel, *scales]
        noise = rng.standard_normal(len(relations))
        drive = kept(Drive(load, {}), truth, relations, noise, before=before)
        found.append(told(number, whole(drive), days=float(number)))
    _, change = changes(found)
    assert change.detected
    assert (OR_SPRINGS in change.text) is not weighed_too
