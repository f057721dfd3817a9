"""What answers hang on in the vehicle file, said once for all of them: a reason that a first screen cuts must not take it away."""

from __future__ import annotations

from parsers.drive import ImportRecord
from pipelines.file_limits import HANGING
from pipelines.joint.rests import OF_PART, OF_RATE, hanging_on, moved_by
from pipelines.limits import what_limits
from pipelines.results import Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

RECORD = ImportRecord("CSV table", (), "0", "complete", 1, {}, (), "clock", None, 10.0, ())


def _entry(name: str, reason: str, status: Identification = "identified") -> ParameterEstimate:
    return ParameterEstimate(name, 1.0, 0.1, 0.8, 1.2, status, f"from balances; {reason}")


def test_figures_of_the_file_that_a_drive_hardly_checks_are_named_once() -> None:
    place, rate = OF_PART.format("cg_to_front_axle_m"), OF_RATE.format("spring_rate_rear_npm", "60")
    verdict = {
        e.name: e
        for e in (
            _entry("mass_kg", f"{OF_PART.format('mass_kg')}; {rate}"),
            _entry("cg_to_front_axle_m", place),
            _entry("corner_mass_fl_kg", place),
            _entry("corner_mass_fr_kg", place, "weak"),
            _entry("cg_height_m", OF_PART.format("cg_height_m"), "not_identifiable"),
            _entry("roll_arm_m", "nothing else"),
        )
    }
    assert hanging_on(verdict) == {
        "mass_kg": ["mass_kg"],
        "cg_to_front_axle_m": ["cg_to_front_axle_m", "corner_mass_fl_kg", "corner_mass_fr_kg"],
    }
    assert moved_by(verdict) == {"spring_rate_rear_npm": {"mass_kg": "60"}}
    (told,) = [text for text in what_limits(RECORD, (), verdict, Vehicle()) if text.startswith(HANGING)]
    assert told == (
        f"{HANGING} mass_kg (mass), cg_to_front_axle_m (CG to front axle, corner masses) and spring_rate_rear_npm (10 % off would "
        "move mass by 60 kg): if one is wrong, so is what hangs on it."
    )


def test_where_the_drive_checks_all_nothing_is_said() -> None:
    verdict = {"mass_kg": _entry("mass_kg", "all relations alike")}
    assert not any(text.startswith(HANGING) for text in what_limits(RECORD, (), verdict, Vehicle()))
