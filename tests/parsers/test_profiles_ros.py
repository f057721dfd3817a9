"""The mapping of ROS message types and of JSON fields without a known type, by the built-in profile."""

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import bind, propose, unmapped_reason


def ros(topic, kind, field, unit=None):
    tags = {"topic": topic, "type": kind, "field": field}
    return ChannelInfo(f"{topic}.{field}", topic, unit, "ros", tags=tags)


def mapped(*channels):
    return {signal: found[0] for signal, found in propose(channels, None).items()}


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
