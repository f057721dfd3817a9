"""ROS definitions: IDL, wide texts, times, and what cannot be used."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from ros_messages import run

from parsers.errors import LogError
from parsers.ros.decoder import make_decoder, make_standard_decoder
from parsers.ros.fields import full_name, short_name


def test_cdr_by_hand() -> None:
    """Alignment counts from after the encapsulation; an empty structure is one byte; unknown encapsulations are bad."""
    text = "uint8 a\nEmpty e\nfloat64 x\nuint8 c\nint16[] s\nint64 y\n" + "=" * 80 + "\nMSG: p/Empty\n"
    body = struct.pack("<BBxxxxxxdBxxxIhh", 7, 0, 0.25, 9, 2, -3, 4) + b"\0" * 4 + struct.pack("<q", -5)
    decoder = make_decoder("p/T", text, "cdr")
    decoded = run(
        decoder,
        [b"\0\1\0\0" + body, b"\0\3\0\0" + body, b"\1\1\0\0" + body, b"\0\1\0\0" + body + b"\0\0\0"],
        ["x", "s[0]", "y"],
    )
    assert decoded.bad == 2
    np.testing.assert_array_equal(decoded.columns["y"], [-5, math.nan, math.nan, -5])
    np.testing.assert_array_equal(decoded.columns["s[0]"], [-3, math.nan, math.nan, -3])
    assert decoded.columns["x"][0] == 0.25


@pytest.mark.parametrize("wide", [2, 4])
def test_wide_texts_of_either_width_are_stepped_over(wide: int) -> None:
    decoder = make_decoder("p/T", "wstring<=20 w\nint32 x\n", "cdr")
    body = struct.pack("<I", 3) + b"abc".ljust(3 * wide, b"\0")
    body += b"\0" * (-len(body) % 4) + struct.pack("<i", -9)
    decoded = run(decoder, [b"\0\1\0\0" + body] * 2, ["x"])
    assert decoded.bad == 0
    assert decoded.columns["x"].tolist() == [-9, -9]


def test_times_are_seconds_and_stamps_stay_exact() -> None:
    text = "time stamp\nduration d\n"
    payload = struct.pack("<IIii", 3_000_000_000, 123_456_789, -2, 500_000_000)
    decoded = run(make_decoder("p/T", text, "ros1"), [payload], ["stamp", "d"])
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns[0] == 3_000_000_000_123_456_789
    assert decoded.columns["d"][0] == -1.5
    assert decoded.columns["stamp"][0] == pytest.approx(3_000_000_000.123456789, abs=1e-6)


def test_idl_definition() -> None:
    idl = """\
================================================================================
IDL: pkg/msg/Report
#include "builtin_interfaces/msg/Time.idl"
module pkg { module msg {
  struct Report {
    builtin_interfaces::msg::Time stamp;
    float velocity;
    sequence<double> gaps;
    string text;
    double angle;
  };
}; };
================================================================================
IDL: builtin_interfaces/msg/Time
module builtin_interfaces { module msg {
  struct Time { long sec; unsigned long nanosec; };
}; };
"""
    decoder = make_decoder("pkg/msg/Report", idl, "cdr", "ros2idl")
    body = struct.pack("<iIfI", 5, 7, 1.5, 1) + struct.pack("<dI3sxd", 0.5, 3, b"ab\0", -2.0)
    decoded = run(decoder, [b"\0\1\0\0" + body], ["velocity", "gaps[0]", "gaps[1]", "angle"])
    assert decoded.bad == 0
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [5_000_000_007]
    assert [float(c[0]) for c in decoded.columns.values()] == pytest.approx(
        [1.5, 0.5, math.nan, -2.0], nan_ok=True
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("float64", "cannot be parsed"),
        ("\x00\x01\x02", "cannot be parsed"),
        ("nowhere_msgs/Thing t", "is not defined in the log"),
        ("Own o\n" + "=" * 80 + "\nMSG: p/Own\nOwn again\n", "contains itself"),
        ("uint8[99999999999] x", "array of"),
        ("A[1000000] a\n" + "=" * 80 + "\nMSG: p/A\nfloat64[1000000] x\n", "absurdly large"),
        ("float64 x\n" * 20_100, "too large"),
        ("# long\n" * 300_000, "cannot be right"),
    ],
)
def test_unusable_definitions_are_refused(text: str, words: str) -> None:
    with pytest.raises(LogError, match=words):
        make_decoder("p/T", text, "ros1")


def test_exploding_nesting_is_refused_or_bounded() -> None:
    rule = "=" * 80
    levels = "".join(f"{rule}\nMSG: p/L{i}\nL{i + 1} a\nL{i + 1} b\nL{i + 1}[] c\n" for i in range(30))
    text = "L0 x\n" + levels + f"{rule}\nMSG: p/L30\nfloat64 v\n"
    with pytest.raises(LogError, match=r"too large|nested"):
        make_decoder("p/T", text, "cdr")


def test_names() -> None:
    assert full_name("sensor_msgs/Imu") == full_name("sensor_msgs::msg::Imu") == "sensor_msgs/msg/Imu"
    assert short_name("sensor_msgs/msg/Imu") == "sensor_msgs/Imu"
    assert make_standard_decoder("no_such/Type", "cdr") is None
    assert short_name("p/srv/Do_Request") == "p/srv/Do_Request"
