"""What a kinematics rig tells in a vehicle file: springs' curves, bump stops, roll centres' drop, the ways of patches and hubs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.errors import VehicleError
from pipelines.estimators.roll_map.touched_stops import stops_touched, with_stops
from pipelines.joint.next_measurement import CANDIDATES
from pipelines.joint.vehicle.laden import pressed, rate_under_load, roll_center
from pipelines.joint.vehicle.poles import past_the_springs
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import ParameterEstimate
from pipelines.vehicles.kinematics import TRAVEL_M, free_travel, spring_curve
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

SHEET = """[vehicle]
mass_kg = {value = 1600, std = 10}
wheelbase_m = 2.7
cg_to_front_axle_m = 1.2
spring_rate_front_npm = {value = 25000, std = 500}
spring_rate_rear_npm = {value = 27000, std = 540}
roll_center_height_front_m = 0.08
roll_center_height_rear_m = 0.12
tire_vertical_rate_npm = 240000
"""
CURVE = """spring_rate_rear_bump_npm = {value = 33000, std = 300}
spring_rate_rear_rebound_npm = {value = 26000, std = 300}
"""


def parsed(more: str = "") -> Vehicle:
    return parse_vehicle(SHEET + more, Path("vehicle.toml"))


def row(vehicle: Vehicle, name: str) -> tuple[float, float]:
    known = before_the_log(vehicle)
    i = known.index(name)
    return float(known.mean[i]), float(known.std[i])


def at_mean(known: Known) -> dict[str, float]:
    return {**known.at(np.zeros(len(known.names)))}


def test_three_rates_give_back_the_curve_that_they_are_of() -> None:
    k, q, c = 27000.0, 60000.0, 400000.0
    rates = [k + 2 * q * d + 3 * c * d * d for d in (TRAVEL_M, -TRAVEL_M)]
    text = f"spring_rate_rear_bump_npm = {rates[0]}\nspring_rate_rear_rebound_npm = {rates[1]}\n"
    found = spring_curve(parsed(text).quantities, "rear")
    assert found is not None
    (square, _), (cube, _) = found
    assert (square, cube) == (pytest.approx(q), pytest.approx(c))
    assert spring_curve(parsed(text).quantities, "front") is None


def test_a_rate_that_grows_much_both_ways_may_have_a_kink_between() -> None:
    """With a kink at ride height the rate half-way up grows by half of what it does at the end; the cubic through the ends has a quarter."""

    def spreads(*over: float) -> tuple[float, float]:
        ends = (27000.0 * x for x in over)
        text = "".join(
            f"spring_rate_rear_{end}_npm = {rate}\n"
            for end, rate in zip(("bump", "rebound"), ends, strict=True)
        )
        found = spring_curve(parsed(text).quantities, "rear")
        assert found is not None
        return found[0][1], found[1][1]

    plain, one_way, both = spreads(1.06, 1.06), spreads(1.3, 0.7), spreads(1.3, 1.3)
    assert one_way == pytest.approx(plain, rel=0.1)
    # what the cube may be off by at half the travel, against half of what a kink and the cubic differ by there
    half = 3 * both[1] * (0.5 * TRAVEL_M) ** 2
    assert half > 0.25 * 0.5 * (0.5 - 0.25) * 0.3 * 27000.0
    assert both[0] > 3 * plain[0]
    assert both[1] > 3 * plain[1]


@pytest.mark.parametrize("grows", [0.2, 0.3, 0.5])
def test_the_rate_under_a_load_holds_a_kink(grows: float) -> None:
    """With a kink the rate half-way up is a quarter of the growth above the cubic's: within two spreads, whatever is usual."""
    ends = "".join(f"spring_rate_rear_{end}_npm = {(1 + grows) * 27000}\n" for end in ("bump", "rebound"))
    vehicle = parsed(ends)
    at = 0.5 * TRAVEL_M
    (square, q), (cube, c) = row(vehicle, "square_rear"), row(vehicle, "cube_rear")
    away = 27000.0 * grows * at / TRAVEL_M - (2 * square * at + 3 * cube * at**2)
    assert away == pytest.approx(0.25 * grows * 27000.0)
    assert away < 2 * float(np.hypot(2 * q * at, 3 * c * at**2))


def test_the_curve_is_surer_than_usual_and_the_rate_under_load_follows_it() -> None:
    silent, told = parsed(), parsed(CURVE)
    for name in ("square_rear", "cube_rear"):
        assert row(told, name)[1] < 0.4 * row(silent, name)[1]
    assert row(told, "square_front") == row(silent, "square_front")
    # a load that presses the rear springs by as much as the rig did
    p = at_mean(before_the_log(told)) | {"load_x": 2.7}
    load = 2 * (27000.0 + (p["square_rear"] + p["cube_rear"] * TRAVEL_M) * TRAVEL_M) * TRAVEL_M / 9.80665
    p = p | {"load": load}
    assert float(pressed(p, "rear")) == pytest.approx(TRAVEL_M)
    assert float(rate_under_load(p, "rear")) == pytest.approx(33000.0, rel=0.01)


def test_rear_leaves_of_carriers_may_double_their_rate() -> None:
    """Of two stages; cars' rear springs, and front ones, do not."""
    pickup, car = (parsed(f'body = "{body}"\n') for body in ("Pickup", "Sedan"))
    rises = [
        2 * row(v, "square_rear")[0] * TRAVEL_M + 3 * row(v, "cube_rear")[0] * TRAVEL_M**2
        for v in (pickup, car)
    ]
    rates = [at_mean(before_the_log(v))["spring_rear"] for v in (pickup, car)]
    spreads = [
        np.hypot(2 * row(v, "square_rear")[1] * TRAVEL_M, 3 * row(v, "cube_rear")[1] * TRAVEL_M**2)
        for v in (pickup, car)
    ]
    assert rises[0] / rates[0] == pytest.approx(0.25)
    assert spreads[0] / rates[0] == pytest.approx(0.28, abs=0.01)
    assert rises[1] / rates[1] == pytest.approx(0.08)
    assert spreads[1] / rates[1] == pytest.approx(0.126, abs=0.01)


def test_a_guess_is_worth_no_more_than_what_is_usual() -> None:
    guess = CURVE.replace("std = 300", "std = 20000")
    silent = parsed()
    for name in ("square_rear", "cube_rear"):
        mean, std = row(parsed(guess), name)
        usual, spread = row(silent, name)
        assert std < spread
        assert std == pytest.approx(spread, rel=0.05)
        assert abs(mean - usual) < 0.1 * spread


def test_roll_centres_come_down_as_each_axle_s_is_said_to() -> None:
    drops = (
        "roll_center_drop_front = {value = 1.4, std = 0.1}\nroll_center_drop_rear = {value = 0, std = 0.1}\n"
    )
    told = before_the_log(parsed(drops))
    p = at_mean(told) | {"load": 300.0, "load_x": 1.2}
    assert float(roll_center(p, "front")) == pytest.approx(0.08 - 1.4 * float(pressed(p, "front")))
    assert float(roll_center(p, "rear")) == pytest.approx(0.12)
    assert row(parsed(drops), "axis_sinks")[1] < 1e-9
    assert row(parsed(drops), "sinks_rear") == (0.0, 0.1)
    silent = at_mean(before_the_log(parsed())) | {"load": 300.0, "load_x": 1.2}
    assert float(roll_center(silent, "front")) == pytest.approx(0.08 - 0.8 * float(pressed(silent, "front")))


def test_a_tyre_that_gives_sideways_moves_its_patch_by_what_the_file_says() -> None:
    usual = row(parsed(), "patch_side")
    soft, stiff = (row(parsed(f"tire_lateral_rate_npm = {rate}\n"), "patch_side") for rate in (160e3, 1e9))
    assert soft[0] == pytest.approx(0.25 * 1600 / 160e3)
    assert soft[1] < 0.6 * usual[1]
    assert stiff[0] == pytest.approx(0.0, abs=1e-5)
    assert 0 < stiff[1] < 0.3 * usual[1]


PATHS = """
patch_path_front_mprad = {value = 0.02, std = 0.02}
patch_path_rear_mprad = {value = 0.05, std = 0.03}
patch_path_pitch_mprad = {value = 0.38, std = 0.01}
wheel_recession_front = {value = -0.03, std = 0.008}
wheel_recession_rear = {value = 0.09, std = 0.01}
tire_longitudinal_rate_npm = {value = 300000, std = 30000}
"""


def test_the_ways_of_patches_and_hubs_are_those_of_the_file() -> None:
    silent, told = parsed(), parsed(PATHS)
    assert [row(each, "paths_told")[0] for each in (silent, told)] == [0.0, 1.0]
    assert row(told, "paths_told")[1] < 1e-9
    assert row(told, "path_rear") == (0.05, 0.03)
    assert row(told, "pitch_path") == (0.38, 0.01)
    lag, spread = row(told, "patch_lag")
    assert lag == pytest.approx(0.25 * 9.80665 * 1600 / 300e3)
    assert 0.1 * lag < spread < 0.25 * lag
    assert spread < 0.7 * row(silent, "patch_lag")[1]
    assert row(told, "hubs_past")[1] < 0.3 * row(silent, "hubs_past")[1]


def test_hubs_that_go_their_own_way_push_along_it() -> None:
    """Virtual work: m_u a along the way that a hub goes a metre of travel, front ones on their lever, rear ones on theirs."""
    known = before_the_log(parsed(PATHS))
    p = at_mean(known) | {"load": 0.0}
    rear = p["wheelbase"] - p["empty_x"]
    expected = p["unsprung_front"] * -0.03 * p["empty_x"] - p["unsprung_rear"] * 0.09 * rear
    assert past_the_springs(p) == pytest.approx(expected)


def test_stops_are_looked_for_from_where_the_file_has_them() -> None:
    text = "bump_stop_clearance_front_m = {value = 0.06, std = 0.004}\nbump_stop_clearance_rear_m = {value = 0.08, std = 0.004}\n"
    assert free_travel(parsed(text)) == {
        "front": pytest.approx(0.052),
        "rear": pytest.approx(0.072),
    }
    assert free_travel(parsed()) is None
    assert free_travel(parsed(text + 'deflection_zero = "loaded"\n')) is None
    assert row(parsed(text), "stop_rear") != row(parsed(), "stop_rear")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("spring_rate_rear_bump_npm = 33000\n", "stated without spring_rate_rear_rebound_npm"),
        ("roll_center_drop_front = 1.2\n", "stated without roll_center_drop_rear"),
        ("bump_stop_clearance_rear_m = 0.08\n", "stated without bump_stop_clearance_front_m"),
        ("spring_rate_rear_bump_npm = 90000\nspring_rate_rear_rebound_npm = 26000\n", "3.33 times the rate"),
        ("tire_lateral_rate_npm = 160\n", "expected 1000"),
        ("tire_longitudinal_rate_npm = 300\n", "expected 1000"),
        ("patch_path_front_mprad = 0.02\n", "stated without patch_path_rear_mprad"),
        ("wheel_recession_rear = 0.09\n", "stated without wheel_recession_front"),
        ("patch_path_pitch_mprad = 6.6\n", "mm a degree"),
        ("spring_rate_rear_bump = 33000\n", "unknown key"),
    ],
)
def test_half_a_statement_or_a_stop_in_a_rate_is_an_error_that_says_so(text: str, words: str) -> None:
    with pytest.raises(VehicleError, match=words):
        parsed(text)


def test_the_rig_is_named_where_it_would_help() -> None:
    actions = [c.action for c in CANDIDATES]
    assert any("50 mm above and below ride height" in a for a in actions)
    assert any("lateral rate" in a for a in actions)
    assert any("patch_path_front_mprad" in a for a in actions)
    assert any("wheel_recession" in a for a in actions)


def test_a_roll_gradient_on_stops_is_one_of_the_drive_s_bends() -> None:
    text = "bump_stop_clearance_front_m = {value = 0.06, std = 0.0}\nbump_stop_clearance_rear_m = {value = 0.08, std = 0.0}\n"
    n = 1000
    travel = {f"suspension_deflection_{w}": np.zeros(n) for w in ("fl", "fr", "rl", "rr")}
    travel["suspension_deflection_rr"][:50] = 0.09
    flags = np.zeros(n, dtype=bool)
    prepared = Prepared(
        100.0, 8.0, np.arange(n) / 100, travel, (Segment(0, n),), {}, frozenset(travel), flags
    )
    rows = np.arange(n)
    assert stops_touched(prepared, rows, parsed(text)) == pytest.approx(0.05)
    assert stops_touched(prepared, rows[60:], parsed(text)) == 0.0
    assert stops_touched(prepared, rows, parsed()) == 0.0
    told = ParameterEstimate("roll_gradient_degpg", 5.0, 0.1, 4.8, 5.2, "identified", "from the log")
    assert with_stops(told, 0.0) is told
    wide = with_stops(told, 0.05)
    assert (wide.value, wide.status) == (5.0, "weak")
    assert wide.std == pytest.approx(np.hypot(0.1, 0.25))
    assert "5.0% of the bends" in wide.reason
    assert wide.refused in wide.reason
    assert with_stops(told, 0.3).std == pytest.approx(np.hypot(0.1, 0.5))
    little = with_stops(told, 0.01)
    assert (little.status, little.std) == ("identified", pytest.approx(np.hypot(0.1, 0.05)))


def test_what_comes_near_a_stop_is_not_on_it() -> None:
    """A bare figure is good to 10 %: 66 mm of travel before a stop at 80 ± 8 mm is on it with a chance of 6 %, not in all rows."""
    text = "bump_stop_clearance_front_m = 0.08\nbump_stop_clearance_rear_m = 0.08\n"
    n = 1000
    travel = {f"suspension_deflection_{w}": np.zeros(n) for w in ("fl", "fr", "rl", "rr")}
    travel["suspension_deflection_fl"][:400] = 0.066
    prepared = Prepared(
        100.0,
        8.0,
        np.arange(n) / 100,
        travel,
        (Segment(0, n),),
        {},
        frozenset(travel),
        np.zeros(n, dtype=bool),
    )
    assert stops_touched(prepared, np.arange(n), parsed(text)) == pytest.approx(0.06 * 0.4)
