"""Deflections that were zeroed under the load: found where all four begin at nought, and then no load is taken from them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from loaded_drive import LOADED, loaded_drive
from loaded_drive import told as told_by
from plant_balance import vehicle_file

from parsers.drive import Drive
from parsers.errors import VehicleError
from pipelines.joint.vehicle.unknowns import CORNERS, before_the_log
from pipelines.limits import what_limits
from pipelines.prepare.deflection_zero import NAMES, NOUGHT_M, begins_at_zero, with_zero_open
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle


@pytest.fixture(scope="module")
def driven() -> Drive:
    return loaded_drive()


def _moved(drive: Drive, metres: dict[str, float]) -> Drive:
    """Deflections with another zero: less what each is given."""
    signals = dict(drive.signals)
    for name, zero in metres.items():
        signals[name] = replace(signals[name], values=signals[name].values - zero)
    return replace(drive, signals=signals)


def _zeroed(drive: Drive, left_m: float = 0.0) -> Drive:
    """As if each sensor had been set to nought (or to left_m) in the drive's first second."""
    first = {n: drive.signals[n].time_ns <= drive.signals[n].time_ns[0] + 10**9 for n in NAMES}
    return _moved(drive, {n: float(drive.signals[n].values[first[n]].mean()) - left_m for n in NAMES})


def test_only_four_wheels_at_nought_are_taken_so(driven: Drive) -> None:
    assert begins_at_zero(driven) is None
    assert begins_at_zero(_zeroed(driven)) == pytest.approx(0.0, abs=1.5e-4)
    assert begins_at_zero(_zeroed(driven, 0.6 * NOUGHT_M)) == pytest.approx(0.6 * NOUGHT_M, abs=1.5e-4)
    assert begins_at_zero(_zeroed(driven, 1.4 * NOUGHT_M)) is None
    assert begins_at_zero(_moved(_zeroed(driven), {NAMES[2]: 0.002})) is None
    three = {n: s for n, s in driven.signals.items() if n != NAMES[0]}
    assert begins_at_zero(replace(driven, signals=three)) is None


@pytest.mark.parametrize(("above_m", "said"), [(0.008, True), (0.004, False)])
def test_a_body_that_stands_above_zero_was_zeroed_under_another_load(
    driven: Drive, above_m: float, said: bool
) -> None:
    """No load is less than nothing; a blind simulator's hatchback so zeroed had its CG 4 % of the wheelbase off at 7.6 standard deviations."""
    mean = float(np.mean([np.median(driven.signals[name].values) for name in NAMES]))
    high = _moved(driven, dict.fromkeys(NAMES, mean + above_m))
    _, opened = with_zero_open(high, Vehicle())
    assert (opened.deflection_zero == "loaded") is said
    found, _ = with_zero_open(high, replace(Vehicle(), deflection_zero="empty"))
    assert found is high
    if said:
        (decision,) = with_zero_open(high, Vehicle())[0].record.decisions
        assert "stand higher than where they are zero" in decision.found
        assert decision.evidence.startswith("8 mm")


def test_a_body_that_still_rocks_at_first_hides_nothing(driven: Drive) -> None:
    """A log that begins a second after the doors: what it stands at until it drives off counts, and not its first second."""
    drive, wait = _zeroed(driven), 20 * 10**9
    stands = drive.start_ns + np.arange(0, wait, 10**8)
    rocks = 0.002 * np.exp(-np.arange(0, 20, 0.1))
    signals = {}
    for name, signal in drive.signals.items():
        held = rocks if name in NAMES else np.full(len(stands), 0.0 if name == "speed" else signal.values[0])
        time, values = np.append(stands, signal.time_ns + wait), np.append(held, signal.values)
        signals[name] = replace(signal, time_ns=time, values=values)
    assert begins_at_zero(replace(drive, signals=signals)) == pytest.approx(0.0, abs=2e-4)


def test_it_is_said_and_the_vehicle_file_decides(driven: Drive) -> None:
    drive, vehicle = with_zero_open(_zeroed(driven), Vehicle())
    assert vehicle.deflection_zero == "loaded"
    (said,) = [d for d in drive.record.decisions if d.kind == "zero"]
    assert "begin at zero" in said.found
    assert any("deflection_zero" in words for words in what_limits(drive.record, [], {}, vehicle))
    for stated in ("empty", "loaded"):
        told = replace(Vehicle(), deflection_zero=stated)
        drive, kept = with_zero_open(_zeroed(driven), told)
        assert kept is told
        assert not drive.record.decisions
    assert with_zero_open(driven, Vehicle()) == (driven, Vehicle())


def test_a_load_that_was_zeroed_away_is_in_the_intervals(driven: Drive) -> None:
    """300 kg in the boot: taken for empty they are 7 % of mass and 9 cm of the place, at tens of standard deviations."""
    truth, file = LOADED.truth(), vehicle_file(LOADED, None)
    drive, opened = with_zero_open(_zeroed(driven), file)
    answers, before = told_by(drive, opened), told_by(_zeroed(driven), replace(file, deflection_zero="empty"))

    def off(found: ParameterEstimate) -> float:
        assert found.value is not None
        assert found.std is not None
        return abs(found.value - truth[found.name]) / found.std

    for name in ("mass_kg", "cg_to_front_axle_m", "cg_height_m"):
        assert off(answers[name]) < 3, name
    assert max(off(before[name]) for name in ("mass_kg", "cg_to_front_axle_m")) > 4


def test_the_zero_is_as_open_as_a_load_is() -> None:
    file = vehicle_file(LOADED, None)
    closed, opened = before_the_log(file), before_the_log(replace(file, deflection_zero="loaded"))
    for wheel in CORNERS:
        row = closed.index(f"zero_{wheel}")
        assert opened.std[row] > 10 * closed.std[row]


def test_the_vehicle_file_states_it(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text('[vehicle]\ndeflection_zero = "loaded"\n')
    assert read_vehicle(path).deflection_zero == "loaded"
    path.write_text('[vehicle]\ndeflection_zero = "full"\n')
    with pytest.raises(VehicleError, match="deflection_zero"):
        read_vehicle(path)
