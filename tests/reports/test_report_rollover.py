"""The chapter on rollover, its figures, and what other programs read of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from sample_results import bare, rich

from pipelines.drive_results import DriveResults
from pipelines.rollover_results import Rollover
from reports.archive import FILE_NAME, load_results, save_results
from reports.blocks import Document, Paragraph, Plot, Section, Table
from reports.document import build_document
from reports.results_json import json_text, to_json


def chapter(document: Document) -> Section:
    return next(section for section in document.sections if section.anchor == "rollover")


def texts(section: Section) -> str:
    words = []
    for block in section.blocks:
        if isinstance(block, Table):
            words += [f"{cell.text} {cell.sub}" for row in block.rows for cell in row] + [block.note]
        elif isinstance(block, Paragraph):
            words.append(block.text)
        elif block.kind == "bullets":
            words += [item.text for item in block.items]
    return " | ".join(words).replace("\u202f", " ")


def test_the_chapter_says_how_near_the_drive_came(rich_document: Document) -> None:
    section = chapter(rich_document)
    told = texts(section)
    assert "within 0.41 g of the limit, at its body's roll then, in a left turn at 48.3 s" in told
    assert "about 13 %" in told
    assert "RL" in told
    assert "one wheel, in a turn" in told
    assert "both wheels of a side" in told
    assert "the tyre forces move 2.0 %".lower() in told.lower()
    assert "CG lateral offset: 0 ± 0.02 m" in told
    plots = [block for block in section.blocks if isinstance(block, Plot)]
    assert [plot.name for plot in plots] == ["rollover_limits", "rollover_margin", "rollover_coefficient"]
    assert all(plot.svgs and not plot.missing for plot in plots)


def test_the_card_leads_to_it(rich_document: Document) -> None:
    card = next(card for card in rich_document.cards if card.title == "Rollover")
    facts = {row.label: row.text for block in card.blocks if block.kind == "facts" for row in block.rows}
    assert facts["Least margin"].startswith("0.41")
    assert facts["Wheel lift in turns"] == "2 events"
    assert facts["Threshold exceeded?"] == "about 13 %"


def test_a_drive_that_tells_nothing_says_what_is_not_known() -> None:
    section = chapter(build_document(bare()))
    told = texts(section)
    assert "not known" in told
    assert "track_front_m" in told
    assert "Wheel lift is not known" in told
    assert not [block for block in section.blocks if isinstance(block, Table | Plot)]


def test_a_height_from_other_vehicles_is_no_result() -> None:
    sample = rich()
    unknown = [
        replace(turn, least_margin_g=replace(turn.least_margin_g, status="not_identifiable"))
        for turn in sample.rollover.turns
    ]
    told = texts(
        chapter(build_document(replace(sample, rollover=replace(sample.rollover, turns=tuple(unknown)))))
    )
    assert "no result: " in told
    assert "rest on what was known before the log" in told


@pytest.fixture(scope="module")
def made() -> DriveResults:
    return rich()


def test_results_json_holds_every_part(made: DriveResults) -> None:
    told = json.loads(json_text(made))["rollover"]
    assert {
        "static_stability_factor", "threshold_g", "peak_lateral_acceleration_g", "peak_rollover_coefficient", "peak_time_s", "notes",
        "peak_coefficient", "coefficient_source", "limits", "turns", "wheel_lift", "exceedance", "check", "series", "assumptions",
    } == told.keys()  # fmt: skip
    assert told["limits"][1]["left"]["value"] == 1.384
    assert [turn["turn"] for turn in told["turns"]] == ["left", "right"]
    assert told["wheel_lift"]["events"][0]["wheel"] == "rl"
    assert told["wheel_lift"]["events"][1]["least_force_n"] is None
    assert told["exceedance"]["probability"] == 0.13
    assert told["check"]["slope"]["value"] == 1.02
    margin = told["series"][0]
    assert len(margin["time_s"]) == len(margin["columns"]["limit_left"]) == 900
    assert margin["columns"]["lateral_acceleration"][400] is None


def test_results_stored_before_there_were_margins_still_load(made: DriveResults, tmp_path: Path) -> None:
    save_results(made, tmp_path / FILE_NAME)
    raw = json.loads((tmp_path / FILE_NAME).read_text(encoding="utf-8"))
    kept = (
        "static_stability_factor",
        "threshold_g",
        "peak_lateral_acceleration_g",
        "peak_rollover_coefficient",
        "peak_time_s",
        "notes",
    )
    raw["results"]["rollover"] = {key: raw["results"]["rollover"][key] for key in kept}
    (tmp_path / FILE_NAME).write_text(json.dumps(raw), encoding="utf-8")
    loaded = load_results(tmp_path / FILE_NAME)
    assert loaded.rollover.peak_rollover_coefficient == 0.61
    assert loaded.rollover.turns == ()
    told = texts(chapter(build_document(loaded)))
    assert "stored before the margin was computed" in told
    assert to_json(loaded)["rollover"]["exceedance"] is None


def test_an_empty_record_is_a_record() -> None:
    told = to_json(replace(bare(), rollover=Rollover()))["rollover"]
    assert told["turns"] == []
    assert told["wheel_lift"] == {"source": "", "events": []}
