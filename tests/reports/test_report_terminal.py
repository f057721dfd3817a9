"""The verdict in the terminal."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from sample_results import bare, hostile, rich

from parsers.drive import Decision, Gap
from parsers.mapping.overlooked import SAID as OVERLOOKED
from parsers.mapping.unknown import SAID as UNRECOGNISED
from pipelines.drive_results import DriveResults
from pipelines.file_limits import FILE_AGAINST_ITSELF, FILE_UNLIKE, HANGING
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate
from reports.sections.quality import checks_card, decision_item, facts
from reports.terminal import verdict_table


@pytest.mark.parametrize("sample", [rich(), bare(), hostile()], ids=["rich", "bare", "hostile"])
def test_no_line_is_wider_than_a_terminal_and_none_steers_it(sample: DriveResults) -> None:
    table = verdict_table(sample)
    assert max(len(line) for line in table.splitlines()) <= 100
    assert "\x1b" not in table
    assert "\u202e" not in table


def test_columns_are_aligned_and_reasons_below() -> None:
    lines = verdict_table(rich()).splitlines()
    head = lines[0]
    place = head.index("Status")
    height = next(i for i, line in enumerate(lines) if line.startswith("CG height above ground"))
    assert lines[height][place:] == "weak"
    assert "0.558 ± 0.029 m" in lines[height]
    assert "0.502–0.614" in lines[height]
    assert lines[height + 1].startswith("    the roll motion fixes")
    assert all(line[place - 2 : place] == "  " for line in lines if line.endswith(("weak", "identified")))


def test_what_has_no_result_shows_a_dash_not_the_prior() -> None:
    line = next(row for row in verdict_table(rich()).splitlines() if row.startswith("Sprung mass"))
    assert "1380" not in line
    assert line.split()[2:4] == ["—", "—"]


def test_the_leading_reason_is_whole_and_the_others_are_short() -> None:
    long = "the first clause; " + "and a further one that goes on for a while, " * 6 + "to the end"
    sample = rich()
    verdict = {
        k: replace(v, reason=long) for k, v in sample.verdict.items() if k in ("cg_height_m", "mass_kg")
    }
    whole = replace(sample.record, status="complete", decisions=())
    told = verdict_table(replace(sample, record=whole, verdict=verdict, joint=None)).splitlines()
    mass = next(i for i, line in enumerate(told) if line.startswith("Mass"))
    assert " ".join(line.strip() for line in told[3:mass]) == long
    assert told[mass + 1] == "    the first clause; and a further one that goes on for a while …"
    assert len(told) == mass + 2


@pytest.mark.parametrize("words", [20, 60, 200])
def test_nothing_stands_in_the_terminal_that_it_cannot_print(words: int) -> None:
    """A reason that was cut ended in "0.59 m?…": a terminal shows a no-break space as what it cannot print."""
    sample = rich()
    verdict = {k: replace(v, reason="so many words; " * words) for k, v in sample.verdict.items()}
    told = verdict_table(replace(sample, verdict=verdict))
    assert all(line.isprintable() for line in told.splitlines())


def test_conflicts_and_the_next_measurement_stand_below() -> None:
    whole = verdict_table(rich())
    told = " ".join(line.strip() for line in whole.splitlines())
    assert "Tyres that do not give (odds 62%): the answers hold both. next, most useful:" in told
    assert (
        "conflict: Pitch balance by torques (Force and moment balances) contradicts the rest: chi² 31.7"
        in told
    )
    assert "would have to be 2.6 times as wide" in told
    assert "next, most useful: A suspension deflection sensor on each wheel. It would bring CG height" in told
    assert "to ± 0.014 m instead of ± 0.029 m." in told
    assert "conflict" not in verdict_table(replace(rich(), joint=None))


def test_colour_only_when_asked_for() -> None:
    painted = verdict_table(rich(), colour=True)
    assert "\x1b[32midentified\x1b[0m" in painted


def test_nothing_asked_nothing_said() -> None:
    assert verdict_table(replace(bare(), verdict={})) == "No parameter was asked for."


def test_a_load_that_changed_stands_below_and_on_the_first_screen() -> None:
    said = Decision(
        "", "load", "the load changed at about 350 s (by about -300 kg, more at the rear)",
        "split the drive there", "-300 ± 20 kg", applied=False,
    )  # fmt: skip
    sample = rich()
    changed = replace(sample, record=replace(sample.record, decisions=(*sample.record.decisions, said)))
    told = " ".join(line.strip() for line in verdict_table(changed).splitlines())
    assert (
        "The load changed at about 350 s (by about -300 kg, more at the rear): split the drive there." in told
    )
    assert "load changed" not in verdict_table(sample)
    (block,) = checks_card(changed)
    assert "The load changed at about 350 s" in str(block)


def test_a_log_that_is_not_whole_is_said_below() -> None:
    sample = rich()
    record = replace(
        sample.record, status="malformed", rejected={"row beyond a jump of the clock": 800, "cell": 2, "x": 1}
    )
    told = " ".join(line.strip() for line in verdict_table(replace(sample, record=record)).splitlines())
    assert "The log is malformed: left out 800 × row beyond a jump of the clock, 2 × cell (report:" in told
    complete = replace(record, status="complete")
    assert "The log is" not in verdict_table(replace(sample, record=complete))


@pytest.mark.parametrize(
    "said",
    [
        f"{FILE_AGAINST_ITSELF}: roll_stiffness_nmprad is 1, its springs and bars make 2",
        f"{FILE_UNLIKE} 72% of the empty mass on the front axle",
        f"{HANGING} {', '.join(f'spring_rate_{n}_npm (10 % off would move mass by {n} kg)' for n in range(8))}: if one is wrong, so is what hangs on it.",
    ],
)
def test_a_file_that_contradicts_itself_is_said_below(said: str) -> None:
    text = verdict_table(replace(rich(), limits=("something else", said)))
    assert said in " ".join(line.strip() for line in text.splitlines())
    assert "something else" not in text


def test_a_pause_of_the_whole_drive_is_said_below() -> None:
    sample = rich()
    short, long = (Gap(30.2, 30.2 + seconds) for seconds in (3.7, 3600.0))
    for gap, said in ((short, False), (long, True)):
        text = verdict_table(replace(sample, record=replace(sample.record, status="complete", gaps=(gap,))))
        assert ("Gaps of the whole drive: 1 (30.2-3630.2 s)." in text) == said


def test_signs_that_were_turned_and_channels_that_nobody_knew_stand_below() -> None:
    sample = rich()
    turned = [
        Decision(name, "sign", "opposite", "inverted", "r -0.98", True) for name in ("roll", "roll_rate")
    ]
    left = Decision("pitch", "sign", "opposite", "inverted", "r -0.6", False)
    missed = f"{OVERLOOKED}: brake pressure (P_BRK [bar]); `cogest inspect --write-map` begins a mapping file"
    record = replace(
        sample.record,
        decisions=(*turned, left),
        turned=("roll", "roll_rate"),
        notes=(*sample.record.notes, missed),
    )
    told = " ".join(verdict_table(replace(sample, record=record)).split())
    assert "Signs turned: roll, roll_rate (report: data quality)." in told
    assert (
        "Not mapped, but they look like signals that the log lacks otherwise: brake pressure (P_BRK [bar])"
        in told
    )
    plain = replace(sample.record, decisions=(left,))
    assert "Signs turned" not in verdict_table(replace(sample, record=plain))


def test_signals_that_the_checks_left_out_are_named_with_each_reason_once() -> None:
    sample = rich()
    wide = "deflections span 0.46 m, more than any road vehicle's wheel travels, as mm called cm would"
    left = [
        Decision(f"suspension_deflection_{wheel}", "range", wide, "left out; say the unit", "", True)
        for wheel in ("fl", "fr")
    ]
    said = [replace(left[0], applied=False), replace(left[0], action="divided by 10")]
    told = " ".join(
        verdict_table(replace(sample, record=replace(sample.record, decisions=(*left, *said)))).split()
    )
    assert (
        f"Left out: suspension_deflection_fl, suspension_deflection_fr: {wide}; say the unit (report: data"
        in told
    )
    assert told.count("0.46 m") == 1
    plain = replace(sample.record, decisions=tuple(said))
    assert "Left out:" not in verdict_table(replace(sample, record=plain))


def test_titles_and_reasons_are_not_cut_within_a_word() -> None:
    reason = "it lacks " + " or ".join(f"accel_y (lateral acceleration number {n})" for n in range(30))
    verdict = {
        name: ParameterEstimate(name, None, None, None, None, "not_identifiable", reason)
        for name in PARAMETERS
    }
    table = verdict_table(replace(rich(), verdict=verdict, joint=None))
    words = " ".join(table.split())
    for name in PARAMETERS:
        for word in PARAMETERS[name].title.split():
            assert word.rstrip(",;") in words
    for found in re.findall(r"(\S+) ?…", words):
        assert found in reason.split(), found


def test_signals_left_out_are_named_with_what_to_do() -> None:
    """Whatever check left them out, one reason once, in the terminal and with their own badge in the report."""
    crossed = [
        Decision(
            f"suspension_deflection_{wheel}", "sign", f"suspension_deflection_{wheel} moves in bends as on the other side",
            "left out: say which channel is which wheel", "correlation -0.9", applied=True,
        )
        for wheel in ("fl", "fr")
    ]  # fmt: skip
    sample = rich()
    record = replace(sample.record, decisions=tuple(crossed))
    told = " ".join(verdict_table(replace(sample, record=record)).split())
    assert (
        "Left out: suspension_deflection_fl, suspension_deflection_fr: moves in bends as on the other side; "
        "say which channel is which wheel (report: data quality)."
    ) in told
    assert "Signs turned" not in told
    assert (decision_item(crossed[0]).badge, decision_item(crossed[0]).tone) == ("left out", "warn")


def test_columns_that_nobody_knows_stand_in_the_last_line() -> None:
    results = rich()
    note = f"{UNRECOGNISED}Zug [Nm]\x1b[31m, Q7 (2 of 9 columns; `cogest inspect LOG --write-map map.toml` begins a mapping file for them)"
    record = replace(results.record, notes=(*results.record.notes, note))
    text = verdict_table(replace(results, record=record))
    assert "\x1b" not in text
    assert " ".join(text.split()).endswith("begins a mapping file for them).")
    assert "Not recognised: Zug [Nm]" in text


@pytest.mark.parametrize("kind", ["delay", "unit", "scale"])
def test_a_channel_s_fault_that_is_left_as_it_is_stands_before_the_conflicts(kind: str) -> None:
    sample = rich()
    fault = Decision("roll", kind, "roll comes 150 ms after roll_rate", "left as it is", "", applied=False)  # type: ignore[arg-type]
    for applied, count in ((False, 1), (True, 0)):
        record = replace(sample.record, decisions=(*sample.record.decisions, replace(fault, applied=applied)))
        text = verdict_table(replace(sample, record=record))
        assert text.count("Roll comes 150 ms after roll_rate; left as it is.") == count
    told = replace(sample, record=replace(sample.record, decisions=(fault,)))
    text = verdict_table(told)
    assert text.index("150 ms") < text.index("conflict: ")


def test_what_damage_took_is_said_at_once() -> None:
    sample = rich()
    lost = replace(sample.record, status="malformed", gaps=(Gap(3.2, 45.6, "lost"), Gap(1.0, 2.0, "accel_y")))
    assert "Lost to damage: 1 (3.200-45.600 s)." in verdict_table(replace(sample, record=lost))
    (fact,) = [each for each in facts(lost).rows if each.label == "Lost to damage"]
    assert (fact.text, fact.sub, fact.tone) == ("42.4\u202fs", "1 gap in single signals", "warn")
