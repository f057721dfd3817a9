"""Message types of vehicles that no ROS distribution's own packages hold, and that a log without definitions needs.

ROS 2 wrote no definitions into SQLite bags before Iron; a bag of one of these types would then be a bag of bytes. Sources: the
packages' own .msg files (can_msgs of ros_canopen, Autoware's vehicle interface).
"""

from __future__ import annotations

from parsers.ros.fields import FieldSpec, full_name
from parsers.ros.plain_msg import plain_fields

_FRAME = """
std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
"""
_VELOCITY = """
std_msgs/Header header
float32 longitudinal_velocity
float32 lateral_velocity
float32 heading_rate
"""
_STEERING = """
builtin_interfaces/Time stamp
float32 steering_tire_angle
"""
_TEXTS = {
    "can_msgs/msg/Frame": _FRAME,
    "autoware_auto_vehicle_msgs/msg/VelocityReport": _VELOCITY,
    "autoware_auto_vehicle_msgs/msg/SteeringReport": _STEERING,
    "autoware_vehicle_msgs/msg/VelocityReport": _VELOCITY,
    "autoware_vehicle_msgs/msg/SteeringReport": _STEERING,
}


def usual_fields(type_name: str) -> tuple[FieldSpec, ...] | None:
    """The fields of a type that vehicles' packages define, or None for any other."""
    name = full_name(type_name)
    text = _TEXTS.get(name)
    return None if text is None else plain_fields(name, text)
