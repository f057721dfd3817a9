"""What brake_roll_batch and load_transfer_batch hand to the joint posterior: their own answers again where priors are alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from true_unknowns import joined, random_drive

from pipelines.estimators.base import Estimator
from pipelines.estimators.brake_roll.estimator import BrakeRollBatch
from pipelines.estimators.load_transfer.companion import LoadTransferBatch
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.results import Estimate
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import SimulatedLog
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

Output = Callable[[Mapping[str, float]], float]


def axis(values: Mapping[str, float]) -> float:
    share = body_of(values, None).x / values["wheelbase"]
    return (1 - share) * values["roll_center_front"] + share * values["roll_center_rear"]


OUTPUTS: dict[str, Output] = {
    "mass_kg": lambda v: body_of(v, None).mass,
    "sprung_mass_kg": lambda v: body_of(v, None).sprung,
    "cg_to_front_axle_m": lambda v: body_of(v, None).whole_x,
    "cg_lateral_offset_m": lambda v: body_of(v, None).whole_y,
    "roll_arm_m": lambda v: body_of(v, None).h - axis(v),
    "pitch_arm_m": lambda v: body_of(v, None).h - v["pitch_center_brake"],
}


def run(estimator: Estimator, made: SimulatedLog, vehicle: Vehicle) -> Estimate:
    prepared = estimator.prepare(drive_of(made.log), {})
    return estimator.estimate(prepared, vehicle, {}, np.random.default_rng(0))


def loose(made: SimulatedLog, **stated: float) -> Vehicle:
    """The drive's file with masses, place and height hardly known, but for `stated`, and no load."""
    file = parse_vehicle(made.sheet, Path("vehicle.toml"))
    truth = made.run.truth
    wide = {
        "mass_kg": Quantity(truth["mass_kg"], 0.3 * truth["mass_kg"], "test"),
        "cg_to_front_axle_m": Quantity(truth["cg_to_front_axle_m"], 0.5, "test"),
        "cg_height_m": Quantity(truth["cg_height_m"], 0.5, "test"),
    }
    tight = {n: replace(file.quantities[n], std=std) for n, std in stated.items()}
    nothing = {"mass_kg": Quantity(0.0, 0.01, "test")}
    return replace(file, quantities={**file.quantities, **wide, **tight}, load=nothing)


@pytest.fixture(scope="module", name="stops")
def _stops() -> SimulatedLog:
    return random_drive(0, ("launch_and_stop",), ("suv",), "ins")


def test_torques_give_back_the_mass(stops: SimulatedLog) -> None:
    file = loose(stops)
    found = run(BrakeRollBatch(), stops, file)
    assert ("longitudinal", "torques") in {(e.kind, e.carrier) for e in found.evidence}
    own = found.parameters["mass_kg"]
    assert own.value is not None
    assert own.std is not None
    torques = [e for e in found.evidence if e.carrier == "torques"]
    value, std = joined(before_the_log(file), torques).of(OUTPUTS["mass_kg"])
    assert abs(value - own.value) < 0.5 * own.std
    assert std == pytest.approx(own.std, rel=0.35)


def test_a_torque_that_the_log_lacks_has_no_scale(stops: SimulatedLog) -> None:
    whole, file = drive_of(stops.log), loose(stops)
    known = before_the_log(file)
    for kind, other in (("drive", "brake"), ("brake", "drive")):
        lacking = {
            n: s for n, s in whole.signals.items() if not n.startswith((f"{kind}_torque", "brake_pressure"))
        }
        prepared = BrakeRollBatch().prepare(replace(whole, signals=lacking), {})
        found = BrakeRollBatch().estimate(prepared, file, {}, np.random.default_rng(0))
        (torques,) = [e for e in found.evidence if e.carrier == "torques"]
        assert f"{kind}_scale" not in torques.unknowns
        assert f"{other}_scale" in torques.unknowns
        own = {each.name: each.mean for each in torques.own}
        assert np.isfinite(torques.predict(known.at(np.zeros(len(known.names))) | own)).all()


def test_torque_scales_that_nobody_knows_leave_no_mass(stops: SimulatedLog) -> None:
    file = loose(stops)
    known = before_the_log(file)
    torques = [e for e in run(BrakeRollBatch(), stops, file).evidence if e.carrier == "torques"]
    names = np.array(known.names)
    unknown = replace(
        known, std=np.where(np.isin(names, ["brake_scale", "drive_scale", "brake_gain"]), 10.0, known.std)
    )
    assert (
        joined(unknown, torques).of(OUTPUTS["mass_kg"])[1] > 0.9 * joined(known, ()).of(OUTPUTS["mass_kg"])[1]
    )


def test_slips_with_the_files_place_give_back_their_height(stops: SimulatedLog) -> None:
    file = parse_vehicle(stops.sheet, Path("vehicle.toml"))
    empty = {"mass_kg": Quantity(0.0, 0.01, "test")}
    # a height that is not known and a load that is told: what is left is the place of the data sheet
    file = replace(
        file, quantities={**file.quantities, "cg_height_m": Quantity(0.7, 5.0, "test")}, load=empty
    )
    found = run(BrakeRollBatch(), stops, file)
    slips = [e for e in found.evidence if e.carrier == "wheel slips"]
    value, std = joined(before_the_log(file), slips).of(lambda v: body_of(v, None).whole_h)
    own, spread = found.diagnostics["slip_height_m"], found.diagnostics["slip_height_std_m"]
    assert abs(value - own) < 0.3 * spread
    assert std == pytest.approx(spread, rel=0.25)


def test_struts_give_back_what_they_carry_and_their_arms() -> None:
    made = random_drive(0, ("rural",), ("suv",), "struts")
    file = loose(made)
    file = replace(
        file, quantities={**file.quantities, "pitch_center_height_m": replace(file.quantities["pitch_center_height_m"], std=0.002)}
    )  # fmt: skip
    found = run(LoadTransferBatch(), made, file)
    assert [e.kind for e in found.evidence] == ["vertical", "pitch", "roll"]
    assert {e.carrier for e in found.evidence} == {"suspension forces"}
    known = before_the_log(file)
    # nothing is known of the lateral place either
    known = replace(known, std=np.where(np.array(known.names) == "empty_y", 0.3, known.std))
    posterior = joined(known, found.evidence)
    for name in OUTPUTS:
        own = found.parameters[name]
        assert own.value is not None
        assert own.std is not None
        value, std = posterior.of(OUTPUTS[name])
        # the joint leaves open about which height the body pitches, and expects tyres to give sideways
        near = {"pitch_arm_m": 1.5, "roll_arm_m": 1.0}.get(name, 0.7)
        assert abs(value - own.value) < near * max(own.std, std), name
        assert 0.3 * own.std < std < 2.5 * own.std, name
