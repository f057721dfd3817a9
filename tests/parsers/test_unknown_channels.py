"""Channels that nobody knows are said: a handful by name, very many by their count, and none that is known to be no signal."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest

from parsers.channels import ChannelInfo
from parsers.load import load_drive
from parsers.mapping import propose_all, read_map
from parsers.mapping.unknown import LONGEST
from parsers.table_names import split_header


def column(header: str, kind: str = "number", family: Literal["table", "can"] = "table") -> ChannelInfo:
    split = split_header(header)
    return ChannelInfo(
        split.name,
        "t",
        split.unit,
        family,
        kind="text" if kind == "text" else "number",
        tags={"column": header},
    )


def unknown(*headers: str) -> tuple[str, ...]:
    return propose_all([column(header) for header in headers], None).unknown


def test_a_handful_is_named_with_units_and_counted() -> None:
    (text,) = unknown("speed [km/h]", "Zug [Nm]", "Hoehe_X [mm]", "ay [m/s2]")
    assert text == (
        "not recognised: Zug [Nm], Hoehe_X [mm] (2 of 4 columns; `cogest inspect LOG --write-map map.toml` begins a mapping file for them)"
    )


def test_more_are_counted_and_very_many_are_not_named() -> None:
    (text,) = unknown(*(f"Q{k}x [mm]" for k in range(7)))
    assert "Q4x [mm] and 2 more (7 of 7 columns" in text
    (text,) = unknown(*(f"Q{k}x [mm]" for k in range(31)))
    assert text == "not recognised: 31 of 31 columns; `cogest inspect LOG --write-map map.toml` lists them"


def test_of_messages_only_the_count_is_said() -> None:
    (text,) = propose_all([column("M.Zug", family="can"), column("M.Stange", family="can")], None).unknown
    assert text.startswith("not recognised: 2 of 2 channels; ")


@pytest.mark.parametrize(
    "header",
    [
        "mass_true [kg]", "h_true", "counter", "frame_id", "Status_ABS", "heading [deg]", "PDOP", "Oil temp [°C]", "Throttle [%]",
        "Engine speed [rpm]", "ay_max [m/s2]", "yaw_rate_cmd [deg/s]", "utc time [s]", "Battery [V]", "_raw",
    ],
)  # fmt: skip
def test_what_is_known_to_be_no_signal_is_not_said(header: str) -> None:
    assert unknown(header, "speed [km/h]") == ()


def test_texts_and_what_is_used_or_told_otherwise_are_not_said() -> None:
    channels = [column("Note", "text"), column("speed"), column("vehicle_speed"), column("FW_Niveau_VL [mm]")]
    found = propose_all(channels, None)
    assert any("FW_Niveau_VL" in text for text in found.said)
    assert found.unknown == ()


def test_a_unit_that_is_not_the_signals_is_said() -> None:
    assert "Drive torque [%] (1 of 2 columns" in unknown("Drive torque [%]", "speed")[0]
    assert unknown("Drive torque [%]", "drive_torque_nm") == ()


def test_what_the_users_map_takes_is_not_said(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text('[signals.drive_torque]\nchannel = "Zug"\nunit = "Nm"\n')
    assert propose_all([column("Zug")], read_map(path)).unknown == ()


def test_long_names_are_cut() -> None:
    (text,) = unknown("Q" * 500)
    assert len(text) < 200
    assert f"{'Q' * (LONGEST - 1)}…" in text


def test_the_record_has_it(tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    log.write_text("time,speed [m/s],Zug [Nm]\n" + "".join(f"{k / 10},{k % 7},{k}\n" for k in range(100)))
    assert any(
        note.startswith("not recognised: Zug [Nm] (1 of 2 columns") for note in load_drive([log]).record.notes
    )
