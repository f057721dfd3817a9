"""The built-in profiles: each is readable, and knows the channels that it is for."""

from importlib.resources import files

import cantools
import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.mapping import bind, propose, unmapped_reason
from parsers.mapping.match import index_channels, profile_bindings
from parsers.mapping.profiles import load_profiles, parse_profile


def can(message, signal, unit=None, **tags):
    tags = {"message": message, "signal": signal, **tags}
    return ChannelInfo(f"{message}.{signal}", message, unit, "can", tags=tags)


def vbo(name, unit=None):
    return ChannelInfo(name, "data", unit, "vbo", tags={"column": name})


def mapped(*channels):
    return {signal: found[0] for signal, found in propose(channels, None).items()}


def test_all_profiles_load():
    names = {profile.name for profile in load_profiles()}
    wanted = {
        "ros",
        "vbox",
        "j1939",
        "toyota",
        "vw_mqb",
        "hyundai",
        "hyundai_fd",
        "honda",
        "ford",
        "foxglove",
    }
    assert wanted <= names
    assert all(profile.families and profile.rules for profile in load_profiles())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("foo = 1", "unknown key 'foo'"),
        ("[[rules]]\nsignal = 'speed'", "signal and match are needed"),
        ("[[rules]]\nsignal = 'sped'\nmatch = {name = 'a'}", "unknown signal 'sped'"),
        ("[[rules]]\nsignal = 'speed'\nmatch = {name = 'a'}\nunit = 'bar'", "unit 'bar' is no unit of speed"),
        ("[[rules]]\nsignal = 'speed'\nmatch = {name = '('}", "no table of patterns"),
        ("[[rules]", "not valid TOML"),
    ],
)
def test_a_wrong_profile_is_named(text, message):
    with pytest.raises(MappingError, match=f"profile mine.*{message}"):
        parse_profile("mine", text)


def test_a_new_profile_is_one_text():
    profile = parse_profile(
        "mine",
        "families = ['table']\n[[rules]]\nsignal = 'roll'\nmatch = {name = 'Q7'}\nunit = 'deg'\ninvert = true",
    )
    (found,) = profile_bindings(profile, index_channels([ChannelInfo("Q7", "t"), ChannelInfo("Q8", "t")]))
    assert bind(found, {"Q7": np.array([180.0])}) == pytest.approx([-np.pi])


def test_a_word_that_a_profile_explains_stands_for_its_pattern():
    profile = parse_profile(
        "mine",
        """
        families = ["table"]
        words = { tilt = "(bank|lean)" }
        [[rules]]
        signal = "roll"
        match = { name = "{tilt}_[0-9]{1,2}" }
        unit = "deg"
        """,
    )
    names = ("bank_1", "lean_12", "tilt_1", "bank_123")
    found = profile_bindings(profile, index_channels([ChannelInfo(name, "t") for name in names]))
    assert [each.channels for each in found] == [("bank_1",), ("lean_12",)]


@pytest.mark.parametrize("lateral", ["Y_Accel", "LatAcc", "lateral acceleration"])
def test_vbox(lateral):
    names = [
        "sats",
        "lat",
        "long",
        "velocity",
        "height",
        lateral,
        "YawRate",
        "Yaw_Rate",
        "RollRate",
        "PitRate",
        "SteerAng",
    ]
    found = mapped(*[vbo(name) for name in [*names, "Roll_Angle", "Pitch_Ang.", "Lat._Vel."]])
    assert found["accel_y"].unit.text == "g"
    assert found["yaw_rate"].channels == ("YawRate",)
    assert bind(found["longitude"], {"long": np.array([-1086.0])}) == pytest.approx([18.1])
    assert bind(found["speed"], {"velocity": np.array([36.0])}) == pytest.approx([10.0])
    assert {
        "roll",
        "pitch",
        "roll_rate",
        "pitch_rate",
        "steering_wheel_angle",
        "altitude",
        "satellites",
    } <= set(found)


@pytest.mark.parametrize("by_number", [True, False])
def test_j1939(by_number):
    def one(message, signal, pgn, spn, unit=None):
        tags = {"pgn": str(pgn), "spn": str(spn)} if by_number else {}
        return can(message, "odd" + signal if by_number else signal, unit, **tags)

    channels = [
        one("VDC2", "SteeringWheelAngle", 61449, 1807, "rad"),
        one("VDC2", "YawRate", 61449, 1808, "rad/s"),
        one("VDC2", "LateralAcceleration", 61449, 1809, "m/s²"),
        one("VDC2", "LongitudinalAcceleration", 61449, 1810),
        one("EBC2", "FrontAxleSpeed", 65215, 904, "km/h"),
        one("EBC2", "RelativeSpeedFrontAxleLeftWheel", 65215, 905, "km/h"),
        one("EBC2", "RelativeSpeedFrontAxleRightWheel", 65215, 906, "km/h"),
        one("EBC2", "RelativeSpeedRearAxle1LeftWheel", 65215, 907, "km/h"),
        one("EBC2", "RelativeSpeedRearAxle1RightWheel", 65215, 908, "km/h"),
        one("CCVS1", "WheelBasedVehicleSpeed", 65265, 84, "km/h"),
        one("VW", "AxleWeight", 65258, 582, "kg"),
        one("VW", "AxleLocation", 65258, 928),
    ]
    found = mapped(*channels)
    assert found["speed"].channels[0].startswith("CCVS1.")
    left = found["wheel_speed_rl"]
    assert len(left.channels) == 2
    columns = {left.channels[0]: np.array([36.0]), left.channels[1]: np.array([-3.6])}
    assert bind(left, columns) == pytest.approx([9.0])
    speed = found["speed"]
    assert np.isnan(bind(speed, {speed.channels[0]: np.array([255.996])})).all()
    rear = found["axle_load_rear"]
    values = bind(rear, {rear.channels[0]: np.array([100.0, 200.0]), rear.needed[1]: np.array([1.0, 17.0])})
    assert np.isnan(values[0])
    assert values[1] == pytest.approx(1961.33)
    assert {"accel_x", "accel_y", "yaw_rate", "steering_wheel_angle", "axle_load_front"} <= set(found)


@pytest.mark.parametrize(
    ("channel", "signal", "scale"),
    [
        (can("KINEMATICS", "YAW_RATE", "deg/sec"), "yaw_rate", np.pi / 180),
        (can("KINEMATICS", "ACCEL_Y", ""), "accel_y", 1.0),
        (can("ESP_02", "ESP_Querbeschleunigung", "Unit_ForceOfGravi"), "accel_y", 9.80665),
        (can("ESP_19", "ESP_HL_Radgeschw_02"), "wheel_speed_rl", 1 / 3.6),
        (can("ESP_05", "ESP_Bremsdruck", "Unit_Bar"), "brake_pressure", 1e5),
        (can("ESP12", "YAW_RATE", ""), "yaw_rate", np.pi / 180),
        (can("ESP12", "CYL_PRES", "Bar"), "brake_pressure", 1e5),
        (can("WHL_SPD11", "WHL_SPD_RL", "km/h"), "wheel_speed_rl", 1 / 3.6),
        (can("IMU_01_10ms", "IMU_LatAccelVal", "g"), "accel_y", 9.80665),
        (can("VEHICLE_DYNAMICS", "LAT_ACCEL", "m/s2"), "accel_y", 1.0),
        (can("Yaw_Data_FD1", "VehRol_W_Actl", "rad/s"), "roll_rate", 1.0),
        (can("Steering", "StePinComp_An_Est", "Degrees"), "steering_wheel_angle", np.pi / 180),
        (can("My_Dynamics", "LateralAcceleration", "g"), "accel_y", 9.80665),
    ],
)
def test_passenger_cars(channel, signal, scale):
    found = mapped(channel)
    assert list(found) == [signal]
    assert found[signal].unit.scale == pytest.approx(scale)


def test_exports_of_decoded_can_are_known():
    found = mapped(
        ChannelInfo("KINEMATICS.YAW_RATE", "t", None, "table", tags={"column": "KINEMATICS.YAW_RATE"})
    )
    assert found["yaw_rate"].unit_from == "profile toyota"


@pytest.mark.parametrize(
    ("name", "unit", "signal", "scale"),
    [
        ("AVz", None, "yaw_rate", np.pi / 180),
        ("AVz", "rad/s", "yaw_rate", 1.0),
        ("Steer_SW", None, "steering_wheel_angle", np.pi / 180),
        ("Fz_R2", None, "tire_normal_force_rr", 1.0),
        ("Jnc_L1", None, "suspension_deflection_fl", 1e-3),
        ("Car.CFR.Tire.FzC", None, "tire_normal_force_fr", 1.0),
    ],
)
def test_variables_of_simulators(name, unit, signal, scale):
    found = mapped(ChannelInfo(name, "t", unit, "table", tags={"column": name}))
    assert list(found) == [signal]
    assert found[signal].unit.scale == pytest.approx(scale)


@pytest.mark.parametrize("name", ["Car.WheelSpd_FL", "Vhcl.FL.rotv", "CmpS_L1"])
def test_what_a_profile_knows_to_be_something_else_is_not_guessed_by_name(name):
    channel = ChannelInfo(name, "t", None, "table", tags={"column": name})
    assert mapped(channel) == {}
    assert "no profile knows it" not in unmapped_reason(channel)


def test_a_magnitude_without_its_sign_is_refused():
    alone = can("ESP_02", "ESP_Gierrate")
    assert mapped(alone) == {}
    assert "ESP_VZ_Gierrate" in unmapped_reason(alone)
    found = mapped(alone, can("ESP_02", "ESP_VZ_Gierrate"))
    assert found["yaw_rate"].sign_channel == "ESP_02.ESP_VZ_Gierrate"


@pytest.mark.parametrize(
    ("channel", "words"),
    [
        (can("WheelSpeed", "WhlFl_W_Meas", "rad/s"), "radius"),
        (can("BRAKE", "BRAKE_PRESSURE1", ""), "unit is not known"),
        (can("KINEMATICS", "YAW_RATE", "Nm"), "unit Nm is no unit of an angular rate"),
        (can("ABC", "Speed", ""), "too general"),
        (can("RADAR_TRACK", "Speed", "km/h"), "not a measurement"),
    ],
)
def test_can_channels_that_are_left_alone(channel, words):
    assert mapped(channel) == {}
    assert words in unmapped_reason(channel)


def test_many_channels_are_quick():
    channels = [can(f"M{number // 20}", f"S{number}", "km/h") for number in range(6000)]
    assert propose(channels, None) == {}


def test_the_shipped_j1939_database_is_mapped():
    path = files("parsers.can").joinpath("j1939.dbc")
    database = cantools.database.load_string(path.read_text(encoding="utf-8"), "dbc")
    channels = [can(m.name, s.name, s.unit) for m in database.messages for s in m.signals]
    found = mapped(*channels)
    assert {signal: binding.channels[0].split(".")[0] for signal, binding in found.items()} == {
        "accel_x": "ACS",
        "accel_y": "VDC2",
        "accel_z": "ACS",
        "roll_rate": "ARI",
        "pitch_rate": "ARI",
        "yaw_rate": "VDC2",
        "pitch": "VDS",
        "speed": "CCVS1",
        "gps_speed_2d": "VDS",
        "latitude": "VP",
        "longitude": "VP",
        "altitude": "VDS",
        **{f"wheel_speed_{wheel}": "HRW" for wheel in ("fl", "fr", "rl", "rr")},
        "steering_wheel_angle": "VDC2",
        "axle_load_front": "VW",
        "axle_load_rear": "VW",
    }


def test_oxts_axes_point_right_and_down():
    names = ("AccelForward", "AccelLateral", "AccelDown", "AngleRateForward", "AngleRateLateral",
             "AngleRateDown", "AngleRoll", "AnglePitch", "SpeedHoriz")  # fmt: skip
    table = [ChannelInfo(name, "table", None, "table", tags={"column": name}) for name in names]
    for channels in (table, [can("Output", name) for name in names]):
        found = mapped(*channels)
        turned = {"accel_y", "accel_z", "pitch_rate", "yaw_rate", "pitch"}
        assert {name for name, binding in found.items() if binding.invert} == turned
        assert set(found) - turned == {"accel_x", "roll_rate", "roll", "speed"}
        assert all(binding.unit_stated for binding in found.values())


def test_oxts_body_axes_before_level_ones():
    table = [
        ChannelInfo(name, "table", "m/s²", "table", tags={"column": name})
        for name in ("AccelLateral", "AccelYVehicle")
    ]
    assert mapped(*table)["accel_y"].channels == ("AccelYVehicle",)
