"""What stands around a name: plans, commands and other traffic are not this vehicle, and a path's end is no column."""

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose, unmapped_reason


def column(name, unit=None):
    return ChannelInfo(name, "table", unit, "table", tags={"column": name})


def ros(topic, kind, field, unit=None):
    tags = {"topic": topic, "type": kind, "field": field}
    return ChannelInfo(f"{topic}.{field}", topic, unit, "ros", tags=tags)


def can(message, signal, unit):
    tags = {"message": message, "signal": signal}
    return ChannelInfo(f"{message}.{signal}", message, unit, "can", tags=tags)


def best(*channels):
    return {signal: found[0].channels[0] for signal, found in propose(channels, None).items()}


IMU = ros("/imu/data", "sensor_msgs/Imu", "angular_velocity.z")


def test_a_field_spelt_like_a_signal_comes_behind_a_known_sensor_message():
    for field in ("yaw_rate", "yaw_rate_radps"):
        state = ros("/lat/state", "my_msgs/State", field)
        assert best(state, IMU) == {"yaw_rate": IMU.name}
        assert best(state) == {"yaw_rate": state.name}


def test_only_a_column_at_the_top_of_a_table_ranks_first():
    for family in ("table", "mdf"):
        known = ChannelInfo("KINEMATICS.YAW_RATE", "t", "deg/s", family)
        whole = ChannelInfo("yaw_rate", "t", "deg/s", family)
        part = ChannelInfo("Foo.yaw_rate", "t", "deg/s", family)
        assert best(known, whole) == {"yaw_rate": "yaw_rate"}
        assert best(part, known) == {"yaw_rate": known.name}


@pytest.mark.parametrize(
    ("topic", "kind", "field"),
    [
        ("/planner/state", "plan_msgs/State", "yaw_rate"),
        ("/state", "plan_msgs/PlannerState", "yaw_rate"),
        ("/obstacles", "my_msgs/List", "items[0].yaw_rate"),
        ("/perception", "autoware_perception_msgs/PredictedObjects", "yaw_rate"),
        ("/reference/state", "my_msgs/State", "yaw_rate"),
        ("/desired", "my_msgs/State", "yaw_rate"),
        ("/target/twist", "geometry_msgs/TwistStamped", "twist.angular.z"),
        ("/trailer/imu", "sensor_msgs/Imu", "angular_velocity.z"),
        ("/opp_racecar/odom", "nav_msgs/Odometry", "twist.twist.angular.z"),
        ("/objects", "my.List", "objects[2].angular_velocity.z"),
    ],
)
def test_plans_and_other_traffic_are_never_this_vehicle(topic, kind, field):
    channel = ros(topic, kind, field)
    assert best(channel) == {}
    assert "not a measurement of this vehicle's yaw_rate" in unmapped_reason(channel)


def test_what_json_calls_any_message_is_no_other_road_user():
    for kind in ("object", "json_object"):
        channel = ChannelInfo(
            "/v.speed", "/v", "m/s", "json", tags={"topic": "/v", "type": kind, "field": "speed"}
        )
        assert best(channel) == {"speed": "/v.speed"}


def test_a_reference_instrument_in_a_message_is_measured():
    for topic in ("/reference/imu", "/ref_ins/imu"):
        assert list(best(ros(topic, "sensor_msgs/Imu", "angular_velocity.z"))) == ["yaw_rate"]


@pytest.mark.parametrize(
    "channel",
    [
        ros("/vehicle/status", "my_msgs/Status", "yaw_rate"),
        can("ESP_Status", "YawRate", "deg/s"),
        column("Vehicle.Status.YawRate", "deg/s"),
    ],
)
def test_a_message_called_status_holds_measurements(channel):
    assert best(channel) == {"yaw_rate": channel.name}


@pytest.mark.parametrize("name", ["YawRate_Status", "ESP.YawRateStatus"])
def test_a_status_itself_is_none(name):
    assert best(column(name, "deg/s")) == {}


@pytest.mark.parametrize(
    "name",
    [
        "Target1.YawRate",
        "Obj3.YawRate",
        "Track05.YawRate",
        "Trailer2.YawRate",
        "Objects.YawRate",
        "Neighbor.YawRate",
        "leader.speed",
        "front_vehicle.speed",
        "/otherCars[0]/speed",
        "TrafficSign.Speed",
        "Traffic.T00.v",
        "Traffic.T00.roll",
        "Gearbox.Speed",
        "Cabin.RollAngle",
        "Boom.PitchAngle",
        "Camera.Pitch",
        "ACC_Status.Speed",
        "/carControl/actuators/steeringAngleDeg",
        "/carControl/speed",
        "/liveParameters/roll",
        "/road/geometry.roll",
    ],
)
def test_what_is_not_this_vehicles_body_blocks(name):
    unit = {"v": "m/s", "Speed": "km/h", "YawRate": "deg/s"}.get(name.rpartition(".")[2])
    assert best(column(name, unit)) == {}
    assert "no profile knows it" not in unmapped_reason(column(name, unit))
    if name.count(".") == 1:
        assert best(can(*name.split("."), unit or "deg")) == {}


@pytest.mark.parametrize(
    "name", ["VehicleDynamicsControl.YawRate", "Brake_Controller1.YawRate", "Chassis1.YawRate"]
)
def test_units_that_control_measure_too(name):
    assert list(best(can(*name.split("."), "deg/s"))) == ["yaw_rate"]


def test_theta_beside_x_and_y_is_a_heading():
    for unit in (None, "rad"):
        for others in (("x", "y"), ("x", "y", "phi"), ("pos_x [m]", "pos_y [m]"), ()):
            assert "pitch" not in best(*map(column, others), column("theta", unit))
        pose = [ros("/pose", "geometry_msgs/Pose2D", field) for field in ("x", "y", "theta")]
        assert best(*pose) == {}
    assert "heading" in unmapped_reason(column("theta", "rad"))


def test_theta_beside_psi_or_phi_is_pitch():
    assert best(column("phi"), column("theta"))["pitch"] == "theta"
    assert best(*map(column, ("x", "y", "z", "phi", "theta", "psi")))["pitch"] == "theta"
    assert best(column("psi_dot"), column("theta_dot", "rad/s"))["pitch_rate"] == "theta_dot"


def test_velocity_along_an_axis_needs_the_vehicles_own_frame():
    for name in ("velocity.x", "hero.velocity_x", "Velocity X"):
        assert best(column(name)) == {}
        assert "own axis" in unmapped_reason(column(name))
    assert list(best(column("body.velocity.x"))) == ["speed"]
    assert list(best(column("vx"))) == ["speed"]


@pytest.mark.parametrize("family", ["table", "mdf"])
def test_a_device_behind_a_name_is_no_part_of_it(family):
    names = ("YawRate\\ETKC:1", "VehSpd\\CAN-Monitoring:1", "accel_y\\XETK:2 [g]")
    channels = [ChannelInfo(name, "t", None, family, tags={"column": name}) for name in names]
    assert best(*channels) == {"yaw_rate": names[0], "speed": names[1], "accel_y": names[2]}
    assert best(column("Target1\\YawRate\\ETKC:1", "deg/s")) == {}
