"""A trailer: torques that move more than the springs carry, found by all else and joined with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_balance.along import along_terms
from pipelines.estimators.load_balance.relations import pitch_moments
from pipelines.evidence import Evidence
from pipelines.joint.doubts.carried import LEVELS
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import Reached, reach
from pipelines.joint.vehicle.unknowns import CORNERS, TOWED, TRAILER_DRAG_M2, before_the_log, body_of
from pipelines.joint.ways.towed import CHANCE, MASS, NAME, towed_ways
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.vehicle import Quantity, Vehicle
from tests.pipelines import joint_parts
from tests.pipelines.joint_parts import told_height

SUV = told_height(joint_parts.vehicle())
KNOWN = before_the_log(SUV)
KILOS = float(KNOWN.mean[KNOWN.index("empty_mass")])
LOAD = 100.0


def linear(rows: dict[str, float], observed: float, std: float, carrier: str) -> Evidence:
    """Signals of their own, that no other relation has."""
    return replace(joint_parts.linear(rows, observed, std, carrier), carrier=carrier)


def _drive(trailer: float, push: float | None = None) -> list[Evidence]:
    """A log whose load is weighed twice, and whose torques move a trailer too, each with a scale of its own."""
    braked = trailer if push is None else push
    return [
        linear({"load": 1.0}, LOAD, 8.0, "scales"),
        linear({"load": 1.0, "empty_mass": 1.0}, KILOS + LOAD, 12.0, "a weighbridge"),
        linear(
            {"load": 1.0, "empty_mass": 1.0, TOWED: 1.0, "drive_scale": -KILOS},
            LOAD + trailer, 25.0, "drive",
        ),
        linear(
            {"load": 1.0, "empty_mass": 1.0, TOWED: 1.0, "brake_scale": -KILOS},
            LOAD + braked, 25.0, "brakes",
        ),
    ]  # fmt: skip


def _reached(evidence: list[Evidence]) -> Reached:
    found = reach(evidence, SUV, np.random.default_rng(0))
    assert found is not None
    return found


def _told(found: Reached, name: str) -> tuple[float, float]:
    row = found.joint.known.index(name)
    mean, std = found.joint.known.mean[row], found.joint.known.std[row]
    return float(mean + std * found.joint.u[row]), float(std * np.sqrt(found.joint.covariance[row, row]))


def test_what_is_towed_is_found_and_takes_nothing_with_it() -> None:
    trailer = 700.0
    found = _reached(_drive(trailer))
    assert found.found[0].startswith(NAME)
    mass, spread = _told(found, TOWED)
    assert abs(mass - trailer) < 2.5 * spread
    assert f"{mass:.0f} ± {spread:.0f} kg more" in found.found[0]
    load, spread = _told(found, "load")
    assert abs(load - LOAD) < 2 * spread


def test_none_is_asked_for_where_nothing_contradicts() -> None:
    found = _reached(_drive(0.0))
    assert found.found == ()
    assert _told(found, TOWED)[1] <= 1.0


def test_a_torque_that_is_wrong_alone_is_no_trailer() -> None:
    found = _reached(_drive(0.0, push=-0.4 * KILOS))
    assert found.found[0].startswith("brake torque of a wrong scale")


def test_torques_alone_that_move_a_rare_load_may_tow_it() -> None:
    """Nothing contradicts a load of 45 % of the car: it is rarer than a trailer is, and the answers hold both. Usual loads ask for none."""
    usual = before_the_log(SUV)
    row = usual.index("load")
    torques = {"load": 1.0, "empty_mass": 1.0, TOWED: 1.0, "drive_scale": -KILOS}
    for load, asked in ((float(usual.mean[row]) + 4.5 * float(usual.std[row]), True), (LOAD, False)):
        found = _reached([linear(torques, load, 0.02 * KILOS, "drive")])
        assert any(text.startswith(NAME) for text in found.found) == asked


def test_odds_are_those_of_two_integrals() -> None:
    """One figure of the trailer under two priors, exactly; it has nothing to do with the drag."""
    seen, std = 0.5 * KILOS, 40.0
    evidence = [linear({TOWED: 1.0}, seen, std, "made up")]
    ((odds, joint, free),) = towed_ways(find_mode(evidence, KNOWN), evidence, KNOWN, SUV)

    def log_density(mean: float, spread: float) -> float:
        variance = spread**2 + std**2
        return float(-0.5 * (seen - mean) ** 2 / variance - 0.5 * np.log(variance))

    chance = CHANCE["car"]
    exact = log_density(MASS[0] * KILOS, MASS[1] * KILOS) - log_density(0.0, 1.0)
    assert odds == pytest.approx(exact + np.log(chance / (1 - chance)), abs=1e-3)
    assert free.mean[free.index("drag")] == pytest.approx(
        KNOWN.mean[KNOWN.index("drag")] + TRAILER_DRAG_M2[0]
    )
    assert joint.converged


@pytest.mark.parametrize("apart", [2000.0, 3000.0])
def test_springs_that_level_themselves_stay_beside_it(apart: float) -> None:
    """A lorry whose torques move more than its springs show, by little and by much: both explain it, and the answers hold both."""
    lorry = told_height(replace(joint_parts.vehicle(mass_kg=(9000.0, 90.0)), body=None))
    wheels = {f"zero_{wheel}": -1 / GRAVITY for wheel in CORNERS}
    found = reach(
        [
            linear({"load": 1.0, **wheels}, 500.0, 600.0, "springs"),
            linear({"load": 1.0, "empty_mass": 1.0, TOWED: 1.0}, 9500.0 + apart, 300.0, "torques"),
        ],
        lorry,
        np.random.default_rng(0),
    )
    assert found is not None
    for name in (LEVELS, NAME):
        assert any(text.startswith(f"{name} (odds") for text in found.found)
    assert len(found.others) >= 2


def _stated(kilos: float) -> Vehicle:
    return replace(SUV, trailer={"mass_kg": Quantity(kilos, 20.0, "vehicle file")})


def test_one_that_the_file_states_is_taken_and_a_denied_one_not_asked_for() -> None:
    towing, alone = before_the_log(_stated(700.0)), before_the_log(_stated(0.0))
    assert towing.names == alone.names == KNOWN.names
    assert float(towing.mean[towing.index(TOWED)]) == 700.0
    assert float(towing.std[towing.index(TOWED)]) == 20.0
    drag = [float(each.mean[each.index("drag")]) for each in (KNOWN, alone, towing)]
    assert drag[1] == drag[0] == pytest.approx(drag[2] - TRAILER_DRAG_M2[0])
    evidence = _drive(700.0)
    assert not [*towed_ways(find_mode(evidence, alone), evidence, alone, _stated(0.0))]
    found = reach(evidence, _stated(700.0), np.random.default_rng(0))
    assert found is not None
    assert found.found == ()


def test_it_goes_along_the_road_and_pulls_at_the_hitch() -> None:
    p = KNOWN.at(np.zeros(len(KNOWN.names))) | {"pushes": 0.5, "hitch": 0.4}
    with_it = p | {TOWED: 600.0}
    mass = body_of(p, None).mass
    alone, towing = (along_terms(None, True, True, False, 1.0, False, False)(each) for each in (p, with_it))
    assert towing["fx_drive"] / alone["fx_drive"] == pytest.approx((mass + 600.0) / mass)
    assert towing["fx_brake"] / alone["fx_brake"] == pytest.approx((mass + 300.0) / mass)
    level, pulled = (pitch_moments("tyre", each, body_of(each, None)) for each in (p, with_it))
    assert pulled["fx_drive"] - level["fx_drive"] == pytest.approx(600.0 * 0.4, rel=0.05)
    assert pulled["fx_brake"] - level["fx_brake"] == pytest.approx(300.0 * 0.4, rel=0.05)
