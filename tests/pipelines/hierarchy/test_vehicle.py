"""What all drives of a vehicle say: answers of drives, of the vehicle, and what is said of drives that do not fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipelines.hierarchy.common import RHO
from pipelines.hierarchy.own_outputs import outputs_at
from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.vehicle import join_vehicle
from pipelines.joint.empty import FIGURES, figure_at
from pipelines.joint.kept import KeptRelations
from pipelines.joint.unknowns import before_the_log
from pipelines.results import FloatArray, ParameterEstimate, Prior
from tests.pipelines.joint_parts import vehicle

KNOWN = before_the_log(vehicle())
SHOWN = ("mass_kg", "cg_height_m", "roll_stiffness_nmprad", "cg_lateral_offset_m")
SEES = {
    "weight": ("vertical", {"empty_mass": 1.0, "load": 1.0}, 12.0),
    "height": ("pitch", {"empty_h": 1.0, "load_h": 0.1, "load": 0.0003}, 0.012),
    "front springs": ("roll", {"spring_front": 1.0}, 300.0),
    "rear springs": ("roll", {"spring_rear": 1.0}, 300.0),
    "side": ("roll", {"empty_y": 1.0, "load_y": 0.1}, 0.006),
}
"""Relation -> kind, weights by unknown, standard deviation of its error."""


def kept(truth: dict[str, float], errors: FloatArray) -> KeptRelations:
    """Relations of a drive in which the unknowns are `truth`, linear. errors: (m,) in standard deviations."""
    rows = np.zeros((len(SEES), len(KNOWN.names)))
    for i, (_, weights, std) in enumerate(SEES.values()):
        for name, weight in weights.items():
            rows[i, KNOWN.index(name)] = weight / std
    at = np.array([truth[name] for name in KNOWN.names])
    observed = rows @ at + errors
    covariance = np.linalg.inv(np.diag(1 / KNOWN.std**2) + rows.T @ rows)
    mode = covariance @ (KNOWN.mean / KNOWN.std**2 + rows.T @ observed)
    kinds = tuple(kind for kind, _, _ in SEES.values())
    return KeptRelations(
        KNOWN.names, KNOWN.mean, KNOWN.std, mode, rows, observed, tuple(SEES), kinds, ("by hand",) * len(rows), {}, {},
        1.0, True,
    )  # fmt: skip


def verdict(relations: KeptRelations) -> dict[str, ParameterEstimate]:
    """A drive's own answers, and one that is no matter of relations."""
    covariance = np.linalg.inv(np.diag(1 / relations.std**2) + relations.rows.T @ relations.rows)
    values, gradients = outputs_at(relations.names, relations.mode, relations.std, {})
    before, slopes = outputs_at(relations.names, relations.mean, relations.std, {})
    found = {
        "roll_gradient_degpg": ParameterEstimate(
            "roll_gradient_degpg", 5.0, 0.1, 4.8, 5.2, "identified", "fitted"
        )
    }
    for name in SHOWN:
        std = float(np.sqrt(gradients[name] @ covariance @ gradients[name]))
        prior = Prior(before[name], float(np.linalg.norm(slopes[name] * relations.std)), "by hand")
        low, high = values[name] - 1.96 * std, values[name] + 1.96 * std
        found[name] = ParameterEstimate(
            name, values[name], std, low, high, "identified", "by hand", prior, None, ("me",)
        )
    return found


def fleet(count: int, seed: int = 1) -> tuple[list[DriveTold], list[dict[str, float]]]:
    """Drives of one vehicle with loads of their own, and what is true in each."""
    rng = np.random.default_rng(seed)
    same = dict(
        zip(
            KNOWN.names,
            (KNOWN.mean + KNOWN.std * rng.standard_normal(len(KNOWN.names))).tolist(),
            strict=True,
        )
    )
    common = np.sqrt(RHO) * rng.standard_normal(len(SEES))
    drives, truths = [], []
    for day in range(count):
        load = {
            "load": 100 + 60 * rng.standard_normal(),
            "load_h": 0.9 + 0.2 * rng.standard_normal(),
            "load_y": 0.1,
        }
        truth = same | {name: float(value) for name, value in load.items()}
        relations = kept(truth, common + np.sqrt(1 - RHO) * rng.standard_normal(len(SEES)))
        drives.append(
            DriveTold(f"d{day:02d}", f"2024-03-{day + 1:02d}T07:00:00+00:00", verdict(relations), relations)
        )
        truths.append(truth)
    return drives, truths


def std_of(entry: ParameterEstimate) -> float:
    assert entry.std is not None
    return entry.std


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


def test_drive_of_another_vehicle_is_left_out_and_said() -> None:
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


def _said(drive: DriveTold, name: str, **other: Any) -> DriveTold:
    """The drive with another entry for one parameter."""
    return replace(drive, verdict={**drive.verdict, name: replace(drive.verdict[name], **other)})


def test_what_a_drive_doubts_and_does_not_tell_stays_wide() -> None:
    """Figures of its own that are no result are as doubtful as it says; those that were known before say nothing of the drive."""
    drives, _ = fleet(6)
    name = "cg_height_m"
    entry = drives[2].verdict[name]
    before = join_vehicle("v", drives).drives["d02"][name]
    wide = float(np.hypot(std_of(entry), 0.05))
    drives[2] = _said(drives[2], name, std=wide, status="not_identifiable", reason="the file may be wrong")
    after = join_vehicle("v", drives).drives["d02"][name]
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), 0.05)), rel=0.05)
    assert entry.prior is not None
    drives[2] = _said(drives[2], name, value=entry.prior.value, std=entry.prior.std)
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
    drives[2] = _said(
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
    drives[2] = _said(drives[2], name, value=entry.value + 0.02)
    after = join_vehicle("v", drives).drives["d02"][name]
    assert std_of(after) == pytest.approx(float(np.hypot(std_of(before), 0.02)), rel=0.02)


@pytest.mark.parametrize("before", ["", "relations disagree; "])
def test_nothing_is_identified_where_the_drive_says_that_its_file_is_wrong(before: str) -> None:
    """Whatever else its reason says first."""
    words = "something is wrong: is it the file? "
    drives, _ = fleet(6)
    name = "cg_height_m"
    assert join_vehicle("v", drives).drives["d02"][name].status == "identified"
    drives[2] = _said(
        drives[2], name, status="weak", reason=f"{before}{words}from what it saw", refused=words
    )
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
        drives[i] = _said(drives[i], "mass_kg", refused=words)
        drives[i] = _said(drives[i], "cg_height_m", refused=words)
    found = join_vehicle("v", drives).vehicle
    for name in sure:
        assert found[name].estimate.status == status
        assert found[name].estimate.reason.startswith("in 3 of 6 drives the file is wrong; ") is (count == 3)


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


def test_a_stiffness_that_may_be_below_nought_is_not_identified() -> None:
    drives, _ = fleet(6)
    name = "roll_stiffness_nmprad"
    entry = drives[2].verdict[name]
    assert entry.value is not None
    assert entry.prior is not None
    wide = replace(entry.prior, std=10 * entry.value)
    drives[2] = _said(drives[2], name, std=0.6 * entry.value, status="weak", prior=wide)
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
    drives[2] = _said(
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
