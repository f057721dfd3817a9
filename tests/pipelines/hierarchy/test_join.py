"""Which drives go together, in what order, and where their relations are made linear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.join import CURVED, Joined, joined, usable
from pipelines.hierarchy.parts import agreed
from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.relinear import at_place
from pipelines.hierarchy.shared import MOST, belongs, own_shares
from pipelines.hierarchy.vehicle import drive_notes_of
from pipelines.joint.kept import KeptRelations
from tests.pipelines.hierarchy.linear_fleet import MEAN, NAMES, STD, draw, slopes, told

RHO = 0.5


def fleet(seed: int, count: int) -> list[DriveTold]:
    """Drives that all see the same of one vehicle."""
    rng = np.random.default_rng(seed)
    return told(draw(rng, count, RHO, [3 * slopes(rng)] * count).kept)


def moved(drive: DriveTold, name: str, size: float) -> DriveTold:
    """The same drive of a vehicle in which one unknown is another by so many standard deviations."""
    kept = drive.kept
    assert kept is not None
    column = NAMES.index(name)
    return replace(
        drive, kept=replace(kept, observed=kept.observed + kept.rows[:, column] * size * STD[column])
    )


def springs(found: Joined, drive_id: str) -> float:
    posterior = found.posterior
    assert posterior is not None
    return float((posterior.mean(posterior.drives.index(drive_id))[0] - MEAN[0]) / STD[0])


def test_drives_that_agree_are_all_joined() -> None:
    left = [joined(fleet(seed, 8), RHO).left_out for seed in range(20)]
    assert not any(left)


def test_poisoned_drive_does_not_move_the_others() -> None:
    drives = fleet(3, 8)
    without = joined([d for d in drives if d.drive_id != "d04"], RHO)
    drives[4] = moved(drives[4], "spring_front", 25.0)
    found = joined(drives, RHO)
    assert set(found.left_out) == {"d04"}
    assert found.left_out["d04"].log_probability < np.log(1e-6)
    for name in ("d00", "d07"):
        assert springs(found, name) == pytest.approx(springs(without, name), abs=1e-6)


def test_drive_somewhat_off_counts_less() -> None:
    drives = fleet(5, 8)
    drives[4] = moved(drives[4], "stuck_fl", 9.0)
    found = joined(drives, RHO)
    assert found.posterior is not None
    assert "d04" in found.widened or "d04" in found.left_out


def test_drive_with_other_sensors_stays_and_says_so() -> None:
    drives = []
    for drive in fleet(3, 8):
        assert drive.kept is not None
        names = tuple("scale_fl" if name == "somebody_else" else name for name in NAMES)
        drives.append(replace(drive, kept=replace(drive.kept, names=names)))
    calm = joined(drives)
    assert not calm.other_sensors
    column = NAMES.index("somebody_else")
    kept = drives[4].kept
    assert kept is not None
    drives[4] = replace(
        drives[4], kept=replace(kept, observed=kept.observed + kept.rows[:, column] * 4.5 * STD[column])
    )
    found = joined(drives)
    assert set(found.other_sensors) == {"d04"}
    assert not found.left_out
    assert found.posterior is not None
    assert "d04" in found.posterior.drives
    assert any("other sensors" in note for note in drive_notes_of(found)["d04"])


def test_two_that_contradict_each_other_stay_apart() -> None:
    drives = fleet(3, 2)
    drives[1] = moved(drives[1], "spring_front", 25.0)
    found = joined(drives, RHO)
    assert found.apart
    assert found.posterior is None


def test_no_majority_no_join() -> None:
    drives = fleet(3, 6)
    drives = [*drives[:3], *(moved(d, "spring_front", 30.0) for d in drives[3:])]
    assert joined(drives, RHO).apart


def test_order_of_the_input_changes_nothing() -> None:
    drives = fleet(7, 6)
    drives[2] = replace(drives[2], start_utc=None)
    one, other = joined(drives, RHO), joined(drives[::-1], RHO)
    assert [d.drive_id for d in one.drives] == [d.drive_id for d in other.drives]
    assert one.drives[-1].drive_id == "d02"
    assert one.posterior is not None
    assert other.posterior is not None
    assert np.array_equal(one.posterior.s, other.posterior.s)
    assert np.array_equal(one.posterior.s_covariance, other.posterior.s_covariance)


def test_times_with_and_without_zone_are_compared_as_times() -> None:
    drives = fleet(8, 2)
    drives = [
        replace(drives[0], start_utc="2024-01-01T08:00:00+02:00"),
        replace(drives[1], start_utc="2024-01-01T07:00:00"),
    ]
    assert [d.drive_id for d in joined(drives, RHO).drives] == ["d00", "d01"]


def test_drives_that_told_nothing_stay_out() -> None:
    drives = fleet(9, 3)
    kept = drives[1].kept
    assert kept is not None
    drives[1] = replace(drives[1], kept=None)
    stated = replace(kept, source=("vehicle file",) * len(kept.rows))
    broken = replace(kept, observed=np.full(len(kept.rows), np.nan))
    assert not usable(drives[1])
    assert not usable(replace(drives[1], kept=stated))
    assert not usable(replace(drives[1], kept=broken))
    found = joined(drives, RHO)
    assert found.posterior is not None
    assert found.posterior.drives == ("d00", "d02")


def test_misfit_of_a_drive_makes_it_count_less() -> None:
    drives = fleet(10, 3)
    kept = drives[0].kept
    assert kept is not None
    drives[0] = replace(drives[0], kept=replace(kept, inflation=1.5))
    other = drives[2].kept
    assert other is not None
    drives[2] = replace(drives[2], kept=replace(other, normal=False))
    found = joined(drives, RHO)
    assert [s.factor for s in found.sources] == [1.5, 1.0, CURVED]


def moments(load: float, height: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([load, load * height])


def test_relations_of_the_loads_moment_are_made_linear_exactly() -> None:
    names = ("load", "load_x", "load_y", "load_h")
    mode, place = np.array([100.0, 1.0, 0.0, 0.8]), np.array([160.0, 1.5, 0.1, 1.4])
    # figures: load and load x load_h, linear about the mode
    rows = np.array([[1.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 100.0]])
    observed = rows @ mode + (np.array([150.0, 190.0]) - moments(100.0, 0.8))
    there, figures = at_place(names, rows, observed, mode, place)
    np.testing.assert_allclose(there[1], [1.4, 0.0, 0.0, 160.0])
    np.testing.assert_allclose(figures - there @ place, np.array([150.0, 190.0]) - moments(160.0, 1.4))
    same, as_before = at_place(names, rows, observed, mode, mode)
    np.testing.assert_allclose(same, rows)
    np.testing.assert_allclose(as_before, observed)


def test_relations_without_a_load_stay_as_they_are() -> None:
    rows = np.ones((2, 1))
    assert at_place(("spring_front",), rows, np.ones(2), np.ones(1), np.zeros(1))[0] is rows


def test_every_unknown_belongs_to_somebody() -> None:
    from pipelines.hierarchy.shared import UNKNOWN
    from pipelines.joint.vehicle.unknowns import before_the_log
    from tests.pipelines.joint_parts import vehicle

    known = before_the_log(vehicle())
    assert [name for name in known.names if belongs(name) is UNKNOWN] == []
    shares = own_shares(known.names, known.mean, known.std)
    assert np.all((shares >= 0) & (shares <= 1))
    own = dict(zip(known.names, shares.tolist(), strict=True))
    assert own["spring_front"] == own["empty_h"] == own["roll_center_rear"] == 0.0
    assert own["pitch_wound_"[:-1]] == 1.0
    assert 0 < own["tyre_rate"] <= MOST
    assert belongs("named_by_nobody") is UNKNOWN


def test_a_drive_alone_is_as_it_was() -> None:
    drives = fleet(11, 1)
    kept = drives[0].kept
    assert isinstance(kept, KeptRelations)
    posterior = joined(drives, RHO).posterior
    assert posterior is not None
    covariance = np.linalg.inv(np.diag(1 / STD**2) + kept.rows.T @ kept.rows)
    np.testing.assert_allclose(
        posterior.covariance(0) / np.outer(STD, STD), covariance / np.outer(STD, STD), atol=1e-10
    )


def test_files_of_which_none_is_most_drives_are_both_possible() -> None:
    """Which of two drives' vehicle files is wrong nothing tells, and not that the earlier one came first."""
    rng = np.random.default_rng(3)
    first, second = draw(rng, 2, 0.0).kept
    lighter = replace(second, mean=second.mean + np.array([3e3, 0, 0, 0, 0, 0]))
    for order in ((first, lighter), (lighter, first)):
        mean, std = agreed(order)["spring_front"]
        assert mean == pytest.approx(31.5e3)
        assert std == pytest.approx(np.hypot(900.0, 1.5e3))
        assert agreed(order)["empty_h"] == (0.6, 0.03)
    # of three the two that say the same are believed, in any order
    assert agreed((lighter, first, first))["spring_front"] == (30e3, 900.0)
    assert agreed((first, lighter, replace(first, mean=first.mean + 6e3)))["spring_front"][
        0
    ] == pytest.approx(33e3)
