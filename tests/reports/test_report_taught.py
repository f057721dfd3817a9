"""What the drive taught: the chapter, its figures, its words, and where they stand in each form of the report."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from sample_results import bare, hostile, rich

from pipelines.drive_results import DriveResults
from pipelines.results import Learned, NextMeasurement, Prior, RelationCheck, Share
from reports.archive import load_results, save_results
from reports.blocks import Bullets, Document, Folded, Heading, Section, Table
from reports.figures.drawing import Drawing
from reports.figures.methods import draw as draw_methods
from reports.figures.methods import interval_panels
from reports.figures.shares import pieces
from reports.html import html_of
from reports.results_json import json_text, to_json
from reports.sections import methods, taught
from reports.sections.joint_words import (
    chance,
    conflicts,
    learned_in_order,
    most_useful,
    narrowing,
    next_line,
)

GRID = np.linspace(-1.0, 1.0, 5)


def chapter(document: Document) -> Section:
    return next(s for s in document.sections if s.anchor == "taught")


def tables(section: Section) -> list[Table]:
    return [block for block in section.blocks if isinstance(block, Table)]


def test_a_row_says_before_after_bits_source_and_next(rich_document: Document) -> None:
    row = tables(chapter(rich_document))[0].rows[0]
    assert row[0].text == "CG height above ground"
    assert row[1].text == "0.551\xa0±\xa00.062\u202fm"
    assert row[2].text == "0.558\xa0±\xa00.029\u202fm"
    assert row[3].text == "1.1"
    assert row[3].bar is not None
    assert row[3].bar.high == pytest.approx(100 * math.log2(0.062 / 0.0286) / math.log2(160 / 15.8), abs=0.1)
    assert row[4].text == "Roll balance by spring deflections 0.6 (±\xa00.044; alone ±\xa00.031)"
    assert row[4].lines == ("Pitch balance by torques 0.2 (±\xa00.034; alone ±\xa00.047)",)
    assert row[5].text == "A suspension deflection sensor on each wheel: ± 0.014\u202fm, half as wide"


def test_what_repeats_the_prior_is_in_brackets(rich_document: Document) -> None:
    row = next(r for r in tables(chapter(rich_document))[0].rows if "offset" in r[0].text)
    assert row[2].text.startswith("(")
    assert row[2].sub == "no result"
    assert row[4].text == "—"


def test_the_conflict_stands_above_the_verdict_and_in_the_table(rich_document: Document) -> None:
    alert = rich_document.alerts[0]
    assert alert.badge == "conflict"
    assert alert.text.startswith(
        "Pitch balance by torques (Force and moment balances) contradicts the rest: chi² 31.7"
    )
    assert "for 4 figures, by chance 1 in 400\u202f000" in alert.text
    first = html_of(rich_document).split('id="taught"')[0]
    assert "2.6 times as wide" in first
    assert first.index("2.6 times as wide") < first.index("<table")
    relations = tables(chapter(rich_document))[1]
    assert [row[5].text for row in relations.rows] == ["conflict", "agrees", "not checked"]
    assert relations.rows[0][6].text == "2.6 times as wide"
    assert relations.rows[1][6].text == "—"


def test_a_rare_misfit_that_widened_nothing_is_strained() -> None:
    sample = rich()
    assert sample.joint is not None
    check = RelationCheck("a", "", 2, 10.0, 0.0067, 1.0, "")
    strained = replace(sample, joint=replace(sample.joint, relations=(check,), far=(), spoke_for=()))
    found = [block for block in taught.build(strained, {}) if isinstance(block, Table)]
    assert found[1].rows[0][5].text == "strained"
    assert taught.alerts(strained) == ()


def test_what_was_left_out_and_what_is_far_are_told(rich_document: Document) -> None:
    blocks = chapter(rich_document).blocks
    after = {head.text: block for head, block in pairwise(blocks) if isinstance(head, Heading)}
    left_out, far = after["Relations that were not counted"], after["What ended far from what was known"]
    kinds = after["What the drive speaks for"]
    assert isinstance(kinds, Bullets)
    assert kinds.items[0].text == "Tyres that do not give (odds 62%): the answers hold both."
    assert isinstance(left_out, Table)
    assert (
        left_out.rows[0][1].text == "Force and moment balances sees the same relation by the better sensor."
    )
    assert isinstance(far, Bullets)
    assert far.items[0].text == "Scale of the brake torques (3.1 standard deviations)."


def test_many_conflicts_leave_room_for_the_verdict() -> None:
    sample = rich()
    assert sample.joint is not None
    many = tuple(RelationCheck(f"r{i}", "s", 1, 40.0, 1e-9, 2.0 + i, "") for i in range(7))
    told = taught.alerts(replace(sample, joint=replace(sample.joint, relations=many)))
    assert [item.text.split()[0] for item in told] == ["r6", "r5", "5", "Tyres", "Ended"]
    assert told[2].text == f"5 more relations in conflict: see What the drive taught. {taught.WIDENED}"


def test_every_measurement_stands_behind_a_fold(rich_document: Document) -> None:
    folded = next(block for block in chapter(rich_document).blocks if isinstance(block, Folded))
    assert folded.printed == ()
    told = [row[1].text for row in folded.blocks[0].rows]  # type: ignore[union-attr]
    assert told[1] == "Braking 0.1 g harder: ± 0.025\u202fm, 12\u202f% narrower."
    html = html_of(rich_document)
    assert "<details><summary>All measurements that would help</summary>" in html
    assert html.count("<details>") == html.count("</details>") >= 4


def test_without_a_joint_posterior_there_is_no_chapter(bare_document: Document) -> None:
    assert "taught" not in [s.anchor for s in bare_document.sections]
    assert bare_document.alerts == ()
    assert to_json(bare())["joint"] is None
    assert next_line(bare()) == ""


def test_a_joint_posterior_that_learned_nothing_says_so() -> None:
    sample = rich()
    assert sample.joint is not None
    empty = replace(sample.joint, learned={}, relations=(), not_counted=(), far=(), spoke_for=())
    blocks = taught.build(replace(sample, joint=empty), {})
    assert "supports no relation" in blocks[0].text  # type: ignore[union-attr]


def learned_of(bits: float, *shares: tuple[float, float]) -> Learned:
    told = tuple(Share(str(i), b, 1.0, alone) for i, (b, alone) in enumerate(shares))
    return Learned("mass_kg", Prior(0.0, 1.0, ""), bits, told)


def test_pieces_add_up_to_what_was_gained() -> None:
    own, shared = pieces(learned_of(3.0, (1.0, 0.25), (0.5, 0.5)))
    assert own == {"0": 1.0, "1": 0.5}
    assert shared == pytest.approx({"0": 1.0, "1": 0.5})  # alone they tell 2 bits and 1 bit
    own, shared = pieces(learned_of(1.0, (1.5, 0.5), (0.5, 0.5), (-0.2, 2.0)))
    assert own == pytest.approx({"0": 0.75, "1": 0.25})
    assert shared == {}
    assert pieces(learned_of(1.0, (0.4, math.inf))) == ({"0": 0.4}, {"": pytest.approx(0.6)})
    assert pieces(learned_of(math.nan, (math.inf, 1.0))) == ({}, {"": 0.0})


def test_words_for_chances_and_ratios() -> None:
    assert [chance(p) for p in (0.41, 0.004, 2.2e-6, 1e-9, math.nan)] == [
        "41\u202f%", "0.4\u202f%", "1 in 400\u202f000", "below 1 in a million", "—",
    ]  # fmt: skip
    assert [narrowing(r) for r in (1.2, 0.98, 0.7, 0.5, 0.25, 0.0)] == [
        "", "", "30\u202f% narrower", "half as wide", "4.0 times narrower", "",
    ]  # fmt: skip


def test_the_next_measurement_is_the_heights_or_the_one_that_helps_most() -> None:
    sample = rich()
    assert sample.joint is not None
    assert most_useful(sample) == (
        "cg_height_m",
        NextMeasurement("a suspension deflection sensor on each wheel", 0.0143),
    )
    known = {name: v for name, v in sample.joint.learned.items() if name != "cg_height_m"}
    without = replace(sample, joint=replace(sample.joint, learned=known))
    assert (
        next_line(without)
        == "Weighing one axle. It would bring mass to ± 9.0\u202fkg instead of ± 16\u202fkg."
    )
    useless = {"mass_kg": replace(known["mass_kg"], next=(NextMeasurement("wait", 15.9),))}
    assert next_line(replace(sample, joint=replace(sample.joint, learned=useless))) == ""


def test_the_archive_keeps_the_joint_verdict(tmp_path: Path) -> None:
    sample = rich()
    save_results(sample, tmp_path / "a.json")
    again = load_results(tmp_path / "a.json")
    assert again.joint is not None
    assert sample.joint is not None
    assert again.joint.not_counted == sample.joint.not_counted
    assert json_text(again) == json_text(sample)


@pytest.mark.parametrize("sample", [rich(), hostile()], ids=["rich", "hostile"])
def test_the_json_block_is_strict(sample: DriveResults) -> None:
    def refuse(name: str) -> float:
        raise AssertionError(name)

    block = json.loads(json_text(sample), parse_constant=refuse)["joint"]
    mass = block["parameters"]["mass_kg"]
    assert mass["relations"][0] == {
        "relation": "vertical balance by spring deflections", "bits": 3.1, "std_without": 135.0, "std_alone": 17.1,
    }  # fmt: skip
    assert [n["std_after"] for n in mass["next"]] == [9.0]
    assert len(mass["density"]["grid"]) == len(mass["density"]["posterior"]) == 101
    pitch = block["relations"][1]
    assert (pitch["conflict"], pitch["widened"], pitch["numbers"]) == (True, 2.6, 4)
    assert block["relations"][2]["chi2"] is None
    assert block["not_counted"][0].keys() == {"relation", "reason"}


def test_conflicts_are_the_worst_first() -> None:
    sample = rich()
    assert sample.joint is not None
    small = RelationCheck("small", "", 1, 9.0, 0.003, 1.4, "")
    joint = replace(sample.joint, relations=(small, *sample.joint.relations))
    assert [c.relation for c in conflicts(joint)] == ["pitch balance by torques", "small"]


def test_methods_stand_beside_the_verdict_witnesses_last() -> None:
    sample = rich()
    told = sample.estimates[0].parameters["cg_height_m"]
    far = replace(told, value=2.0, low=1.9, high=2.1, std=0.05)
    witness = replace(
        sample.estimates[0], estimator="published", witness=True, parameters={"cg_height_m": far}
    )
    both = replace(sample, estimates=(witness, *sample.estimates))
    panel = interval_panels(both)[0]
    assert [line.kind for line in panel.lines] == ["verdict", "method", "witness", "prior"]
    assert panel.reference == 0.549
    assert isinstance(draw_methods(both), Drawing)
    table = methods.build(both, {})[0]
    assert isinstance(table, Table)
    rows = [[cell.text for cell in row] for row in table.rows[:2]]
    assert rows[0][:3] == ["CG height above ground", "roll_map", "0.558 ± 0.029"]
    assert rows[1][1] == "published (published)"
    assert rows[1][4] == "+28.8"


def test_methods_that_cannot_tell_share_a_line() -> None:
    sample = rich()
    height = sample.verdict["cg_height_m"]
    silent = replace(height, value=None, std=None, low=None, high=None, status="not_identifiable")
    two = tuple(
        replace(sample.estimates[1], estimator=name, parameters={"cg_height_m": silent})
        for name in ("a", "b")
    )
    table = methods.build(replace(sample, estimates=two), {})[0]
    assert isinstance(table, Table)
    assert [cell.text for cell in table.rows[0]][:3] == ["CG height above ground", "a, b", "—"]
    assert len(table.rows) == 1


def _told(prior_std: float, std: float, *shares: Share, bits: float) -> Learned:
    """What the first parameter of the sample's posterior is said to have learned."""
    sample = rich()
    assert sample.joint is not None
    name, learned = next(iter(sample.joint.learned.items()))
    learned = replace(learned, prior=replace(learned.prior, std=prior_std), bits=bits, shares=shares)
    verdict = {name: replace(sample.verdict[name], std=std)}
    changed = replace(sample, verdict=verdict, joint=replace(sample.joint, learned={name: learned}))
    return learned_in_order(changed)[0][1]


def test_bits_are_those_of_the_spreads_that_stand_beside_them() -> None:
    share = Share("roll balance", 0.19, 0.0159, 0.0140)
    same = _told(0.0158, 0.01595, share, bits=0.18)
    assert same.bits == 0.0
    assert same.shares == ()
    wider = _told(0.04, 0.02, Share("roll balance", 0.5, 0.03, 0.015), share, bits=1.5)
    assert wider.bits == pytest.approx(1.0)
    (kept,) = wider.shares
    assert kept.std_without == 0.03
    assert math.isnan(kept.std_alone)


def test_bits_that_go_with_the_spreads_stay() -> None:
    share = Share("roll balance", 0.5, 0.03, 0.025)
    told = _told(0.04, 0.02, share, bits=1.02)
    assert told.bits == 1.02
    assert told.shares == (share,)
