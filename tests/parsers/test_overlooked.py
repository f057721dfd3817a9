"""Channels that nobody knows and that look like what a log lacks: said, never guessed."""

from __future__ import annotations

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose, propose_and_say
from parsers.mapping.overlooked import SAID
from parsers.table_names import split_header


def column(name: str, unit: str | None, kind: str = "number") -> ChannelInfo:
    return ChannelInfo(
        name, "table", unit, kind="text" if kind == "text" else "number", tags={"column": name}
    )


def said(*channels: ChannelInfo) -> list[str]:
    return [text for text in propose_and_say(channels, None)[1] if text.startswith(SAID)]


def test_what_looks_like_the_missing_signals_is_named() -> None:
    levels = [column(f"FW_Niveau_{w}", "mm") for w in ("VL", "VR", "HL", "HR")]
    (text,) = said(*levels, column("BRK_TMC_PRES", "bar"), column("ay", "m/s2"))
    assert (
        "suspension deflections (FW_Niveau_VL [mm], FW_Niveau_VR [mm], FW_Niveau_HL [mm], FW_Niveau_HR [mm])"
        in text
    )
    assert "brake pressure (BRK_TMC_PRES [bar])" in text
    assert "inspect --write-map" in text


def test_many_are_counted() -> None:
    (text,) = said(*[column(f"Q{i}_FL", "mm") for i in range(9)])
    assert text.count("[mm]") == 4
    assert "and 5 more" in text


@pytest.mark.parametrize(
    "channel",
    [
        column("FW_Niveau_VL", None),  # no unit
        column("FW_Niveau_VL", "V"),  # none of a signal's
        column("Niveau", "mm"),  # of no wheel
        column("FW_Niveau_VL_max", "mm"),  # no measurement of now
        column("FW_Niveau_VL", "mm", "text"),
        column("Reifendruck_VL", "bar"),  # a tyre's pressure is no brake's
    ],
)
def test_what_says_too_little_is_not(channel: ChannelInfo) -> None:
    assert said(channel) == []


def test_nothing_is_said_of_what_the_log_has() -> None:
    have = [column(f"suspension_travel_{w}", "mm") for w in ("fl", "fr", "rl", "rr")]
    assert said(*have, column("FW_Niveau_VL", "mm")) == []


@pytest.mark.parametrize(
    ("name", "unit", "signal"),
    [
        ("Fzg_Geschwindigkeit", "km/h", "speed"),
        ("Radgeschw_HL", "km/h", "wheel_speed_rl"),
        ("Bremsdruck_HZ", "bar", "brake_pressure"),
        ("Einfederweg_VR", "mm", "suspension_deflection_fr"),
        ("nWheel_FL", "km/h", "wheel_speed_fl"),
        ("vWheelRR", "km/h", "wheel_speed_rr"),
        ("aSteerWheel", "deg", "steering_wheel_angle"),
        ("pBrakeMC", "bar", "brake_pressure"),
        ("sSusp_FL", "mm", "suspension_deflection_fl"),
        ("WhlDrvTqAct", "Nm", "drive_torque"),
        ("WhlBrkTqEst", "Nm", "brake_torque"),
        ("Fahrzeuggeschwindigkeit", "km/h", "speed"),
        ("Fahrgeschwindigkeit", "km/h", "speed"),
        ("SOG", "km/h", "gps_speed_2d"),
        ("Hauptbremszylinderdruck", "bar", "brake_pressure"),
        ("p_HBZ", "bar", "brake_pressure"),
        ("HandWheelAngle", "deg", "steering_wheel_angle"),
        ("AngRateZ", "deg/s", "yaw_rate"),
        ("Wheel travel FL", "mm", "suspension_deflection_fl"),
    ],
)
def test_names_of_german_and_of_test_benches_are_known(name: str, unit: str, signal: str) -> None:
    assert [*propose([column(name, unit)], None)] == [signal]


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("nWheel_FL", None),
        ("aSteerWheel", "m/s2"),
        ("pBrakeMC", "deg"),
        ("sSusp_FL", None),
        ("DrvTqReq", "Nm"),
        ("p_HBZ", None),
        ("SOG", None),
        ("SOG", "%"),
    ],
)
def test_short_ones_need_their_unit(name: str, unit: str | None) -> None:
    assert [*propose([column(name, unit)], None)] == []


@pytest.mark.parametrize(
    ("name", "unit", "what"),
    [
        ("AccY (right +)", "m/s2", "lateral acceleration"),
        ("Beschl. quer Sitz", "g", "lateral acceleration"),
        ("AYC", "m/s2", "acceleration of some axis"),
        ("linear_acceleration_y", "m/s2", "lateral acceleration"),
        ("YawRate (cw +)", "deg/s", "yaw rate"),
        ("Gier", "deg/s", "yaw rate"),
        ("Bank angle", "deg", "roll angle"),
        ("Lenkwinkel", "deg", "steering wheel angle"),
        ("Speed2D", "km/h", "speed"),
        ("Yaw_Rate_1", None, "yaw rate"),  # a name of known words alone needs no unit
        ("Lenkwinkel", None, "steering wheel angle"),
    ],
)
def test_motion_of_the_body_is_named(name: str, unit: str | None, what: str) -> None:
    shown = name if unit is None else f"{name} [{unit}]"
    (text,) = said(ChannelInfo(name, "table", unit, tags={"column": shown}))
    assert f": {what} ({shown});" in text


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("BrakePressureSwitch", None),
        ("SteeringAngleStatus", None),
        ("steering velocity", None),
        ("vehicle_speed_ok", None),
        ("YawRateOffset", "deg/s"),
        ("GPS Lat Acc", "m/s2"),  # without gravity
        ("SteerRate", "deg/s"),
        ("Engine speed", "rpm"),
        ("accel_y_fl", "g"),
        ("Seat position x", "mm"),
        ("Inclination", "deg"),
        ("Heading", "deg"),
    ],
)
def test_what_is_something_else_is_not_named(name: str, unit: str | None) -> None:
    assert said(column(name, unit)) == []


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("speed_km_per_h", "speed_km_per_h", "km/h"),
        ("acc_y_m_per_s2", "acc_y_m_per_s2", "m/s²"),
        ("yaw_rate_deg_per_s", "yaw_rate_deg_per_s", "deg/s"),
        ("Speed km/h", "Speed", "km/h"),
        ("AccY m/s^2", "AccY", "m/s^2"),
        ("SteeringWheelAngle deg", "SteeringWheelAngle", "deg"),
        ("Time s", "Time", "s"),
        ("t/ms", "t", "ms"),
        ("a_x/g", "a_x", "g"),
        ("v/(km/h)", "v", "km/h"),
        ("delta_H/°", "delta_H", "°"),
        ("cell/v", "cell/v", None),
        ("/imu/g", "/imu/g", None),
        ("GPS/Speed", "GPS/Speed", None),
        ("Roll bar", "Roll bar", None),
        ("Mass s", "Mass s", None),
        ("Steering Angle", "Steering Angle", None),
        ("Cell V", "Cell V", None),
        ("Einfederung hinten rad", "Einfederung hinten rad", None),
    ],
)
def test_units_behind_a_blank_and_spelt_out(header: str, name: str, unit: str | None) -> None:
    found = split_header(header)
    assert (found.name, found.unit) == (name, unit)


def test_names_with_units_spelt_out_are_mapped() -> None:
    columns = [
        ChannelInfo((c := split_header(header)).name, "table", c.unit, tags={"column": header})
        for header in (
            "speed_km_per_h",
            "acc_y_m_per_s2",
            "yaw_rate_deg_per_s",
            "AccX m/s^2",
            "a_z/(m/s^2)",
            "delta_H/rad",
        )
    ]
    found = {signal: each[0].unit.scale for signal, each in propose(columns, None).items()}
    assert found == {
        "speed": pytest.approx(1 / 3.6),
        "accel_y": 1.0,
        "yaw_rate": pytest.approx(0.017453292519943295),
        "accel_x": 1.0,
        "accel_z": 1.0,
        "steering_wheel_angle": 1.0,
    }


@pytest.mark.parametrize(
    "header",
    [
        "StrutForce_fl_kN",
        "F_strut_fl_kN",
        "strutforce_fl_kn",
        "Last_Feder_vl [kn]",
        "Strut FL [kN]",
        "Q7_fl (kN)",
    ],
)
def test_kilonewtons_are_no_knots(header: str) -> None:
    split = split_header(header)
    (text,) = said(column(split.name, split.unit))
    assert "suspension or tyre forces" in text
    assert "wheel speeds" not in text


def test_knots_stay_knots() -> None:
    split = split_header("Q7_fl_kn")
    (text,) = said(column(split.name, split.unit))
    assert "wheel speeds (Q7_fl_kn [kn])" in text
