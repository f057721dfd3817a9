"""Elements of lists: no element stands for the vehicle where a plain channel does, and an element that the log names is that wheel's."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

from parsers.channels import ChannelInfo
from parsers.json_decode import make_json_decoder, needs_samples
from parsers.load import LoadOptions, load_drive, open_log
from parsers.mapping import propose, propose_and_say, unmapped_reason

START = 1_700_000_000_000_000_000
NAMES = ("fl", "fr", "rl", "rr")
SCHEMA = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "wheels": {
            "type": "array",
            "items": {
                "type": "object",
                "additionalProperties": False,
                "properties": {"name": {"type": "string"}, "speed": {"type": "number"}},
            },
        }
    },
}


def channel(topic: str, field: str, element: str = "", unit: str | None = None) -> ChannelInfo:
    tags = {"topic": topic, "type": "my.Type", "field": field}
    return ChannelInfo(
        f"{topic}.{field}", topic, unit, "json", tags=tags | ({"element": element} if element else {})
    )


def write(path: Path, names: tuple[str, ...], schema: dict[str, Any] | None = None) -> Path:
    """A log with the vehicle's speed in km/h, and a list of wheels of which the first runs 7 % slow."""
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start(profile="", library="test")
    number = writer.register_schema("wheels", "jsonschema", json.dumps(schema).encode()) if schema else 0
    wheels = writer.register_channel("/wheels", "json", number)
    vehicle = writer.register_channel("/vehicle", "json", 0)
    for i in range(600):
        t = START + i * 20_000_000
        speed = 15 + 5 * float(np.sin(i / 60))
        own = [0.93 * speed, speed, speed, speed]
        listed = [{"name": name, "speed": value} for name, value in zip(names, own, strict=True)]
        writer.add_message(wheels, t, json.dumps({"wheels": listed}).encode(), t)
        writer.add_message(
            vehicle, t, json.dumps({"speed": {"value": 3.6 * speed, "unit": "km/h"}}).encode(), t
        )
    writer.finish()
    path.write_bytes(stream.getvalue())
    return path


@pytest.mark.parametrize("schema", [None, SCHEMA])
@pytest.mark.parametrize("names", [NAMES, ("front_left_wheel", "frontRight", "RL", "hr")])
def test_wheels_by_the_names_in_the_messages(
    tmp_path: Path, names: tuple[str, ...], schema: dict[str, Any] | None
) -> None:
    path = write(tmp_path / "log.mcap", names, schema)
    proposals = propose(open_log(path, LoadOptions()).reader.channels, None)
    assert proposals["speed"][0].channels == ("/vehicle.speed.value",)
    assert len(proposals["speed"]) == 1
    for k, wheel in enumerate(NAMES):
        (best,) = proposals[f"wheel_speed_{wheel}"]
        assert best.channels == (f"/wheels.wheels[{k}].speed",)
        assert repr(names[k]) in best.rule
    drive = load_drive([path], LoadOptions())
    assert drive.signals["speed"].values[:1] == pytest.approx([15.0])
    assert drive.signals["wheel_speed_fl"].values[:1] == pytest.approx([0.93 * 15])


def test_names_that_change_or_are_given_twice_are_none() -> None:
    def elements(*messages: Any) -> dict[str, str]:
        decoder = make_json_decoder(b"", [json.dumps(each).encode() for each in messages])
        return {info.path: info.element for info in decoder.fields if info.kind == "number"}

    def wheels(*names: str) -> Any:
        return {"w": [{"id": name, "v": 1.0} for name in names]}

    assert elements(wheels("fl", "fr")) == {"w[0].v": "fl", "w[1].v": "fr"}
    assert elements(wheels("fl", "fr"), wheels("fr", "fl")) == {"w[0].v": "", "w[1].v": ""}
    assert elements(wheels("fl", "fl")) == {"w[0].v": "", "w[1].v": ""}
    assert needs_samples(json.dumps(SCHEMA).encode())


def test_an_element_comes_behind_a_plain_channel() -> None:
    listed, plain = channel("/a", "items[0].speed"), channel("/b", "speed.value", unit="km/h")
    proposals = propose([listed, plain], None)
    assert [each.channels[0] for each in proposals["speed"]] == [plain.name, listed.name]
    listed, plain = channel("/a", "units[0].accelerometer.x"), channel("/b", "acc_x_filt")
    assert [each.channels[0] for each in propose([listed, plain], None)["accel_x"]] == [
        plain.name,
        listed.name,
    ]


def test_a_wheel_is_not_the_vehicle() -> None:
    wheels = [channel("/w", f"wheels[{k}].speed", unit="m/s") for k in range(4)]
    assert propose(wheels, None) == {}
    assert "one wheel of a list" in unmapped_reason(wheels[0])
    hub = channel("/w", "nodes[0].accelerometer.x", element="rear_left")
    assert propose([hub], None) == {}
    assert "of the wheel 'rear_left'" in unmapped_reason(hub)


@pytest.mark.parametrize(
    ("topic", "field", "unit", "signal"),
    [
        ("/car", "corners[2].speed", None, "wheel_speed_rl"),
        ("/car", "suspension[2].travel.value", "mm", "suspension_deflection_rl"),
        ("/suspension/travel", "sensors[2].value", None, "suspension_deflection_rl"),
        ("/car", "wheels[2].brake_torque", "Nm", "brake_torque_rl"),
        ("/car", "wheel_speeds[2].value", "km/h", "wheel_speed_rl"),
    ],
)
def test_an_element_s_name_with_its_path(topic: str, field: str, unit: str | None, signal: str) -> None:
    assert list(propose([channel(topic, field, "left rear", unit)], None)) == [signal]


def test_an_element_that_is_no_wheel_s() -> None:
    wanted = channel("/car", "items[0].speed", "target_fl")
    assert set(propose([wanted], None)) <= {"speed"}
    assert propose_and_say([channel("/car", "damper[0].travel", "fl", "mm")], None)[0] == {}
