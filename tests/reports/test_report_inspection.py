"""`cogest inspect` as text and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

from pipelines.inspection import ChannelReport, Inspection
from pipelines.needs import Readiness
from reports.inspection import MOST_UNKNOWN, inspection_dict, inspection_text


def channel(
    name: str, low: float | None = 0.0, high: float | None = 1.0, signal: str | None = None
) -> ChannelReport:
    return ChannelReport(
        name, "m", "number", 1280, 40.0, 0, low, high, signal, "map.toml" if signal else "no profile knows it"
    )


def inspection(*channels: ChannelReport, notes: tuple[str, ...] = ()) -> Inspection:
    return Inspection(
        Path("drive.bag"), "ROS 1 bag", "complete", "header stamp", 3840, 32.0, None, channels, None,
        "no channel maps to a signal", (Readiness("roll_map", "Roll", False, ("accel_y",), ()),), "", {"broken record": 3}, notes,
    )  # fmt: skip


def test_elements_of_an_unused_array_share_a_line_and_json_has_each() -> None:
    found = inspection(
        *(channel(f"/imu.covariance[{i}]", -float(i), 2.0 * i) for i in range(36)),
        *(channel(f"/chassis.deflection[{i}]", signal=f"suspension_deflection_{w}") for i, w in enumerate(("fl", "fr"))),
    )  # fmt: skip
    lines = inspection_text(found, 160).splitlines()
    covariance = [line.split() for line in lines if "covariance" in line]
    assert len(covariance) == 1
    assert covariance[0][:7] == ["/imu.covariance[0-35]", "m", "1280", "40", "0", "-35", "70"]
    assert sum("-> suspension_deflection" in line for line in lines) == 2
    assert len(json.loads(json.dumps(inspection_dict(found)))["channels"]) == 38


def test_very_many_channels_end_in_a_count_but_no_mapped_one_is_left_out() -> None:
    many = (
        channel(f"Frame{i}.Signal{'abc'[i % 3]}", signal="speed" if i == 4000 else None) for i in range(5000)
    )
    text = inspection_text(inspection(*many), 120)
    assert "-> speed" in text
    assert f"and {4999 - MOST_UNKNOWN} more that became nothing: --json lists every channel" in text
    assert len(text.splitlines()) < MOST_UNKNOWN + 30


def test_figures_are_plain() -> None:
    text = inspection_text(
        inspection(channel("stamp", 1.76e9, 1.760000032e9), channel("k", 95949.6, 2.5e-5)), 160
    )
    assert "e+" not in text
    assert "e-" not in text
    assert "1760000032" in text
    assert "95950" in text
    assert "0.000025" in text


def test_lines_fit_the_terminal_and_a_log_cannot_steer_it() -> None:
    notes = ("a note of very many words " * 20, "\x1b[31mred\u202e and more")
    found = inspection(channel("/a/long/topic/name/of/a/message.with.fields.and.more"), notes=notes)
    text = inspection_text(found, 90)
    assert max(len(line) for line in text.splitlines()) <= 90
    assert "\x1b" not in text
    assert "\u202e" not in text
    assert "roll_map: lacks accel_y" in text
    assert "3 x broken record" in text
