"""What is measured at a damper is not taken for the wheel's travel or the suspension's force, and is told."""

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose_and_say, read_map, starter_map, unmapped_reason


def column(name, unit=None):
    return ChannelInfo(name, "table", unit, "table", tags={"column": name})


TRAVELS = [
    "Damper Pos FL",
    "Damper Travel FL",
    "Damper Position FL",
    "Shock Pot FL",
    "ShockTravelFL",
    "Shock Absorber Travel FL",
    "Susp Damper Pos FL",
    "Dämpferweg VL",
    "Stoßdämpferweg VL",
    "Damper_FL",
    "Susp Pot FL",
    "Suspension Potentiometer FL",
    "Linpot FL",
]


@pytest.mark.parametrize("name", TRAVELS)
def test_travel_at_a_damper_is_not_the_wheels(name):
    channel = column(name, "mm")
    proposals, said = propose_and_say([channel], None)
    assert proposals == {}
    (sentence,) = said
    assert sentence.startswith(name)
    assert f'[signals.suspension_deflection_fl] channel = "{name}", scale' in sentence
    assert "at the damper" in unmapped_reason(channel)


def test_all_wheels_are_told_in_one_sentence():
    _, said = propose_and_say([column(f"Damper {wheel}", "mm") for wheel in ("FL", "FR", "RL", "RR")], None)
    (sentence,) = said
    assert sentence.startswith("Damper FL, Damper FR, Damper RL, Damper RR: ")


def test_travel_at_the_wheel_beside_it_is_taken_and_nothing_said():
    proposals, said = propose_and_say([column("Damper Pos FL", "mm"), column("Wheel travel", "mm")], None)
    assert (proposals, len(said)) == ({}, 1)
    proposals, said = propose_and_say([column("Damper Pos FL", "mm"), column("Federweg VL", "mm")], None)
    assert [each.channels for each in proposals["suspension_deflection_fl"]] == [("Federweg VL",)]
    assert said == ()


def test_a_spring_s_force_comes_before_a_damper_s():
    damper, spring = column("Damper Force FL", "N"), column("Spring Force FL", "N")
    proposals, said = propose_and_say([damper, spring], None)
    assert [each.channels for each in proposals["suspension_force_fl"]] == [("Spring Force FL",)]
    assert said == ()
    proposals, said = propose_and_say([damper], None)
    assert proposals == {}
    assert len(said) == 1
    assert said[0].startswith("Damper Force FL: ")


def test_a_mapping_file_takes_it_with_the_ratio(tmp_path):
    path = tmp_path / "map.toml"
    channel = column("Damper Pos FL", "mm")
    starter = starter_map([channel], {})
    assert '# channel = "Damper Pos FL"' in starter
    lines = [f"# {key}" for key in ("[signals.suspension_deflection_fl]", "channel =", "unit =", "scale =")]
    own = [line[2:] for line in starter.splitlines() if line.startswith(tuple(lines))]
    at = next(n for n, line in enumerate(own) if line.startswith("[signals.suspension_deflection_fl]"))
    path.write_text("\n".join(own[at : at + 4]).replace("scale =", "scale = 1.4"), encoding="utf-8")
    proposals, said = propose_and_say([channel], read_map(path))
    (binding,) = proposals["suspension_deflection_fl"]
    assert (binding.scale, binding.unit.text) == (1.4, "mm")
    assert said == ()
