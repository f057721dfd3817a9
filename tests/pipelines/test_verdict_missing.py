"""Why nobody gave a parameter: by what the log lacks, and not by what it has."""

from __future__ import annotations

import pytest

from parsers.drive import ImportRecord
from pipelines.limits import what_limits
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.combine import verdict_of
from pipelines.verdict.missing import why_nobody
from tests.reports.sample_results import record

TORQUES = ("speed", "road_grade", "drive_torque", "brake_torque")


@pytest.mark.parametrize(
    ("name", "signals", "words"),
    [
        ("mass_kg", TORQUES, "it needs longitudinal acceleration beside the drive torque and brake torque that the log has, or axle loads, or suspension forces"),
        ("mass_kg", ("speed",), "it needs axle loads, or suspension forces, or longitudinal acceleration with drive and brake torques"),
        ("mass_kg", ("accel_x",), "it needs drive torque and brake torque beside the longitudinal acceleration that the log has, or"),
        ("cg_to_front_axle_m", ("suspension_deflection_fl",), "it needs the vehicle file's wheelbase and spring rates beside the suspension deflections that the log has, or axle loads"),
        ("roll_gradient_degpg", ("roll",), "it needs lateral acceleration beside the roll or roll rate that the log has"),
        ("roll_gradient_degpg", ("roll", "accel_y"), "it needs lateral acceleration and roll (or roll rate) while cornering"),
        ("drag_area_m2", (), "the signals for it are not there"),
    ],
)  # fmt: skip
def test_what_is_missing_is_named(name: str, signals: tuple[str, ...], words: str) -> None:
    assert why_nobody(name, [], signals).startswith(f"no estimator gave it: {words}")


def test_a_reason_does_not_list_all_that_did_not_run() -> None:
    skipped = [Estimate(f"method_{i}", "skipped", "lacks x" + "; y" * i) for i in range(9)]
    reason = why_nobody("mass_kg", skipped)
    assert "method_3" in reason
    assert "method_4" not in reason
    assert reason.endswith("5 more did not run: see each estimator's own reason")


def test_the_verdict_says_it() -> None:
    verdict = verdict_of([], Vehicle(), signals=TORQUES).parameters
    assert "longitudinal acceleration beside the drive torque" in verdict["mass_kg"].reason


def test_the_method_that_lacks_least_comes_first() -> None:
    far = Estimate("roll_map", "skipped", "lacks accel_y (a); roll (b)")
    near = Estimate("brake_roll_batch", "skipped", "lacks accel_x (c)")
    reason = why_nobody("mass_kg", [far, near])
    assert reason.index("brake_roll_batch") < reason.index("roll_map")
    log: ImportRecord = record()  # type: ignore[no-untyped-call]
    limits = what_limits(log, [far, near], {}, Vehicle())
    assert "For example, brake_roll_batch lacks accel_x (c)." in limits
