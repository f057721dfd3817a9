"""A magnitude whose sign is a channel of its own is taken with it."""

import math

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import bind, propose


def can(message, signal, unit=None):
    return ChannelInfo(
        f"{message}.{signal}", message, unit, "can", tags={"message": message, "signal": signal}
    )


def column(name, unit=None):
    return ChannelInfo(name, "table", unit, "table", tags={"column": name})


SIGNS = [
    "SteeringWheelAngle_Sign",
    "SteeringWheelAngleSign",
    "VZ_SteeringWheelAngle",
    "steering_wheel_angle_sign",
]


@pytest.mark.parametrize("name", SIGNS)
def test_the_sign_of_the_same_message_is_taken(name):
    found = propose([can("Steer", "SteeringWheelAngle", "deg"), can("Steer", name)], None)
    binding = found["steering_wheel_angle"][0]
    assert binding.sign_channel == f"Steer.{name}"
    assert "sign by" in binding.rule
    rows = {"Steer.SteeringWheelAngle": np.array([10.0, 10.0]), f"Steer.{name}": np.array([0.0, 1.0])}
    assert np.allclose(bind(binding, rows), np.deg2rad([10.0, -10.0]))


def test_the_sign_of_a_column_is_taken():
    found = propose([column("Ay", "g"), column("Ay Sign")], None)
    assert found["accel_y"][0].sign_channel == "Ay Sign"


@pytest.mark.parametrize(
    "other",
    [
        can("Other", "SteeringWheelAngle_Sign"),
        can("Steer", "SteeringWheelSpeed_Sign"),
        can("Steer", "SteeringWheelAngle_Signal"),
        can("Steer", "Sign"),
    ],
    ids=lambda channel: channel.name,
)
def test_others_are_not(other):
    found = propose([can("Steer", "SteeringWheelAngle", "deg"), other], None)
    assert found["steering_wheel_angle"][0].sign_channel is None


@pytest.mark.parametrize(
    ("values", "sign", "expected"),
    [
        ([3.0, 4.0], [0.0, 1.0], [3.0, -4.0]),
        ([3.0, 4.0], [0.0, -1.0], [3.0, math.nan]),
        ([3.0, -4.0], [0.0, 1.0], [3.0, -4.0]),
        ([3.0, -4.0], [1.0, 0.0], [-3.0, 4.0]),
    ],
    ids=["magnitude", "no flag", "signed already", "signed, the other way round"],
)
def test_no_sign_takes_one_away(values, sign, expected):
    """The last is turned by the checks; a magnitude would be lost."""
    (binding,) = propose([column("Ay", "m/s2"), column("Ay Sign")], None)["accel_y"]
    found = bind(binding, {"Ay": np.array(values), "Ay Sign": np.array(sign)})
    assert np.array_equal(found, expected, equal_nan=True)


def test_what_is_never_negative_has_no_sign():
    found = propose([column("Brake Pressure", "bar"), column("Brake Pressure Sign")], None)
    assert found["brake_pressure"][0].sign_channel is None
