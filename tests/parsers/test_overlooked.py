"""Channels that nobody knows and that look like what a log lacks: said, never guessed."""

from __future__ import annotations

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose, propose_and_say
from parsers.mapping.overlooked import SAID


def column(name: str, unit: str | None, kind: str = "number") -> ChannelInfo:
    return ChannelInfo(
        name, "table", unit, kind="text" if kind == "text" else "number", tags={"column": name}
    )


def said(*channels: ChannelInfo) -> list[str]:
    return [text for text in propose_and_say(channels, None)[1] if text.startswith(SAID)]


def test_what_looks_like_the_missing_signals_is_named() -> None:
    levels = [column(f"FW_Niveau_{w}", "mm") for w in ("VL", "VR", "HL", "HR")]
    (text,) = said(*levels, column("BRK_TMC_PRES", "bar"), column("ay", "m/s2"))
    assert (
        "suspension deflections (FW_Niveau_VL [mm], FW_Niveau_VR [mm], FW_Niveau_HL [mm], FW_Niveau_HR [mm])"
        in text
    )
    assert "brake pressure (BRK_TMC_PRES [bar])" in text
    assert "inspect --write-map" in text


def test_many_are_counted() -> None:
    (text,) = said(*[column(f"Q{i}_FL", "mm") for i in range(9)])
    assert text.count("[mm]") == 4
    assert "and 5 more" in text


@pytest.mark.parametrize(
    "channel",
    [
        column("FW_Niveau_VL", None),  # no unit
        column("FW_Niveau_VL", "V"),  # none of a signal's
        column("Niveau", "mm"),  # of no wheel
        column("FW_Niveau_VL_max", "mm"),  # no measurement of now
        column("FW_Niveau_VL", "mm", "text"),
        column("Reifendruck_VL", "bar"),  # a tyre's pressure is no brake's
    ],
)
def test_what_says_too_little_is_not(channel: ChannelInfo) -> None:
    assert said(channel) == []


def test_nothing_is_said_of_what_the_log_has() -> None:
    have = [column(f"suspension_travel_{w}", "mm") for w in ("fl", "fr", "rl", "rr")]
    assert said(*have, column("FW_Niveau_VL", "mm")) == []


@pytest.mark.parametrize(
    ("name", "unit", "signal"),
    [
        ("Fzg_Geschwindigkeit", "km/h", "speed"),
        ("Radgeschw_HL", "km/h", "wheel_speed_rl"),
        ("Bremsdruck_HZ", "bar", "brake_pressure"),
        ("Einfederweg_VR", "mm", "suspension_deflection_fr"),
        ("nWheel_FL", "km/h", "wheel_speed_fl"),
        ("vWheelRR", "km/h", "wheel_speed_rr"),
        ("aSteerWheel", "deg", "steering_wheel_angle"),
        ("pBrakeMC", "bar", "brake_pressure"),
        ("sSusp_FL", "mm", "suspension_deflection_fl"),
        ("WhlDrvTqAct", "Nm", "drive_torque"),
        ("WhlBrkTqEst", "Nm", "brake_torque"),
    ],
)
def test_names_of_german_and_of_test_benches_are_known(name: str, unit: str, signal: str) -> None:
    assert [*propose([column(name, unit)], None)] == [signal]


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("nWheel_FL", None),
        ("aSteerWheel", "m/s2"),
        ("pBrakeMC", "deg"),
        ("sSusp_FL", None),
        ("DrvTqReq", "Nm"),
    ],
)
def test_short_ones_need_their_unit(name: str, unit: str | None) -> None:
    assert [*propose([column(name, unit)], None)] == []
