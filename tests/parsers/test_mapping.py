"""Bindings, proposals and the names that columns carry."""

import math

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.mapping import (
    Binding,
    bind,
    needed_channels,
    propose,
    propose_and_say,
    read_map,
    unmapped_reason,
)
from parsers.mapping.reasons import reasons_beside
from parsers.units import require_unit


def column(name, unit=None, **more):
    return ChannelInfo(name, "table", unit, "table", tags={"column": name}, **more)


def best(*channels):
    return {signal: found[0] for signal, found in propose(channels, None).items()}


def binding(signal="accel_y", channels=("a",), unit="m/s2", quantity="acceleration", **more):
    return Binding(signal, channels, require_unit(unit, quantity, place=""), "log", "test", **more)


def test_bind_converts_after_scale_offset_and_range():
    made = binding(unit="g", scale=2.0, offset=0.5, valid_range=(-2.0, 2.0), invert=True)
    values = bind(made, {"a": np.array([0.25, 5.0, np.nan, -1.5])})
    # 0.25 * 2 + 0.5 = 1 g, inverted; 10.5 g is outside; -2.5 g is outside
    assert values[0] == pytest.approx(-9.80665)
    assert np.isnan(values[1:]).all()


def test_bind_adds_channels_and_takes_the_sign_from_another():
    made = binding("steering_wheel_angle", ("angle", "fraction"), "deg", "angle", sign_channel="sign")
    columns = {
        "angle": np.array([10.0, 10.0, 10.0]),
        "fraction": np.array([0.5, -0.5, 0.0]),
        "sign": np.array([0.0, 1.0, np.nan]),
    }
    values = np.rad2deg(bind(made, columns))
    assert values[:2] == pytest.approx([10.5, -9.5])
    assert np.isnan(values[2])
    assert needed_channels([made]) == {"angle", "fraction", "sign"}


def test_bind_keeps_only_the_rows_of_where():
    made = binding("axle_load_front", ("weight",), "kg", "force", where=("place", 0, 15))
    values = bind(made, {"weight": np.array([1000.0, 2000.0]), "place": np.array([3.0, 17.0])})
    assert values[0] == pytest.approx(9806.65)
    assert np.isnan(values[1])


@pytest.mark.parametrize(("roll", "pitch", "yaw"), [(0.1, -0.2, 2.0), (-0.4, 0.05, -3.0), (0.0, 0.0, 0.3)])
def test_bind_takes_roll_and_pitch_from_a_quaternion(roll, pitch, yaw):
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    quaternion = {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }
    columns = {name: np.array([value, 0.0]) for name, value in quaternion.items()}
    names = ("x", "y", "z", "w")
    for kind, signal, angle in (
        ("roll_of_quaternion", "roll", roll),
        ("pitch_of_quaternion", "pitch", pitch),
    ):
        values = bind(binding(signal, names, "rad", "angle", kind=kind), columns)
        assert values[0] == pytest.approx(angle, abs=1e-12)
        assert np.isnan(values[1])  # a quaternion of zeros is no attitude


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("ay", "accel_y"),
        ("acc_y", "accel_y"),
        ("AccY", "accel_y"),
        ("lat_acc", "accel_y"),
        ("LatAcc", "accel_y"),
        ("lateral_acceleration", "accel_y"),
        ("AccelerationY", "accel_y"),
        ("IMU.AccelY", "accel_y"),
        ("Querbeschleunigung", "accel_y"),
        ("Longitudinal Acceleration", "accel_x"),
        ("gyro_z", "yaw_rate"),
        ("YawRate", "yaw_rate"),
        ("psi_dot", "yaw_rate"),
        ("Gierrate", "yaw_rate"),
        ("gyroX", "roll_rate"),
        ("v", "speed"),
        ("vx", "speed"),
        ("velocity", "speed"),
        ("VEH_SPEED", "speed"),
        ("GPS_Speed", "gps_speed_2d"),
        ("whl_spd_lf", "wheel_speed_fl"),
        ("Wheel Speed Rear Right", "wheel_speed_rr"),
        ("WheelSpeedRL", "wheel_speed_rl"),
        ("Susp Pos FR", "suspension_deflection_fr"),
        ("susp_travel_lr", "suspension_deflection_rl"),
        ("StrgAngle", "steering_wheel_angle"),
        ("Brake Pressure", "brake_pressure"),
        ("phi", "roll"),
        ("RollAngle", "roll"),
        ("a_y", "accel_y"),
        ("a_lat", "accel_y"),
        ("v_x", "speed"),
        ("Querbeschl", "accel_y"),
        ("Längsbeschleunigung", "accel_x"),
        ("La\u0308ngsbeschleunigung", "accel_x"),
        ("Gierwinkelgeschwindigkeit", "yaw_rate"),
        ("Accélération latérale", "accel_y"),
        ("Vitesse de lacet", "yaw_rate"),
        ("InlineAcc", "accel_x"),
        ("Gyro Yaw Velocity", "yaw_rate"),
        ("Steered Angle", "steering_wheel_angle"),
        ("ang_vel_z", "yaw_rate"),
        ("Vhcl.YawRate", "yaw_rate"),
        ("MasterCylPressure", "brake_pressure"),
        ("BrkMstCylPrs", "brake_pressure"),
        ("StWhlAng", "steering_wheel_angle"),
        ("Federweg VL", "suspension_deflection_fl"),
        ("Vertikalbeschleunigung", "accel_z"),
        (".veh.chassis_accelerations.lateral", "accel_y"),
        (".veh.chassis_velocities.yaw", "yaw_rate"),
        (".veh.chassis_displacements.roll", "roll"),
        ("wheel.fl.speed", "wheel_speed_fl"),
    ],
)
def test_names_of_loggers_are_known(name, signal):
    found = best(column(name))
    assert list(found) == [signal]
    assert not found[signal].unit_stated


@pytest.mark.parametrize(
    ("name", "unit", "signal", "scale"),
    [
        ("accel_y_mps2", None, "accel_y", 1.0),
        ("accel_y", "g", "accel_y", 9.80665),
        ("accel_y_g", None, "accel_y", 9.80665),
        ("Height", "ft", "altitude", 0.3048),
        ("Altitude", "mm", "altitude", 0.001),
        ("GPS height", "mm", "altitude", 0.001),
        ("Lateral G", None, "accel_y", 9.80665),
        ("Lat [g]", "g", "accel_y", 9.80665),
        ("Long [g]", None, "accel_x", 9.80665),
        ("Vert", "m/s2", "accel_z", 1.0),
        ("Longitudinal", "g", "accel_x", 9.80665),
        ("yaw rate (deg/s)", None, "yaw_rate", math.pi / 180),
        ("roll_rate_dps", None, "roll_rate", math.pi / 180),
        ("Speed", "km/h", "speed", 1 / 3.6),
        ("wheel_speed_fl_kmh", None, "wheel_speed_fl", 1 / 3.6),
        ("susp_travel_rr_mm", None, "suspension_deflection_rr", 0.001),
        ("brake_pressure_bar", None, "brake_pressure", 1e5),
        ("r", "°/s", "yaw_rate", math.pi / 180),
        ("p", "deg/s", "roll_rate", math.pi / 180),
        ("Gz", "deg/s", "yaw_rate", math.pi / 180),
        ("axle_load_front_kg", None, "axle_load_front", 9.80665),
        ("psi_p", "°/s", "yaw_rate", math.pi / 180),
        ("Steering Pos", "deg", "steering_wheel_angle", math.pi / 180),
        ("VehV_v", "km/h", "speed", 1 / 3.6),
        ("speedKmh", None, "speed", 1 / 3.6),
        ("yawRateDegPerSec", None, "yaw_rate", math.pi / 180),
        ("steeringWheelAngleDeg", None, "steering_wheel_angle", math.pi / 180),
        ("accelYMps2", None, "accel_y", 1.0),
    ],
)
def test_units_come_from_the_log_or_the_name(name, unit, signal, scale):
    found = best(column(name, unit))[signal]
    assert found.unit.scale == pytest.approx(scale)
    assert found.unit_stated


def test_a_reference_instrument_is_measured():
    assert list(best(column("RefImu.yaw_rate", "deg/s"))) == ["yaw_rate"]


@pytest.mark.parametrize(
    ("name", "unit", "words"),
    [
        ("speed", "rpm", "unit rpm is no unit of a speed"),
        ("wheel_speed_fl", "rad/s", "wheel's radius"),
        ("speed [rpm]", None, "unit rpm"),
        ("r", None, "too general"),
        ("Height", "mm", "no altitude"),
        ("Body Height [cm]", None, "no altitude"),
        ("Velocity N", "m/s", "no profile knows it"),
        ("vel_n", "m/s", "no profile knows it"),
        ("CG height [m]", None, "no altitude"),
        ("vehicle_height", "m", "no altitude"),
        ("p", "bar", "unit bar"),
        ("Gz", None, "too general"),
        ("Gx", "g", "no unit of an angular rate"),
        ("acceleration", "g", "which axis"),
        ("wheel speed", "km/h", "which wheel"),
        ("GPS LatAcc", "g", "no specific force"),
        ("engine_speed", "rpm", "no profile knows it"),
        ("target.yaw_rate", "deg/s", "not a measurement"),
        ("yaw_rate_ref", "deg/s", "'ref' in its name: not a measurement"),
        ("YawRateRef [deg/s]", None, "not a measurement"),
        ("ay_ref_mps2", None, "not a measurement"),
        ("speed_setpoint", "m/s", "not a measurement"),
        ("steering_angle_cmd", "deg", "not a measurement"),
        ("speed_desired", "m/s", "not a measurement"),
        ("steer_torque", "Nm", "no profile knows it"),
        ("temperature", "°C", "no profile knows it"),
    ],
)
def test_doubtful_channels_are_left_alone_with_a_reason(name, unit, words):
    assert best(column(name, unit)) == {}
    assert words in unmapped_reason(column(name, unit))


@pytest.mark.parametrize(
    ("names", "unit"),
    [
        (("Velocity N", "Velocity E", "Velocity D"), "m/s"),
        (("vel_n", "vel_e"), "m/s"),
        (("vel_n_m_s", "vel_e_m_s", "vel_d_m_s"), None),
        (("velN", "velE"), "mm/s"),
        (("vn", "ve", "vd"), None),
        (("North Velocity", "East Velocity"), "km/h"),
        (("Speed N [m/s]", "Speed E [m/s]"), None),
    ],
)
def test_velocities_along_the_compass_are_a_speed_over_ground(names, unit):
    found = best(*(column(name, unit) for name in names), column("accel_y", "g"))
    assert set(found) == {"gps_speed_2d", "accel_y"}
    assert found["gps_speed_2d"].channels == names[:2]
    values = bind(found["gps_speed_2d"], {names[0]: np.array([3.0]), names[1]: np.array([-4.0])})
    assert values == pytest.approx([5.0 * found["gps_speed_2d"].unit.scale])


def test_one_velocity_along_the_compass_or_two_of_no_unit_are_no_speed():
    assert best(column("vel_n", "m/s"), column("vel_d", "m/s")) == {}
    assert best(column("v_n"), column("v_e")) == {}
    assert best(column("vel_n", "m/s"), column("vel_e", "V")) == {}
    reasons = reasons_beside([column("vel_n", "m/s"), column("vel_e", "m/s")])
    assert all("along the compass" in reasons[name] for name in ("vel_n", "vel_e"))


def test_an_ending_that_contradicts_the_stated_unit_is_no_unit():
    assert best(column("speed_kg [m/s]")) == {}


@pytest.mark.parametrize("names", [("lat", "lon"), ("lat", "long"), ("GPS Lat", "GPS Long")])
def test_abbreviated_coordinates_come_in_pairs(names):
    assert set(best(*map(column, names))) == {"latitude", "longitude"}
    assert best(column(names[0])) == {}
    assert set(best(column(names[0], "deg"))) == {"latitude"}


@pytest.mark.parametrize("name", ["lateral", "longitudinal", "veh.motion.lateral", "quer"])
def test_a_direction_is_no_coordinate(name):
    assert not {"latitude", "longitude"} & set(best(column(name), column("lateral"), column("longitudinal")))


@pytest.mark.parametrize(
    ("topic", "field", "signal"),
    [
        ("/vehicle/speed", "data", "speed"),
        ("/chassis/suspension_travel", "front_left", "suspension_deflection_fl"),
        ("/chassis/damper_travel", "front_left", None),
        ("/imu/yaw_rate", "value", "yaw_rate"),
        ("/cmd/speed", "data", None),
    ],
)
def test_a_topic_says_what_its_field_does_not(topic, field, signal):
    tags = {"topic": topic, "type": "std_msgs/Float64", "field": field}
    found = best(ChannelInfo(f"{topic}.{field}", topic, None, "ros", tags=tags))
    assert list(found) == ([signal] if signal else [])


def test_what_the_signals_of_a_message_begin_with_is_no_part_of_their_names():
    names = ("Xyz_LatAcc", "Xyz_YawRate", "Xyz_Counter")
    assert set(best(*(column(name, "g" if "Acc" in name else None) for name in names))) == {
        "accel_y",
        "yaw_rate",
    }
    # once is no prefix, and a prefix with a meaning is none
    assert best(column("Xyz_LatAcc", "g")) == {}
    assert best(column("Target_LatAcc", "g"), column("Target_YawRate", "deg/s")) == {}
    assert set(best(column("GPS_LatAcc", "g"), column("GPS_Speed", "km/h"))) == {"gps_speed_2d"}


def test_text_is_never_mapped():
    channel = column("accel_y_mps2", kind="text")
    assert best(channel) == {}
    assert unmapped_reason(channel) == "text"


def test_candidates_are_ranked_and_kept():
    found = propose(
        [column("YawRate raw", "deg/s"), column("gyro_z", "deg/s"), column("yaw_rate", "deg/s")], None
    )
    assert [each.channels[0] for each in found["yaw_rate"]] == ["yaw_rate", "gyro_z", "YawRate raw"]
    assert "ranks above" in unmapped_reason(column("gyro_z", "deg/s"))


def test_more_samples_win_between_equals():
    few = ChannelInfo(
        "/a.y",
        "/a",
        None,
        "ros",
        count=10,
        tags={"topic": "/a", "type": "sensor_msgs/Imu", "field": "linear_acceleration.y"},
    )
    many = ChannelInfo(
        "/b.y",
        "/b",
        None,
        "ros",
        count=99,
        tags={"topic": "/b", "type": "sensor_msgs/Imu", "field": "linear_acceleration.y"},
    )
    assert [each.channels[0] for each in propose([few, many], None)["accel_y"]] == ["/b.y", "/a.y"]


def test_a_place_at_nought_is_told_by_both_coordinates(tmp_path):
    found = propose([column("lat", "deg"), column("lon", "deg"), column("other", "deg")], None)
    assert (found["latitude"][0].beside, found["longitude"][0].beside) == ("lon", "lat")
    assert found["latitude"][0].needed == ("lat", "lon")
    alone = propose([column("lat", "deg")], None)
    assert all(each.beside is None for each in alone.get("latitude", ()))
    path = tmp_path / "map.toml"
    path.write_text('[signals.latitude]\nchannel = "other"\nunit = "deg"\n')
    mapped = propose([column("lat", "deg"), column("lon", "deg"), column("other", "deg")], read_map(path))
    assert mapped["longitude"][0].beside == "other"


def test_user_entries_win_outright(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[signals.accel_y]\nchannel = "Foo"\nunit = "g"\n[signals.speed]\nignore = true\n')
    channels = [column("accel_y", "m/s2"), column("Foo", "V"), column("speed", "m/s")]
    found = propose(channels, read_map(path))
    assert list(found) == ["accel_y"]
    (only,) = found["accel_y"]
    assert (only.channels, only.unit_from, only.rule) == (("Foo",), "map file", "map.toml")


def test_a_user_channel_that_is_not_there_names_the_nearest(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[signals.accel_y]\nchannel = "Latral_G"\n')
    with pytest.raises(MappingError, match=r"\[signals.accel_y\].*'Latral_G' is not in the log.*'Lateral_G'"):
        propose([column("Lateral_G"), column("v")], read_map(path))
    assert "accel_y" in propose([column("Lateral_G")], read_map(path, strict=False))


def test_user_channels_of_two_groups_cannot_be_combined(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[signals.accel_y]\nchannel = "a"\nsign_channel = "b"\n')
    channels = [ChannelInfo("a", "one"), ChannelInfo("b", "two")]
    with pytest.raises(MappingError, match="do not share one clock"):
        propose(channels, read_map(path))


def test_german_coordinates():
    found = best(column("Breitengrad", "°"), column("Längengrad", "°"))
    assert {signal: each.channels for signal, each in found.items()} == {
        "latitude": ("Breitengrad",),
        "longitude": ("Längengrad",),
    }


def test_a_logger_s_upright_axis_is_the_yaw_rate_and_its_level_ones_are_left_alone():
    x, y, z = (column(f"{axis}_rate_of_rotation", "deg/s") for axis in "xyz")
    assert {signal: each.channels[0] for signal, each in best(x, y, z).items()} == {"yaw_rate": z.name}
    assert "which axis" in unmapped_reason(x)
    assert "which axis" in unmapped_reason(y)
    assert best(column("z_rate_of_rotation")) == {}
    assert set(best(column("satellites", "sats"))) == {"satellites"}


def test_text_where_a_signal_was_expected_is_said():
    def text(name, kind="text"):
        return ChannelInfo(name, "table", None, kind=kind, tags={"column": name})

    said = propose_and_say(
        [text("latitude"), text("longitude"), text("gear"), text("accel_x", "number")], None
    )[1]
    assert said == (
        "left out, since the column holds text and no numbers: latitude (latitude), longitude (longitude)",
    )
    # another column has it
    assert propose_and_say([text("latitude_text"), text("accel_y", "number"), text("ay")], None)[1] == ()
