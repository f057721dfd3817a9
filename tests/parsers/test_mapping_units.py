"""Stated units decide: what is none of a signal's rules its channel out, and is said; headers are known with their units."""

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose, propose_and_say, read_map, unmapped_reason
from parsers.mapping.bindings import bind
from parsers.table_names import split_header


def column(name, unit=None):
    return ChannelInfo(name, "table", unit, "table", tags={"column": name})


def best(*channels):
    return {signal: found[0] for signal, found in propose(channels, None).items()}


FOREIGN = [
    ("Steering angle", "V", "unit V is no unit of an angle"),
    ("Steering current", "A", "unit A is no unit of an angle"),
    ("Roll angle", "%", "unit % is no unit of an angle"),
    ("Drive torque", "%", "unit % is no unit of a torque"),
    ("Damper pos FL", "counts", "unit counts is no unit of a length"),
    ("yaw_rate", "mV", "unit mV is no unit of an angular rate"),
    ("Brake pressure", "furlong", "unit furlong is not known"),
    ("Brake pressure [0.1 bar]", None, "unit 0.1 bar is not known"),
    ("Speed [furlong]", None, "unit furlong is not known"),
    ("Speed (km/h*100)", None, "unit km/h*100 is not known"),
    ("Speed [kN]", None, "unit kN is no unit of a speed"),
    ("speed_kN", None, "unit kN is no unit of a speed"),
]


@pytest.mark.parametrize("family", ["table", "mdf"])
@pytest.mark.parametrize(("name", "unit", "words"), FOREIGN)
def test_a_stated_unit_of_something_else_rules_a_channel_out_and_is_said(name, unit, words, family):
    channel = ChannelInfo(name, "table", unit, family, tags={"column": name})
    proposals, said = propose_and_say([channel], None)
    assert proposals == {}
    (sentence,) = said
    assert sentence.startswith(name)
    assert words in sentence
    assert words in unmapped_reason(channel)


def test_a_unit_of_something_else_is_not_said_where_the_signal_has_a_channel():
    wheels = [column("Steering angle", "deg"), column("steering_wheel_angle", "V")]
    proposals, said = propose_and_say(wheels, None)
    assert proposals["steering_wheel_angle"][0].channels == ("Steering angle",)
    assert said == ()


@pytest.mark.parametrize("unit", ["-", "1", "none", "[-]", "(null)", "raw", "n/a"])
def test_a_unit_that_says_nothing_leaves_the_channel(unit):
    assert not best(column("Yaw rate", unit))["yaw_rate"].unit_stated


@pytest.mark.parametrize("name", ["Speed (ADMA)", "Speed (GPS)", "Brake pressure [front]"])
def test_a_remark_behind_a_name_is_no_unit(name):
    (found,) = best(column(name)).values()
    assert not found.unit_stated


HEADERS = [
    ("AVz (deg/s)", "yaw_rate", 0.01745329),
    ("AVx [deg/s]", "roll_rate", 0.01745329),
    ("Jnc_L1 (mm)", "suspension_deflection_fl", 1e-3),
    ("Fz_R2 (N)", "tire_normal_force_rr", 1.0),
    ("Vehicle Speed, km/h", "speed", 1 / 3.6),
    ("Vehicle Speed in km/h", "speed", 1 / 3.6),
    ("Vehicle Speed / km/h", "speed", 1 / 3.6),
    ("speed_knots", "speed", 0.5144444),
    ("speedKnots", "speed", 0.5144444),
    ("speed_kn", "speed", 0.5144444),
    ("SPEED_KN", "speed", 0.5144444),
    ("wheel_load_fl_kN", "tire_normal_force_fl", 1000.0),
    ("wheel_load_fl_kn", "tire_normal_force_fl", 1000.0),
    ("Wheel load FL kN", "tire_normal_force_fl", 1000.0),
    ("Wheel load FL [kN]", "tire_normal_force_fl", 1000.0),
    ("brake_pressure_psi", "brake_pressure", 6894.757),
    ("Grade [%]", "road_grade", 0.01),
    ("RoadGrade (percent)", "road_grade", 0.01),
    ("road_grade_pct", "road_grade", 0.01),
    ("Road Slope (deg)", "road_grade", 0.01745329),
    ("brake_torque_ftlb", "brake_torque", 1.355818),
]


@pytest.mark.parametrize(("header", "signal", "scale"), HEADERS)
def test_a_header_is_known_with_its_unit_as_it_is_without(header, signal, scale):
    split = split_header(header)
    found = best(ChannelInfo(split.name, "table", split.unit, tags={"column": header}))
    assert found[signal].unit.scale == pytest.approx(scale, rel=1e-6)
    assert found[signal].unit_stated


@pytest.mark.parametrize(
    ("unit", "raw", "radians"),
    [("%", 100.0, np.pi / 4), ("%", -30.0, -np.arctan(0.3)), ("deg", 45.0, np.pi / 4), ("rad", 0.3, 0.3)],
)
def test_a_grade_in_per_cent_is_rise_over_run(unit, raw, radians):
    grade = best(column("Grade", unit))["road_grade"]
    assert bind(grade, {"Grade": np.array([raw, np.nan])}) == pytest.approx([radians, np.nan], nan_ok=True)


def test_a_mapping_files_grade_in_per_cent(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[signals.road_grade]\nchannel = "G"\nunit = "%"\nscale = 2.0\ninvert = true\n')
    grade = propose([column("G")], read_map(path))["road_grade"][0]
    assert bind(grade, {"G": np.array([50.0])}) == pytest.approx([-np.pi / 4])
