"""Names that mean a signal where all four wheels have it, and names of axles, struts and bodies that loggers write."""

from __future__ import annotations

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import WheelRadius, propose, propose_and_say
from parsers.mapping.bindings import Binding
from parsers.table_names import split_header

WHEELS = ("fl", "fr", "rl", "rr")
RADIUS = WheelRadius(0.3, 0.4, "van.toml")
QUADS = [
    ("defl_{}", "suspension_deflection_{}", 1.0),
    ("Defl {}", "suspension_deflection_{}", 1.0),
    ("Tb_{}", "brake_torque_{}", 1.0),
    ("Td_{}", "drive_torque_{}", 1.0),
]


def columns(*headers: str) -> list[ChannelInfo]:
    split = [split_header(header) for header in headers]
    return [ChannelInfo(each.name, "table", each.unit, tags={"column": each.header}) for each in split]


def best(*headers: str, radius: WheelRadius | None = None) -> dict[str, Binding]:
    return {signal: found[0] for signal, found in propose(columns(*headers), None, radius).items()}


@pytest.mark.parametrize(("name", "signal", "scale"), QUADS)
def test_all_four_wheels_say_what_a_short_name_is(name: str, signal: str, scale: float) -> None:
    found = best(*(name.format(wheel) for wheel in WHEELS))
    assert list(found) == [signal.format(wheel) for wheel in WHEELS]
    assert {each.unit.scale for each in found.values()} == {scale}
    assert not any(each.unit_stated for each in found.values())


@pytest.mark.parametrize(("name", "signal", "scale"), QUADS)
def test_fewer_wheels_do_not(name: str, signal: str, scale: float) -> None:
    assert not best(*(name.format(wheel) for wheel in WHEELS[:3]))
    assert not best(*(f"{name.format(wheel)}_cmd" for wheel in WHEELS))


def test_omega_of_all_wheels_is_their_turn_rate() -> None:
    names = [f"omega_{wheel}" for wheel in WHEELS]
    found = best(*names, radius=RADIUS)
    assert [each.unit.scale for each in found.values()] == pytest.approx([0.3, 0.3, 0.4, 0.4])
    assert list(found) == [f"wheel_speed_{wheel}" for wheel in WHEELS]
    proposals, said = propose_and_say(columns(*names), None)
    assert not proposals
    assert sum("wheel_radius_m" in each for each in said) == 4
    assert best(*(f"{name} [rpm]" for name in names), radius=RADIUS)["wheel_speed_fl"].unit.text == "rpm"


@pytest.mark.parametrize(
    ("header", "signal", "scale"),
    [
        ("WheelTorque [Nm]", "drive_torque", 1.0),
        ("Axle Torque (lb-ft)", "drive_torque", 1.3558179),
        ("Tb_rr [Nm]", "brake_torque_rr", 1.0),
        ("defl_rl_mm", "suspension_deflection_rl", 1e-3),
        ("Brake torque FL [Nm]", "brake_torque_fl", 1.0),
        ("Drive Trq_RR [kNm]", "drive_torque_rr", 1000.0),
        ("Body acc FL [g]", "accel_z_sprung_fl", 9.80665),
        ("Chassis accel rear right [m/s2]", "accel_z_sprung_rr", 1.0),
        ("Hub acc FL [g]", "accel_z_unsprung_fl", 9.80665),
        ("Achslast vorne [kg]", "axle_load_front", 9.80665),
        ("Achslast hinten [kg]", "axle_load_rear", 9.80665),
        ("Vorderachslast [kN]", "axle_load_front", 1000.0),
        ("Hinterachslast [N]", "axle_load_rear", 1.0),
        ("Radlast VL [N]", "tire_normal_force_fl", 1.0),
    ],
)
def test_names_with_units(header: str, signal: str, scale: float) -> None:
    found = best(header)
    assert list(found) == [signal]
    assert found[signal].unit.scale == pytest.approx(scale)
    assert found[signal].unit_stated


@pytest.mark.parametrize(
    "header",
    [
        "WheelTorque",  # of which unit, and of one wheel or of all?
        "Engine torque [Nm]",
        "Steering wheel torque [Nm]",
        "acc FL [g]",  # of the body or of the hub?
        "susp_front_mm",  # an axle's mean is neither wheel's
        "pos_fl",
        "Last [%]",
    ],
)
def test_what_says_too_little_is_left_alone(header: str) -> None:
    assert not best(header)
