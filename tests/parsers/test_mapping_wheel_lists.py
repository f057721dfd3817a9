"""Lists of one number for each wheel: taken in the order that the log states, else named with what a mapping file must say."""

from __future__ import annotations

import json
from typing import Any

import pytest

from parsers.channels import ChannelInfo
from parsers.json_decode import make_json_decoder
from parsers.mapping import propose, propose_all, read_map, unmapped_reason
from parsers.mapping.elements import wheels_in_order
from parsers.mapping.overlooked import SAID
from parsers.signals import WHEELS


def places(
    topic: str, field: str, count: int = 4, unit: str | None = None, comment: str = ""
) -> list[ChannelInfo]:
    """The channels of a list; field: with "{}" where the place stands."""
    fields = [field.format(f"[{k}]") for k in range(count)]
    return [
        ChannelInfo(
            f"{topic}.{each}",
            topic,
            unit,
            "json",
            comment=comment,
            tags={"topic": topic, "type": "my.T", "field": each},
        )
        for each in fields
    ]


def said(channels: list[ChannelInfo]) -> list[str]:
    found = propose_all(channels, None)
    return [text for text in (*found.said, *found.unknown) if text.startswith((SAID, "not recognised"))]


@pytest.mark.parametrize(
    ("topic", "field", "count", "named", "signal"),
    [
        ("/wheels", "wheel_speed{}", 4, "wheel speed (/wheels.wheel_speed[0-3])", "wheel_speed"),
        ("/suspension", "travel{}", 8, "suspension deflection (/suspension.travel[0-3])", "suspension_deflection"),
        ("/suspension/travel", "data{}", 64, "suspension deflection (/suspension/travel.data[0-3])", "suspension_deflection"),
        ("/car", "wheels{}.speed", 4, "wheel speed (/car.wheels[0-3].speed)", "wheel_speed"),
        ("/car", "speeds{}", 4, "wheel speed (/car.speeds[0-3])", "wheel_speed"),
    ],
)  # fmt: skip
def test_without_an_order_a_list_is_named_and_not_guessed(
    topic: str, field: str, count: int, named: str, signal: str
) -> None:
    channels = places(topic, field, count)
    assert propose(channels, None) == {}
    (text,) = said(channels)
    assert named in text
    assert f'[signals.{signal}_fl] with channel = "{channels[0].name}"' in text
    if "[0]." not in channels[0].name and topic != "/car":
        assert unmapped_reason(channels[0]).endswith("of one wheel: which, the log does not say")


@pytest.mark.parametrize(
    ("topic", "field", "count"),
    [
        ("/plan", "speeds{}", 8),  # of an open length, and no word of wheels
        ("/car", "wheel_speed{}", 3),
        ("/car", "wheel_speed_cmd{}", 4),
        ("/car", "suspension_state{}", 4),
    ],
)
def test_what_says_too_little_is_not_named(topic: str, field: str, count: int) -> None:
    assert not any(text.startswith(SAID) for text in said(places(topic, field, count)))


def test_nothing_is_said_of_what_the_log_or_a_mapping_file_has(tmp_path: Any) -> None:
    own = [places("/a", f"wheel_speed_{wheel}", 1)[0] for wheel in WHEELS]
    assert not any(text.startswith(SAID) for text in said([*own, *places("/wheels", "wheel_speed{}")]))
    path = tmp_path / "map.toml"
    path.write_text('[signals.wheel_speed_fl]\nchannel = "/wheels.wheel_speed[2]"\nunit = "m/s"\n')
    assert not any(
        text.startswith(SAID) for text in propose_all(places("/wheels", "wheel_speed{}"), read_map(path)).said
    )


@pytest.mark.parametrize(
    ("text", "order"),
    [
        ("fl, fr, rl, rr", "fl fr rl rr"),
        ("travel of each wheel: rear left, rear right, front left and front right [m]", "rl rr fl fr"),
        ("VL/VR/HL/HR", "fl fr rl rr"),
        ("order RR RL FR FL", "rr rl fr fl"),
        ("fl, fr", ""),
        ("fl, fr, rl, fl", ""),
        ("front to rear", ""),
    ],
)
def test_an_order_in_words(text: str, order: str) -> None:
    assert wheels_in_order(text) == tuple(order.split())


def test_a_comment_that_lists_the_wheels_is_believed() -> None:
    channels = places("/suspension", "travel{}", 8, "mm", "fr, fl, rr, rl [mm]")
    found = propose(channels, None)
    assert {signal: found[signal][0].channels[0] for signal in found} == {
        "suspension_deflection_fl": "/suspension.travel[1]",
        "suspension_deflection_fr": "/suspension.travel[0]",
        "suspension_deflection_rl": "/suspension.travel[3]",
        "suspension_deflection_rr": "/suspension.travel[2]",
    }
    assert "which the log calls 'fl'" in found["suspension_deflection_fl"][0].rule


@pytest.mark.parametrize(
    ("message", "elements"),
    [
        ({"names": ["rr", "rl"], "speed": [1.0, 2.0]}, {"speed[0]": "rr", "speed[1]": "rl"}),
        ({"order": "front left,fr", "speed": [1.0, 2.0]}, {"speed[0]": "front left", "speed[1]": "fr"}),
        ({"names": ["fl"], "speed": [1.0, 2.0]}, {"speed[0]": "", "speed[1]": ""}),
        ({"names": ["fl", "fl"], "speed": [1.0, 2.0]}, {"speed[0]": "", "speed[1]": ""}),
        ({"names": ["fl", "fr", "rl"], "speed": [1.0, 2.0]}, {"speed[0]": "", "speed[1]": ""}),
    ],
)
def test_names_beside_a_list_in_json(message: Any, elements: dict[str, str]) -> None:
    decoder = make_json_decoder(b"", [json.dumps(message).encode()] * 2)
    assert {info.path: info.element for info in decoder.fields if info.kind == "number"} == elements


def test_a_list_s_description_in_a_json_schema() -> None:
    numbers = {"type": "array", "items": {"type": "number"}, "description": "fl, fr, rl, rr [km/h]"}
    schema = {"type": "object", "properties": {"v": numbers}, "additionalProperties": False}
    decoder = make_json_decoder(json.dumps(schema).encode())
    assert {(info.unit, info.comment) for info in decoder.fields} == {("km/h", "fl, fr, rl, rr [km/h]")}
