"""What drives doubt is in what all of a vehicle's drives say: in answers of drives, and in those of the vehicle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.vehicle import join_vehicle
from pipelines.joint.vehicle.empty import FIGURES, figure_at
from pipelines.joint.ways.other_vehicle import ANOTHERS
from tests.pipelines.hierarchy.hand_made_fleet import KNOWN, fleet, said, std_of


@pytest.mark.parametrize(("widened", "normal"), [({"side": 1.5}, True), ({}, True), ({}, False)])
def test_what_a_drive_doubts_stays_wide(widened: dict[str, float], normal: bool) -> None:
    """A contradiction, a sensor that may be wrong, a posterior that is not normal: nothing of it is in the linear relations."""
    drives, _ = fleet(6)
    relations = drives[2].kept
    assert relations is not None
    drives[2] = replace(drives[2], kept=replace(relations, normal=normal))
    before = join_vehicle("v", drives).drives["d02"]["cg_height_m"]
    entry = drives[2].verdict["cg_height_m"]
    wide = replace(entry, std=float(np.hypot(std_of(entry), 0.05)))
    drives[2] = replace(
        drives[2],
        kept=replace(relations, widened=widened, normal=normal),
        verdict={**drives[2].verdict, "cg_height_m": wide},
    )
    after = join_vehicle("v", drives).drives["d02"]["cg_height_m"]
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), 0.05)), rel=0.05)


def test_what_a_drive_doubts_and_does_not_tell_stays_wide() -> None:
    """Figures of its own that are no result are as doubtful as it says; those that were known before say nothing of the drive."""
    drives, _ = fleet(6)
    name = "cg_height_m"
    entry = drives[2].verdict[name]
    before = join_vehicle("v", drives).drives["d02"][name]
    wide = float(np.hypot(std_of(entry), 0.05))
    drives[2] = said(drives[2], name, std=wide, status="not_identifiable", reason="the file may be wrong")
    after = join_vehicle("v", drives).drives["d02"][name]
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), 0.05)), rel=0.05)
    assert entry.prior is not None
    drives[2] = said(drives[2], name, value=entry.prior.value, std=entry.prior.std)
    assert std_of(join_vehicle("v", drives).drives["d02"][name]) == pytest.approx(std_of(before))


def test_doubts_that_leave_nothing_to_tell_stay_in_joined_answers() -> None:
    """The verdict has the figures that were known before, as the drive's doubts leave hardly less; its linear relations know nothing of these."""
    drives, _ = fleet(6)
    name = "cg_height_m"
    entry, relations = drives[2].verdict[name], drives[2].kept
    assert entry.value is not None
    assert entry.prior is not None
    assert relations is not None
    before = join_vehicle("v", drives).drives["d02"][name]
    assert before.status == "identified"
    drives[2] = said(
        drives[2], name, value=entry.prior.value, std=entry.prior.std, status="not_identifiable", sources=("prior",)
    )  # fmt: skip
    left = 0.9 * entry.prior.std
    told = replace(relations, told={name: (entry.value, left)})
    drives[2] = replace(drives[2], kept=told)
    after = join_vehicle("v", drives).drives["d02"][name]
    assert after.status == "not_identifiable"
    more = left**2 - std_of(entry) ** 2
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), np.sqrt(more))), rel=0.02)
    # an earlier version's file has none of it, and is joined as ever
    drives[2] = replace(drives[2], kept=relations)
    assert join_vehicle("v", drives).drives["d02"][name].std == pytest.approx(std_of(before))


def test_a_doubt_that_moves_the_drives_answer_counts_by_how_far() -> None:
    """Other drives do not say whether it is right: the joined figure is that of the relations, and must hold the other one."""
    drives, _ = fleet(6)
    name = "cg_height_m"
    entry = drives[2].verdict[name]
    assert entry.value is not None
    before = join_vehicle("v", drives).drives["d02"][name]
    drives[2] = said(drives[2], name, value=entry.value + 0.02)
    after = join_vehicle("v", drives).drives["d02"][name]
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), 0.02)), rel=0.02)


@pytest.mark.parametrize("before", ["", "relations disagree; "])
def test_nothing_is_identified_where_the_drive_says_that_its_file_is_wrong(before: str) -> None:
    """Whatever else its reason says first."""
    words = "something is wrong: is it the file? "
    drives, _ = fleet(6)
    name = "cg_height_m"
    assert join_vehicle("v", drives).drives["d02"][name].status == "identified"
    drives[2] = said(drives[2], name, status="weak", reason=f"{before}{words}from what it saw", refused=words)
    found = join_vehicle("v", drives)
    answer = found.drives["d02"][name]
    assert answer.status == "weak"
    assert answer.reason.startswith(f"{words}with all 6 drives")
    assert found.drives["d01"][name].status == "identified"


@pytest.mark.parametrize(("count", "status"), [(2, "identified"), (3, "weak")])
def test_the_vehicles_own_figures_are_no_surer_of_a_wrong_file(count: int, status: str) -> None:
    """Half of its drives say that it is wrong; a file that one drive of many has, others outvote."""
    words = "the file is wrong; "
    drives, _ = fleet(6)
    sure = [n for n, p in join_vehicle("v", drives).vehicle.items() if p.estimate.status == "identified"]
    assert sure
    for i in range(count):
        drives[i] = said(drives[i], "mass_kg", refused=words)
        drives[i] = said(drives[i], "cg_height_m", refused=words)
    found = join_vehicle("v", drives).vehicle
    for name in sure:
        assert found[name].estimate.status == status
        assert found[name].estimate.reason.startswith("in 3 of 6 drives the file is wrong; ") is (count == 3)


@pytest.mark.parametrize("count", [2, 3])
def test_what_most_drives_say_of_another_vehicles_file_tells_nothing_of_this_one(count: int) -> None:
    words = f"{ANOTHERS} (odds 100%), and what it states is what this hangs on; "
    drives, _ = fleet(6)
    sure = [n for n, p in join_vehicle("v", drives).vehicle.items() if p.estimate.status == "identified"]
    for i in range(count):
        for name in ("mass_kg", "cg_height_m"):
            drives[i] = said(drives[i], name, status="not_identifiable", refused=words)
    found = join_vehicle("v", drives)
    for name in sure:
        told = found.vehicle[name].estimate.status
        assert (told == "not_identifiable") is (count == 3)
    assert found.drives["d00"]["cg_height_m"].status == "not_identifiable"


def _doubting(drive: DriveTold, name: str, doubt: float) -> DriveTold:
    """The drive with so much more spread in a figure of the vehicle than its relations have."""
    relations = drive.kept
    assert relations is not None
    figure = next(f for f in FIGURES if f.name == name)
    value, slope = figure_at(figure, relations.names, relations.mode, relations.std)
    covariance = np.linalg.inv(np.diag(1 / relations.std**2) + relations.rows.T @ relations.rows)
    std = float(np.sqrt(slope @ covariance @ slope + doubt**2))
    return replace(drive, kept=replace(relations, empty={name: (value, std)}))


def test_the_vehicles_figures_keep_what_its_drives_doubt() -> None:
    """They doubt the same file and the same kind of springs: no number of drives averages that."""
    name = "spring_rate_front_npm"
    for count in (2, 8):
        drives, _ = fleet(count)
        before = join_vehicle("v", drives).vehicle[name]
        doubting = [_doubting(drive, name, 200.0) for drive in drives]
        after = join_vehicle("v", doubting).vehicle[name]
        assert after.doubt == pytest.approx(200.0, rel=1e-3)
        assert std_of(after.estimate) == pytest.approx(
            float(np.hypot(std_of(before.estimate), 200.0)), rel=1e-3
        )
        assert after.estimate.value == before.estimate.value
    # one that doubts among many that do not counts by what it tells
    one = join_vehicle("v", [doubting[0], *drives[1:]]).vehicle[name]
    assert one.doubt == pytest.approx(200.0 / len(drives), rel=0.1)


def test_a_friction_that_may_be_below_nought_is_not_told() -> None:
    drives, _ = fleet(3)
    column, name = KNOWN.index("friction_front"), "friction_front_n"
    mean, std = float(KNOWN.mean[column]), float(KNOWN.std[column])

    def at(value: float) -> str:
        seen = []
        for drive in drives:
            assert drive.kept is not None
            rows = np.zeros((1, len(KNOWN.names)))
            rows[0, column] = 1 / (0.3 * std)
            kept = replace(
                drive.kept, rows=rows, observed=rows[:, column] * value, relation=("rub",), kind=("vertical",),
                source=("by hand",), mode=KNOWN.mean,
            )  # fmt: skip
            seen.append(replace(drive, kept=kept))
        return join_vehicle("v", seen).vehicle[name].estimate.status

    assert at(mean) != "not_identifiable"
    assert at(-0.1 * std) == "not_identifiable"


def test_a_single_drives_misfit_is_in_the_vehicles_figures() -> None:
    """As it is in its own verdict, and in those of two drives."""
    drives, _ = fleet(1)
    relations = drives[0].kept
    assert relations is not None
    name = "spring_rate_front_npm"
    before = join_vehicle("v", drives).vehicle[name]
    for other in (replace(relations, inflation=2.0), replace(relations, normal=False)):
        after = join_vehicle("v", [replace(drives[0], kept=other)]).vehicle[name]
        assert std_of(after.estimate) > 1.3 * std_of(before.estimate)
