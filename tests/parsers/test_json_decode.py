"""JSON payloads: every value equals what Python's json reads, and damaged ones are counted and cost only themselves."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import LogError
from parsers.json_decode import (
    SAMPLES,
    NewKeys,
    make_json_decoder,
)
from tests.parsers.json_payloads import decode


def values(texts: Sequence[str]) -> list[float]:
    """The numbers that stand in {"x": …}."""
    payloads = [f'{{"x": {text}}}'.encode() for text in texts]
    decoded = decode(make_json_decoder(b"", [b'{"x": 1}']), payloads)
    assert decoded.bad == 0
    return decoded.columns["x"].tolist()


def test_numbers_are_the_nearest_float64() -> None:
    rng = random.Random(5)
    texts = [repr(rng.gauss(0, 1) * 10.0 ** rng.randint(-300, 300)) for _ in range(3000)]
    texts += [repr(rng.uniform(-100, 100)) for _ in range(3000)]
    texts += [f"{rng.uniform(-100, 100):.{rng.randint(0, 8)}f}" for _ in range(1000)]
    texts += [str(rng.randint(-(10**25), 10**25)) for _ in range(200)]
    texts += [
        "0",
        "-0",
        "0.0",
        "-0.0",
        "1E5",
        "1e+05",
        "2e-7",
        "9007199254740993",
        "9007199254740992",
        "1e22",
        "1e23",
    ]
    texts += ["123456789012345678", "1234567890123456789", "0.1e-400", "5e-324", "1.7976931348623157e308"]
    texts += ["0." + "0" * 40 + "123", "0." + "1" * 60, "1" * 60 + ".5", "0e99999999999", "1e-99999999999"]
    found = values(texts)
    expected = [float(text) for text in texts]
    assert [x.hex() for x in found] == [x.hex() for x in expected]


def test_words_and_texts() -> None:
    found = values(["true", "false", "null", "NaN", "Infinity", "-Infinity", '"12"', "{}", "[]", "1e999"])
    np.testing.assert_array_equal(
        found, [1, 0, np.nan, np.nan, np.inf, -np.inf, np.nan, np.nan, np.nan, np.inf]
    )


MESSAGES: list[Any] = [
    {
        "header": {"stamp": {"sec": 1_700_000_000, "nanosec": 5}},
        "a": {"b": [1, 2.5, -3]},
        "ok": True,
        "s": "t{[,",
    },
    {"a": {"b": [], 'ä\n"k"': 7}, "list": [{"v": 1}, {"v": 2, "w": 3}], "ok": None, "s": ""},
    {"a": {"b": list(range(12))}, "header": {"stamp": {"sec": 3, "nanosec": 999_999_999}}},
    {"a": 4, "mixed": [1, "x", [5], {"y": 6}]},
]


def peer_value(message: Any, path: str) -> float:
    """What Python's json has at a path of ours (no key here has a dot in it)."""
    for part in path.replace("[", ".[").split("."):
        if part.startswith("["):
            k = int(part[1:-1])
            message = message[k] if isinstance(message, list) and k < len(message) else None
        else:
            message = message.get(part) if isinstance(message, dict) else None
    return float(message) if isinstance(message, (int, float)) else math.nan


@pytest.mark.parametrize(
    "style", [{}, {"indent": 2}, {"separators": (",", ":")}, {"ensure_ascii": False}, {"indent": "\t"}]
)
def test_every_value_equals_the_library(style: dict[str, Any]) -> None:
    payloads = [json.dumps(message, **style).encode() for message in MESSAGES]
    decoder = make_json_decoder(b"", payloads)
    decoded = decode(decoder, payloads)
    assert decoded.bad == 0
    assert {"a.b[7]", "list[1].w", "mixed[2][0]", "mixed[3].y", 'a.ä\n"k"', "a", "ok"} <= set(decoded.columns)
    assert "a.b[8]" not in decoded.columns
    for path, column in decoded.columns.items():
        np.testing.assert_array_equal(column, [peer_value(m, path) for m in MESSAGES], err_msg=path)
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [1_700_000_000 * 10**9 + 5, 0, 3_999_999_999, 0]
    assert [info.path for info in decoder.fields if info.kind == "text"] == ["s", "mixed[1]"]
    assert decoder.notes == ()


def test_only_wanted_columns() -> None:
    payloads = [json.dumps(message).encode() for message in MESSAGES]
    decoder = make_json_decoder(b"", payloads)
    decoded = decode(decoder, payloads, ["list[1].w", "nothing", "a.b[1]"])
    assert list(decoded.columns) == ["list[1].w", "nothing", "a.b[1]"]
    np.testing.assert_array_equal(decoded.columns["a.b[1]"], [2.5, np.nan, 1, np.nan])
    assert np.isnan(decoded.columns["nothing"]).all()


@pytest.mark.parametrize(
    "stamp", [{"sec": 12, "nsec": 34}, {"nsecs": 34, "secs": 12}, {"seconds": 12, "nanos": 34}]
)
@pytest.mark.parametrize("name", ["timestamp", "stamp"])
def test_stamps_of_other_dialects(stamp: dict[str, int], name: str) -> None:
    payload = json.dumps({name: stamp, "x": 1}).encode()
    decoder = make_json_decoder(b"", [payload])
    wanted = ["x"]
    stamps = decode(decoder, [payload, b'{"x":1}', b'{"%s":{}}' % name.encode()], wanted).stamp_ns
    assert stamps is not None
    assert stamps.tolist() == [12_000_000_034, 0, 0]


def test_keys_that_come_later_are_noted() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1, "later": null}'])
    found = NewKeys()
    first = decode(decoder, [b'{"a": 2, "later": null, "x": null}'])
    found.add(first)
    assert first.bad == 0
    assert found.notes == decoder.notes == ()
    found.add(decode(decoder, [b'{"a": 2, "new one": 1}', b'{"later": 5}']))
    found.add(decode(decoder, [b'{"other": 5}']))
    assert "(3 times, the first is 'new one')" in found.notes[0]


BROKEN = [
    b"", b" ", b"{", b"}", b'{"a"', b'{"a":', b'{"a":1', b'{"a":1,}', b'{"a" 1}', b"{a:1}", b'{"a":1}}', b'{"a":01}',
    b'{"a":1.}', b'{"a":.5}', b'{"a":-}', b'{"a":1e}', b'{"a":+1}', b'{"a":tru}', b'{"a":nulls}', b'{"a":[1,]}',
    b'{"a":[1 2]}', b'{"a":[}', b'{"a":{]}', b'{"a":1}{"a":2}', b'{"a":"x}', b'{"a":"x\\"}', b"[" * 5000, b'{"a":1]',
    b'{"a":1 "b":2}', b'{,"a":1}', b"[,1]", b'{"a":--1}', b'{"a":0x10}', b'{"a":1;}',
]  # fmt: skip


@pytest.mark.parametrize("broken", BROKEN)
def test_broken_payloads_are_counted_and_leave_the_others(broken: bytes) -> None:
    with pytest.raises((json.JSONDecodeError, RecursionError)):
        json.loads(broken)
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    decoded = decode(decoder, [b'{"a": 0.12345678901234567}', broken, b'{"a": 3.1415926535897932384}'])
    assert decoded.bad == 1
    np.testing.assert_array_equal(
        decoded.columns["a"], [0.12345678901234567, math.nan, 3.1415926535897932384]
    )


def test_number_before_the_break_does_not_stay() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    decoded = decode(decoder, [b'{"a": 0.12345678901234567890, "b": ', b'{"a": 2}'])
    np.testing.assert_array_equal(decoded.columns["a"], [math.nan, 2])


def test_what_writers_put_around_a_message() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    decoded = decode(
        decoder, [b'\xef\xbb\xbf{"a":1}', b'{"a":2}\0\0', b'\r\n {"a":3} \n', b'{"t":"a\nb","a":4}']
    )
    assert decoded.bad == 0
    assert decoded.columns["a"].tolist() == [1, 2, 3, 4]


def test_repeated_keys_last_one_holds() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    payloads = [b'{"a":1,"a":2}', b'{"a":0.12345678901234567,"a":3}', b'{"a":3,"a":0.12345678901234567}']
    payloads += [b'{"a":0.12345678901234567,"a":0.22345678901234567}']
    decoded = decode(decoder, payloads)
    assert decoded.columns["a"].tolist() == [json.loads(p)["a"] for p in payloads]


def test_nothing_to_decode() -> None:
    with pytest.raises(LogError, match="field"):
        make_json_decoder(b"", [b"{}", b"broken", b'{"a": null}'])
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    assert decode(decoder, []).columns["a"].shape == (0,)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text('abcé\\"', max_size=3), inner, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(
    st.lists(
        st.dictionaries(st.sampled_from(["a", "b", "é"]), json_values, min_size=1), min_size=1, max_size=4
    )
)
def test_any_message_equals_the_library(messages: list[dict[str, Any]]) -> None:
    payloads = [json.dumps(m).encode() for m in messages]
    try:
        decoder = make_json_decoder(b"", payloads)
    except LogError:
        return
    decoded = decode(decoder, payloads)
    assert decoded.bad == 0
    assert decoded.new_keys == 0
    for path, column in decoded.columns.items():
        np.testing.assert_array_equal(column, [peer_value(m, path) for m in messages], err_msg=path)


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.text('{}[]",:01.e-+atrufnl\\ \n', max_size=30) | st.binary(max_size=30).map(repr), max_size=5)
)
def test_random_text_never_crashes_and_agrees_on_what_is_json(texts: list[str]) -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    payloads = [text.encode() for text in texts]
    good = 0
    for text in texts:
        try:
            json.loads(text, strict=False)
            good += 1
        except ValueError:
            pass
    # an escape that JSON does not have is taken here, as it cannot change a number
    assert good <= len(texts) - decode(decoder, payloads).bad <= good + sum("\\" in t for t in texts)


def _messages_of_changing_shape(rng: random.Random, missing: float) -> list[dict[str, Any]]:
    messages = []
    for i in range(400):
        keys = [key for key in "abcdef" if rng.random() >= missing]
        if rng.random() < missing:
            rng.shuffle(keys)
        message: dict[str, Any] = {
            key: rng.choice([round(rng.gauss(0, 9), 6), rng.gauss(0, 1), i, None, True, 10**25, -1e-9])
            for key in keys
        }
        message["name"] = rng.choice(["imu", 'a"b', "ü" * (i % 9), "\\", "\n\u2028", ""])
        message["in"] = {"list": [i / 7, i, -0.0], "t": {"x": rng.random() * 1e30}}
        messages.append(message)
    return messages


@pytest.mark.parametrize("missing", [0.0, 0.01, 0.3])
@pytest.mark.parametrize("style", [{}, {"ensure_ascii": False, "separators": (",", ":")}, {"indent": 1}])
def test_messages_of_the_same_shape_and_of_others(missing: float, style: dict[str, Any]) -> None:
    """Most messages have the text of the one before between their values; some have not."""
    messages = _messages_of_changing_shape(random.Random(7), missing)
    payloads = [json.dumps(message, **style).encode() for message in messages]
    decoder = make_json_decoder(b"", payloads[:SAMPLES])
    decoded = decode(decoder, payloads)
    assert decoded.bad == 0
    assert {"a", "f", "in.list[2]", "in.t.x"} <= set(decoded.columns)
    for path, column in decoded.columns.items():
        np.testing.assert_array_equal(column, [peer_value(m, path) for m in messages], err_msg=path)
    few = decode(decoder, payloads, ["c", "in.t.x"])
    np.testing.assert_array_equal(few.columns["c"], decoded.columns["c"])


def test_broken_messages_between_those_of_one_shape() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1, "b": 2}'])
    good = b'{"a": 1.5, "b": 2}'
    payloads: list[bytes] = []
    for broken in BROKEN:
        payloads += [good, good, broken]
    payloads += [good] * 5
    decoded = decode(decoder, payloads)
    assert decoded.bad == len(BROKEN)
    expected = [math.nan if payload in BROKEN else 1.5 for payload in payloads]
    np.testing.assert_array_equal(decoded.columns["a"], expected)


def test_a_number_ends_where_its_message_ends() -> None:
    """The bytes behind a message are those of the next one: digits there are not its own."""
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    text = b'{"a": 12345}{"a": 1}{"a": 2}' + b" " * 64
    offset, length = np.array([12, 20, 0, 20, 0]), np.array([8, 8, 8, 8, 12])
    decoded = decoder.decode(np.frombuffer(text, dtype=np.uint8), offset, length, ["a"])
    np.testing.assert_array_equal(decoded.columns["a"], [1, 2, math.nan, 2, 12345])
    # the whole payload is one number: 12 of 12345
    bare = decoder.decode(np.frombuffer(text, dtype=np.uint8), np.array([6, 6]), np.array([2, 5]), ["a"])
    assert bare.bad == 0


def test_new_keys_are_counted_in_messages_of_one_shape() -> None:
    decoder = make_json_decoder(b"", [b'{"a": 1}'])
    payloads = [b'{"a": %d, "new": %d}' % (i, i) for i in range(50)] + [b'{"a": 1, "new": null}'] * 3
    decoded = decode(decoder, payloads)
    assert (decoded.new_keys, decoded.first_new_key) == (50, "new")
    assert decoded.columns["a"].tolist() == [*range(50), 1, 1, 1]


@settings(max_examples=200, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False) | st.decimals(allow_nan=False, allow_infinity=False))
def test_any_number_is_the_nearest_float64(value: Any) -> None:
    text = str(value).replace("E+", "e+")
    # three of them: the first gives the shape, the last is too near the end of the data to be read quickly
    assert [x.hex() for x in values([text] * 3)] == [float(text).hex()] * 3
