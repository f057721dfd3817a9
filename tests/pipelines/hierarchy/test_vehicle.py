"""What all drives of a vehicle say: answers of drives, of the vehicle, and what is said of drives that do not fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.common import RHO
from pipelines.hierarchy.own_outputs import outputs_at
from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.vehicle import join_vehicle
from pipelines.joint.vehicle.empty import FIGURES, figure_at
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import Identification, Prior
from tests.pipelines.hierarchy.hand_made_fleet import KNOWN, SEES, fleet, said, std_of
from tests.pipelines.joint_parts import vehicle


def test_single_drive_keeps_its_verdict() -> None:
    drives, _ = fleet(1)
    found = join_vehicle("v", drives)
    assert found.drives == {"d00": drives[0].verdict}
    assert (found.notes, found.drive_notes, found.apart) == ((), {}, {})
    assert found.vehicle["spring_rate_front_npm"].drives == 1


def test_every_drive_is_known_better() -> None:
    drives, truths = fleet(12)
    found = join_vehicle("v", drives)
    narrower: dict[str, list[float]] = {"cg_height_m": [], "roll_stiffness_nmprad": []}
    for drive, truth in zip(drives, truths, strict=True):
        mine = found.drives[drive.drive_id]
        assert mine["roll_gradient_degpg"] == drive.verdict["roll_gradient_degpg"]
        for name in narrower:
            narrower[name].append(std_of(mine[name]) / std_of(drive.verdict[name]))
        exact, _ = outputs_at(KNOWN.names, np.array([truth[n] for n in KNOWN.names]), KNOWN.std, {})
        height = mine["cg_height_m"]
        assert height.value is not None
        assert abs(height.value - exact["cg_height_m"]) < 4 * std_of(height)
        assert "all 12 drives" in height.reason
        assert height.sources == ("me", "hierarchy")
        assert height.low == pytest.approx(height.value - 1.96 * std_of(height))
    # slopes are taken where the joined drives lie, so that a single one may be a little wider
    assert all(np.mean(ratios) < 1 for ratios in narrower.values())


def test_what_a_drive_told_alone_is_told_with_the_others_as_well() -> None:
    """A blind checker's fleet: identified by the drive, weak with the others, and narrower."""
    drives, _ = fleet(12)

    def told(status: Identification) -> list[DriveTold]:
        made = []
        for drive in drives:
            own = drive.verdict["cg_height_m"]
            known = Prior(0.55, 1.5 * std_of(own), "known before")
            height = replace(own, status=status, prior=known)
            made.append(replace(drive, verdict={**drive.verdict, "cg_height_m": height}))
        return made

    sure = told("identified")
    joined, plain = join_vehicle("v", sure).drives, join_vehicle("v", told("weak")).drives
    assert any(plain[d.drive_id]["cg_height_m"].status == "weak" for d in drives)
    for drive in sure:
        mine, own = joined[drive.drive_id]["cg_height_m"], drive.verdict["cg_height_m"]
        if std_of(mine) <= std_of(own):
            assert mine.status == "identified"


def test_vehicle_gets_sharper_with_drives_but_not_than_its_model() -> None:
    stds = []
    for count in (1, 4, 16):
        # drives that scatter more than chance would (seed 1's first four) are widened besides
        drives, truths = fleet(count, seed=2)
        answer = join_vehicle("v", drives).vehicle["spring_rate_front_npm"]
        assert answer.estimate.value is not None
        assert abs(answer.estimate.value - truths[0]["spring_front"]) < 4 * std_of(answer.estimate)
        assert answer.drives == count
        assert answer.single_std is not None
        stds.append((std_of(answer.estimate), answer.single_std))
    assert stds[0][0] == pytest.approx(stds[0][1], rel=1e-6)
    # the error of n drives' mean: what they have in common, and a share of what each has of its own
    prior, error = 700.0, SEES["front springs"][2]
    for (std, _), count in zip(stds, (1, 4, 16), strict=True):
        variance = error**2 * (RHO + (1 - RHO) / count)
        assert std == pytest.approx((1 / prior**2 + 1 / variance) ** -0.5, rel=1e-6)


def test_drive_of_another_vehicle_is_left_out_andsaid() -> None:
    drives, _ = fleet(8)
    alone = join_vehicle("v", [d for d in drives if d.drive_id != "d03"])
    relations = drives[3].kept
    assert relations is not None
    column = KNOWN.index("spring_front")
    far = relations.observed + relations.rows[:, column] * 0.5 * KNOWN.mean[column]
    drives[3] = replace(drives[3], kept=replace(relations, observed=far))
    found = join_vehicle("v", drives)
    (note,) = found.drive_notes["d03"]
    assert "d03 does not go with" in note
    assert found.apart == {"d03": "misfit"}
    # said to that drive, not to all
    assert not any("d03" in said for said in found.notes_for("d01"))
    assert found.notes_for("d03") == (*found.notes, note)
    own = found.drives["d03"]["cg_height_m"]
    assert own.reason.startswith("this drive alone")
    assert own.value == drives[3].verdict["cg_height_m"].value
    for drive in drives[4:]:
        joined, before = (k.drives[drive.drive_id]["cg_height_m"].value for k in (found, alone))
        assert joined == pytest.approx(before, abs=1e-9)


def test_drive_without_relations_passes_through() -> None:
    drives, _ = fleet(4)
    drives[1] = replace(drives[1], kept=None)
    found = join_vehicle("v", drives)
    assert found.drives["d01"] == drives[1].verdict
    assert any("nothing to join in 1 of 4 drives: d01" in note for note in found.notes)
    assert found.vehicle["empty_mass_kg"].drives == 3


def test_no_drive_at_all_and_none_that_told() -> None:
    assert join_vehicle("v", []).drives == {}
    drives, _ = fleet(2)
    silent = [replace(d, kept=None) for d in drives]
    found = join_vehicle("v", silent)
    assert found.vehicle == {}
    assert found.drives == {d.drive_id: d.verdict for d in drives}


def test_order_of_the_drives_changes_nothing() -> None:
    drives, _ = fleet(5)
    one, other = join_vehicle("v", drives), join_vehicle("v", [drives[i] for i in (3, 1, 4, 0, 2)])
    assert list(one.drives) == list(other.drives)
    assert one.drives == other.drives
    assert one.vehicle == other.vehicle
    assert one.load_changes == other.load_changes


def test_a_stiffness_that_may_be_below_nought_is_not_identified() -> None:
    drives, _ = fleet(6)
    name = "roll_stiffness_nmprad"
    entry = drives[2].verdict[name]
    assert entry.value is not None
    assert entry.prior is not None
    wide = replace(entry.prior, std=10 * entry.value)
    drives[2] = said(drives[2], name, std=0.6 * entry.value, status="weak", prior=wide)
    answer = join_vehicle("v", drives).drives["d02"][name]
    assert answer.low is None or answer.low > 0 or answer.status == "not_identifiable"


def test_a_side_that_only_other_drives_saw_is_not_identified() -> None:
    """A load's place is each drive's own; a relation that tells how heavy it is says nothing of the side."""
    drives, _ = fleet(6)
    name = "cg_lateral_offset_m"
    assert join_vehicle("v", drives).drives["d02"][name].status != "not_identifiable"
    relations = drives[2].kept
    assert relations is not None
    kinds = ("vertical",) * len(relations.kind)
    known = drives[2].verdict[name].prior
    assert known is not None
    drives[2] = said(
        replace(drives[2], kept=replace(relations, kind=kinds)), name, value=known.value, std=known.std,
        status="not_identifiable",
    )  # fmt: skip
    assert join_vehicle("v", drives).drives["d02"][name].status == "not_identifiable"


def test_what_no_drive_saw_is_not_identified() -> None:
    """No verdict has them, and no relation: they stand as before the logs."""
    drives, _ = fleet(6)
    found = join_vehicle("v", drives)
    for name in ("drag_area_m2", "pitch_inertia_kgm2"):
        assert name not in drives[2].verdict
        answer = found.drives["d02"].get(name)
        assert answer is None or answer.status == "not_identifiable", name


def test_the_vehicles_bar_is_the_bar_itself() -> None:
    """Of a live axle whose springs stand at 0.7 of the track, as the file states it."""
    file = vehicle(spring_base_rear_m=(0.7 * 1.6, 0.003))
    known = before_the_log(file)
    figure = next(f for f in FIGURES if f.name == "anti_roll_stiffness_rear_nmprad")
    value, _ = figure_at(figure, known.names, known.mean, known.std)
    assert known.mean[known.index("bar_rear")] < 0
    assert value == pytest.approx(8e3)
