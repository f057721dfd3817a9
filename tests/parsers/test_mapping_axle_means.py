"""One deflection for an axle is no wheel's: it is told with what would be needed, and never suggested for a wheel."""

from __future__ import annotations

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose_all, starter_map, unmapped_reason
from parsers.table_names import split_header


def column(header: str) -> ChannelInfo:
    split = split_header(header)
    return ChannelInfo(split.name, "t", split.unit, "table", tags={"column": header})


@pytest.mark.parametrize(
    "header",
    [
        "susp_front_mm", "Damper_Front", "FrontAxleTravel", "RearSuspTravel [mm]", "SuspDefl_rear", "susp_r [mm]", "rearShock",
        "Federweg vorne [mm]", "Einfederung HA [mm]", "vorderachs_weg", "RideHeightFront [mm]", "HeadlampLevelRear [mm]",
        "susp_front_mean_mm", "susp_pot_front",
    ],
)  # fmt: skip
def test_it_is_told_and_not_taken(header: str) -> None:
    channel = column(header)
    found = propose_all([channel, column("speed [km/h]")], None)
    assert set(found.bindings) == {"speed"}
    assert found.unknown == ()
    (sentence,) = found.said
    assert sentence.startswith(f"{channel.name}: one deflection for an axle")
    assert "one sensor counted as two" in sentence
    assert "axle_load_front" in sentence
    assert "for an axle" in unmapped_reason(channel)
    suggested, left = starter_map([channel], {}).split("# Channels of numbers")
    assert channel.name not in suggested
    assert "for an axle" in left.splitlines()[1]


def test_both_axles_are_one_sentence_that_names_the_wheels() -> None:
    (sentence,) = propose_all([column("susp_front_mm"), column("susp_rear_mm")], None).said
    assert sentence.startswith("susp_front_mm, susp_rear_mm: ")
    assert "(fl and fr or rl and rr)" in sentence


@pytest.mark.parametrize(
    "header",
    ["susp_front_force [N]", "damper_temp_front", "suspension_front [N]", "front_tyre_mm", "fuel_level_rear", "speed_front", "susp_front_cmd"],
)  # fmt: skip
def test_what_is_none_is_not_called_one(header: str) -> None:
    assert not any("one deflection" in each for each in propose_all([column(header)], None).said)


def test_beside_the_axles_own_wheels_nothing_is_said() -> None:
    wheels = [column(f"suspension_deflection_{wheel} [mm]") for wheel in ("fl", "fr")]
    (sentence,) = propose_all([*wheels, column("susp_front_mm"), column("susp_rear_mm")], None).said
    assert sentence.startswith("susp_rear_mm: ")
