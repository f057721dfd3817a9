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


def ros(topic, kind, field, unit=None):
    tags = {"topic": topic, "type": kind, "field": field}
    return ChannelInfo(f"{topic}.{field}", topic, unit, "ros", tags=tags)


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


def imu(topic="/imu"):
    fields = [f"{part}.{axis}" for part in ("linear_acceleration", "angular_velocity") for axis in "xyz"]
    fields += [f"orientation.{axis}" for axis in "xyzw"]
    fields += [f"{part}_covariance[0]" for part in ("orientation", "linear_acceleration", "angular_velocity")]
    return [ros(topic, "sensor_msgs/Imu", field) for field in fields]


def test_ros_imu():
    found = mapped(*imu())
    assert set(found) == {
        *("accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch")
    }
    assert found["yaw_rate"].channels == ("/imu.angular_velocity.z",)
    assert found["yaw_rate"].unit_from == "profile ros"
    assert found["roll"].channels == tuple(f"/imu.orientation.{axis}" for axis in "xyzw")
    names = list(found["roll"].needed)
    columns = {name: np.array([0.0, 0.0]) for name in names}
    columns["/imu.orientation.w"] = np.array([1.0, 1.0])
    columns["/imu.orientation_covariance[0]"] = np.array([-1.0, 0.0])
    assert np.isnan(bind(found["roll"], columns)).tolist() == [True, False]


def test_an_imu_of_a_camera_ranks_below():
    found = propose([*imu("/camera/imu"), *imu("/vectornav/imu")], None)
    assert [each.channels[0] for each in found["accel_y"]] == [
        "/vectornav/imu.linear_acceleration.y",
        "/camera/imu.linear_acceleration.y",
    ]


def test_ros_speed_sources_are_ranked():
    found = propose(
        [
            ros("/cmd_vel", "geometry_msgs/Twist", "linear.x"),
            ros("/odom", "nav_msgs/Odometry", "twist.twist.linear.x"),
            ros("/odom", "nav_msgs/Odometry", "twist.twist.angular.z"),
            ros("/vel", "autoware_auto_vehicle_msgs/VelocityReport", "longitudinal_velocity"),
            ros("/vel", "autoware_auto_vehicle_msgs/VelocityReport", "heading_rate"),
            ros("/steer", "autoware_vehicle_msgs/SteeringReport", "steering_tire_angle"),
            ros("/sw", "dbw_mkz_msgs/SteeringReport", "steering_wheel_angle"),
            ros("/w", "dbw_mkz_msgs/WheelSpeedReport", "front_left"),
        ],
        None,
    )
    assert [each.channels[0] for each in found["speed"]] == [
        "/vel.longitudinal_velocity",
        "/odom.twist.twist.linear.x",
    ]
    assert found["yaw_rate"][0].channels == ("/vel.heading_rate",)
    assert found["steering_wheel_angle"][0].channels == ("/sw.steering_wheel_angle",)
    assert "wheel_speed_fl" not in found
    assert "radius" in unmapped_reason(ros("/w", "dbw_mkz_msgs/WheelSpeedReport", "front_left"))
    assert "road wheels" in unmapped_reason(
        ros("/s", "autoware_vehicle_msgs/SteeringReport", "steering_tire_angle")
    )


COMMANDS = [
    ("ackermann_msgs/AckermannDriveStamped", "drive.speed", "m/s"),
    ("ackermann_msgs/AckermannDriveStamped", "drive.steering_angle", "rad"),
    ("ackermann_msgs/AckermannDrive", "speed", None),
    ("carla_msgs/CarlaEgoVehicleControl", "steer", None),
    ("carla_msgs/CarlaEgoVehicleStatus", "control.steer", None),
    ("autoware_auto_control_msgs/AckermannControlCommand", "longitudinal.speed", "m/s"),
    ("autoware_control_msgs/Control", "longitudinal.velocity", None),
    ("autoware_msgs/ControlCommandStamped", "cmd.linear_velocity", None),
    ("px4_msgs/VehicleRatesSetpoint", "yaw_rate", "rad/s"),
]


@pytest.mark.parametrize(
    ("topic", "kind", "path"),
    [
        ("/ublox/fix_velocity", "geometry_msgs/TwistWithCovarianceStamped", "twist.twist."),
        ("/vel", "geometry_msgs/TwistStamped", "twist."),
        ("/nmea/vel", "geometry_msgs/TwistStamped", "twist."),
        ("/mavros/global_position/raw/gps_vel", "geometry_msgs/TwistStamped", "twist."),
        ("/local/enu/twist", "geometry_msgs/Twist", ""),
        ("/gps/odom", "nav_msgs/Odometry", "twist.twist."),
    ],
)
def test_a_receivers_velocity_along_the_worlds_axes_is_its_length(topic, kind, path):
    found = propose([ros(topic, kind, f"{path}linear.{axis}") for axis in "xyz"], None)
    assert set(found) == {"gps_speed_2d"}
    (binding,) = found["gps_speed_2d"]
    x, y = (f"{topic}.{path}linear.{axis}" for axis in "xy")
    assert binding.channels == (x, y)
    east, north = np.array([3.0, -3.0, 0.0, np.nan]), np.array([-4.0, 0.0, 0.0, 1.0])
    np.testing.assert_array_equal(bind(binding, {x: east, y: north}), [5.0, 3.0, 0.0, np.nan])


@pytest.mark.parametrize(
    "topic", ["/vehicle/twist", "/menu/twist", "/velocity", "/gps/velocity_body", "/vel/raw", "/turned/twist"]
)
def test_a_twist_in_body_axes_keeps_its_sign(topic):
    found = propose([ros(topic, "geometry_msgs/TwistStamped", f"twist.linear.{axis}") for axis in "xy"], None)
    assert set(found) == {"speed"}
    assert found["speed"][0].channels == (f"{topic}.twist.linear.x",)


def test_a_fix_that_says_it_is_none_is_no_position():
    fields = ("status.status", "latitude", "longitude", "altitude")
    found = propose([ros("/fix", "sensor_msgs/NavSatFix", field) for field in fields], None)
    # no fix, no fix with an old place, a fix, a fix without a place, a fix on the equator
    columns = {
        "/fix.status.status": np.array([-1.0, -1, 0, 0, 2]),
        "/fix.latitude": np.array([0.0, 48, 48, 0, 0]),
        "/fix.longitude": np.array([0.0, 11, 11, 0, 11]),
        "/fix.altitude": np.array([0.0, 500, 500, 500, 500]),
    }
    values = {name: bind(found[name][0], columns) for name in ("latitude", "longitude", "altitude")}
    np.testing.assert_array_equal(values["latitude"], [np.nan, np.nan, 48, np.nan, 0])
    np.testing.assert_array_equal(values["longitude"], [np.nan, np.nan, 11, np.nan, 11])
    np.testing.assert_array_equal(values["altitude"], [np.nan, np.nan, 500, 500, 500])


@pytest.mark.parametrize(("kind", "field", "unit"), COMMANDS)
def test_what_a_controller_wants_is_no_measurement(kind, field, unit):
    command = ros("/drive", kind, field, unit)
    assert mapped(command) == {}
    assert "command" in unmapped_reason(command)


def test_what_a_simulated_vehicle_measures_beside_its_command_is_mapped():
    assert list(mapped(ros("/ego", "carla_msgs/CarlaEgoVehicleStatus", "velocity", "m/s"))) == ["speed"]


def test_json_fields_without_a_known_type():
    found = mapped(
        ChannelInfo(
            "/i.acc",
            "/i",
            None,
            "json",
            tags={"topic": "/i", "type": "my.Imu", "field": "imu.linearAcceleration.y"},
        ),
        ChannelInfo(
            "/f.lat",
            "/f",
            None,
            "json",
            tags={"topic": "/f", "type": "foxglove.LocationFix", "field": "latitude"},
        ),
    )
    assert set(found) == {"accel_y", "latitude"}


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
