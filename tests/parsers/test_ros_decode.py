"""ROS messages in bulk, against rosbags' own decoding of every single one."""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ros_messages import run
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.ros.contract import Decoded, MessageDecoder
from parsers.ros.decoder import make_decoder, make_standard_decoder
from parsers.ros.fields import Encoding

ROS1 = get_typestore(Stores.ROS1_NOETIC)
ROS2 = get_typestore(Stores.ROS2_HUMBLE)
STRINGS = ("", "a", "base_link", "ein längerer Text", "x" * 37)


def value_of(store: Any, desc: Any, rng: np.random.Generator) -> Any:
    """A random value for one of rosbags' field descriptions."""
    kind, what = desc[0].name, desc[1]
    if kind == "BASE":
        return scalar_of(what[0], rng)
    if kind == "NAME":
        return message_of(store, what, rng)
    inner, size = what
    count = size if kind == "ARRAY" else int(rng.integers(0, 12))
    values = [value_of(store, inner, rng) for _ in range(count)]
    if inner[0].name == "BASE" and inner[1][0] != "string":
        dtype = {"byte": "int8", "char": "uint8", "bool": "bool"}.get(inner[1][0], inner[1][0])
        return np.array(values, dtype=dtype)
    return values


def scalar_of(name: str, rng: np.random.Generator) -> Any:
    if name == "string":
        return str(rng.choice(STRINGS))
    if name == "bool":
        return bool(rng.integers(0, 2))
    if name.startswith("float"):
        return float(np.float32(rng.normal(scale=100.0)))
    if name == "byte":  # an octet in ROS 2 (where rosbags has it signed), signed in ROS 1: alike below 128
        return int(rng.integers(0, 128))
    info = np.iinfo("uint8" if name == "char" else name)
    return int(rng.integers(info.min, info.max, endpoint=True, dtype=info.dtype))


def message_of(store: Any, name: str, rng: np.random.Generator) -> Any:
    if name.endswith(("/Time", "/Duration")):
        return store.types[name](int(rng.integers(1, 2**31)), int(rng.integers(0, 10**9)))
    fields = store.fielddefs[name][1]
    return store.types[name](*[value_of(store, desc, rng) for _, desc in fields])


def expected(message: Any, path: str) -> float:
    """The number at a field path of a decoded message, NaN where there is none."""
    value = message
    for part in path.replace("[", ".[").split("."):
        if part.startswith("["):
            index = int(part[1:-1])
            if index >= len(value):
                return math.nan
            value = value[index]
        else:
            value = getattr(value, part)
    if hasattr(value, "nanosec"):
        return float(value.sec + value.nanosec * 1e-9)
    return float(value)


def numbers(decoder: MessageDecoder) -> list[str]:
    return [info.path for info in decoder.fields if info.kind == "number"]


def compare(
    store: Any, name: str, decoder: MessageDecoder, payloads: list[bytes], messages: list[Any]
) -> Decoded:
    """All numbers, read together and some of them alone, equal the messages'; what was read."""
    wanted = numbers(decoder)
    decoded = run(decoder, payloads, wanted)
    assert decoded.bad == 0
    for path in wanted:
        np.testing.assert_array_equal(
            decoded.columns[path], [expected(m, path) for m in messages], err_msg=path
        )
    for path in wanted[:: max(1, len(wanted) // 5)]:
        alone = run(decoder, payloads, [path])
        np.testing.assert_array_equal(alone.columns[path], decoded.columns[path], err_msg=path)
    return decoded


def payloads_of(store: Any, name: str, encoding: str, messages: list[Any]) -> list[bytes]:
    if encoding == "ros1":
        return [bytes(store.serialize_ros1(m, name)) for m in messages]
    return [bytes(store.serialize_cdr(m, name, little_endian=i % 3 != 1)) for i, m in enumerate(messages)]


TYPES = (
    "sensor_msgs/msg/Imu",
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/TwistStamped",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/PointCloud2",
    "nav_msgs/msg/Path",
    "diagnostic_msgs/msg/DiagnosticArray",
    "tf2_msgs/msg/TFMessage",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Header",
    "std_msgs/msg/Float64MultiArray",
    "visualization_msgs/msg/Marker",
)


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
def test_every_value_of_standard_types_equals_the_peers(name: str, encoding: Encoding) -> None:
    store = ROS1 if encoding == "ros1" else ROS2
    if name not in store.fielddefs:
        pytest.skip(f"{name} is not in rosbags' types of this ROS version")
    definition, _ = store.generate_msgdef(name, ros_version=1 if encoding == "ros1" else 2)
    rng = np.random.default_rng(len(name))
    messages = [message_of(store, name, rng) for _ in range(12)]
    decoder = make_decoder(name, definition, encoding)
    compare(store, name, decoder, payloads_of(store, name, encoding, messages), messages)
    standard = make_standard_decoder(name, encoding)
    assert standard is not None
    assert list(standard.fields) == list(decoder.fields)


@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
def test_an_array_of_forty_numbers_is_reachable_whole(encoding: Encoding) -> None:
    """A logger that puts all of its values into one array, as mapping files name them."""
    store, name = (ROS1 if encoding == "ros1" else ROS2), "std_msgs/msg/Float64MultiArray"
    messages = [message_of(store, name, np.random.default_rng(1)) for _ in range(3)]
    for i, message in enumerate(messages):
        message.data = np.arange(40.0) + 100 * i
    decoder = make_standard_decoder(name, encoding)
    assert decoder is not None
    decoded = compare(store, name, decoder, payloads_of(store, name, encoding, messages), messages)
    assert decoded.columns["data[39]"].tolist() == [39.0, 139.0, 239.0]


CUSTOM = """\
# a type of nobody's package
Header header
string name
uint8 MODE_OFF=0
string GREETING=hello # there
bool on
float32[3] small
Wheel[] wheels
Wheel[2] axles
int16[<=5] trims
string[] labels
string[2] two
byte b
char c
duration age
time[] marks
float64 last
================================================================================
MSG: my_car/Wheel
string<=9 corner
float64 speed
uint8 state
float32[] slip
Spring[] springs
================================================================================
MSG: my_car/Spring
int8 id
float64 force
================================================================================
MSG: std_msgs/Header
time stamp
string frame_id
"""


@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
def test_custom_nested_type_with_texts_and_sequences(encoding: Encoding) -> None:
    name = "my_car/msg/State"
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(CUSTOM, "my_car/State"))
    rng = np.random.default_rng(5)
    messages = [message_of(store, name, rng) for _ in range(40)]
    for message in messages:
        message.trims = message.trims[:5]
    decoder = make_decoder("my_car/State", CUSTOM.replace("\n", "\r\n"), encoding)
    paths = numbers(decoder)
    assert {"wheels[3].springs[1].force", "axles[1].slip[7]", "trims[4]", "marks[0]", "age"} <= set(paths)
    assert "wheels[4].speed" not in paths
    texts = {info.path for info in decoder.fields if info.kind == "text"}
    assert {"header.frame_id", "name", "labels", "two", "wheels[0].corner"} <= texts
    compare(store, name, decoder, payloads_of(store, name, encoding, messages), messages)
    decoded = run(decoder, payloads_of(store, name, encoding, messages), ["last"])
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == stamps


PRIMITIVES = [
    "bool",
    "int8",
    "uint8",
    "int16",
    "uint16",
    "int32",
    "uint32",
    "int64",
    "uint64",
    "float32",
    "float64",
    "string",
    "time",
    "Inner",
]
FIELDS = st.lists(
    st.tuples(st.sampled_from(PRIMITIVES), st.sampled_from(["", "[]", "[1]", "[3]"])), min_size=1, max_size=7
)


def definition_of(outer: list[tuple[str, str]], inner: list[tuple[str, str]]) -> str:
    lines = [f"{kind}{shape} f{i}" for i, (kind, shape) in enumerate(outer)]
    lines += ["=" * 80, "MSG: pkg/Inner"]
    lines += [f"{'int16' if kind == 'Inner' else kind}{shape} g{i}" for i, (kind, shape) in enumerate(inner)]
    return "\n".join(lines) + "\n"


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(outer=FIELDS, inner=FIELDS, seed=st.integers(0, 2**31), encoding=st.sampled_from(["ros1", "cdr"]))
def test_any_type_round_trips(
    outer: list[tuple[str, str]], inner: list[tuple[str, str]], seed: int, encoding: Encoding
) -> None:
    text = definition_of(outer, inner)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, "pkg/Outer"))
    rng = np.random.default_rng(seed)
    messages = [message_of(store, "pkg/msg/Outer", rng) for _ in range(5)]
    decoder = make_decoder("pkg/Outer", text, encoding)
    payloads = payloads_of(store, "pkg/msg/Outer", encoding, messages)
    decoded = compare(store, "pkg/msg/Outer", decoder, payloads, messages)
    assert decoded.bad == 0
    assert set(decoded.columns) == set(numbers(decoder))
    assert {column.shape for column in decoded.columns.values()} <= {(5,)}


@pytest.mark.parametrize("encoding", ["ros1", "cdr"])
def test_no_damage_crashes_or_goes_unseen(encoding: Encoding) -> None:
    name = "diagnostic_msgs/msg/DiagnosticArray"
    store = ROS1 if encoding == "ros1" else ROS2
    rng = np.random.default_rng(1)
    message = message_of(store, name, rng)
    while len(message.status) < 2:
        message = message_of(store, name, rng)
    good = payloads_of(store, name, encoding, [message])[0]
    decoder = make_standard_decoder(name, encoding)
    assert decoder is not None
    short = [good[:n] for n in range(len(good) - 4)]
    assert run(decoder, short, numbers(decoder)).bad == len(short)
    long = [good + b"\0" * 4]
    assert run(decoder, long, numbers(decoder)).bad == 1
    noisy = []
    for _ in range(2000):
        raw = bytearray(good)
        for at in rng.integers(0, len(raw), 4):
            raw[at] = int(rng.choice([0, 1, 127, 128, 255]))
        noisy.append(bytes(raw))
    decoded = run(decoder, [*noisy, good], ["header.stamp", "status[1].level"])
    assert 0 < decoded.bad < 2000
    assert decoded.columns["status[1].level"][-1] == float(message.status[1].level)


def test_payloads_outside_the_buffer_are_bad() -> None:
    decoder = make_decoder("std_msgs/Float64", "float64 data", "ros1")
    data = np.frombuffer(struct.pack("<d", 2.5), dtype=np.uint8)
    offset = np.array([0, 1, -8, 8, 2**62, -(2**63), 0])
    length = np.array([8, 8, 8, 8, 2**62, 8, -8])
    decoded = decoder.decode(data, offset, length, ["data"])
    assert decoded.bad == 6
    assert decoded.columns["data"][0] == 2.5
    assert np.isnan(decoded.columns["data"][1:]).all()


def test_huge_counts_end_at_once() -> None:
    text = "Nothing[] a\nfloat64[] b\n" + "=" * 80 + "\nMSG: p/Nothing\nuint8 K=1\n"
    decoder = make_decoder("p/T", text, "ros1")
    fine = struct.pack("<IIdd", 2**32 - 1, 2, 1.5, 2.5)
    huge = struct.pack("<IIdd", 0, 2**32 - 1, 1.5, 2.5)
    decoded = run(decoder, [fine, huge], ["b[1]"])
    assert decoded.bad == 1
    assert decoded.columns["b[1]"][0] == 2.5
