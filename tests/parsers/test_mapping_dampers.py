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


@pytest.mark.parametrize(
    "name",
    ["Spring travel FL", "Spring deflection FL", "x_spring_fl", "SpringCompressionFL", "Susp Spring Pos FL"],
)
def test_travel_at_a_spring_is_not_the_wheels_either(name):
    channel = column(name, "mm")
    proposals, said = propose_and_say([channel], None)
    assert proposals == {}
    (sentence,) = said
    assert sentence.startswith(f"{name}: measured at the spring")
    assert "wheel travel over spring travel" in sentence
    assert "at the spring" in unmapped_reason(channel)
    assert "# to be filled in: wheel travel over spring travel" in starter_map([channel], {})


def test_the_wheel_s_travel_comes_before_both_and_each_part_has_its_sentence():
    channels = [column("Spring travel FL", "mm"), column("Federweg VL", "mm")]
    assert propose_and_say(channels, None)[0]["suspension_deflection_fl"][0].channels == ("Federweg VL",)
    _, said = propose_and_say([column("Spring travel FL", "mm"), column("Damper Pos FR", "mm")], None)
    assert [each.split(": ")[1][:22] for each in said] == ["measured at the damper", "measured at the spring"]


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


@pytest.mark.parametrize("name", ["Spring length {}", "Strut_Length_{}", "Federlänge {}"])
def test_a_springs_length_has_its_lines_in_the_starter_file_but_for_the_length_at_rest(name, tmp_path):
    channels = [column(name.format(wheel), "mm") for wheel in ("FL", "FR", "RL", "RR")]
    assert propose_and_say(channels, None)[0] == {}
    starter = starter_map(channels, {})
    at = starter.splitlines().index(
        "# [signals.suspension_deflection_rl]  # compression at the wheel, + compressed, wheel rl"
    )
    own = "\n".join(line[2:] for line in starter.splitlines()[at : at + 5])
    path = tmp_path / "map.toml"
    path.write_text(own.replace("offset =  ", "offset = 337.5  "), encoding="utf-8")
    (binding,) = propose_and_say(channels, read_map(path))[0]["suspension_deflection_rl"]
    assert (binding.channels, binding.scale, binding.offset) == ((name.format("RL"),), -1.0, 337.5)
    # a length of something else, or of no wheel, is none
    assert "a length, which" not in starter_map(
        [column("Wheel base length", "mm"), column("length FL", "s")], {}
    )
