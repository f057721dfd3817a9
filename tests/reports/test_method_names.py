"""Methods stand in a report by titles; the command line's names stand once, under Estimators."""

from __future__ import annotations

import re
from dataclasses import replace

from sample_results import rich

from pipelines.estimators.registry import estimators
from pipelines.results import Estimate
from reports.document import build_document
from reports.html import html_of
from reports.method_names import NAMES, code_of, in_words, title_of, with_titles
from reports.terminal import verdict_table

LONGEST = 26
"""Characters that a figure has room for."""


def test_every_registered_estimator_has_a_short_title_of_its_own() -> None:
    names = [estimator.name for estimator in estimators()]
    assert sorted(NAMES) == sorted(names)
    titles = [title_of(name) for name in names]
    assert len(set(titles)) == len(names)
    assert max(map(len, titles)) <= LONGEST
    assert not any("_" in title for title in titles)
    assert [code_of(title) for title in titles] == names


def test_names_within_sentences_become_titles_and_paths_stay() -> None:
    assert (
        in_words("counted by load_balance; roll_map tells less")
        == "counted by Force and moment balances; Roll dynamics tells less"
    )
    for text in (
        "docs/roll_map.md",
        "roll_map.bank_std_deg",
        "roll_mapping",
        "my_roll_map",
        "load_transfer_batches",
    ):
        assert in_words(text) == text


def test_a_report_shows_each_code_name_once_where_it_can_be_looked_up() -> None:
    sample = rich()
    skipped = tuple(Estimate(name, "skipped", f"lacks accel_y, as {name} does") for name in NAMES)
    told = next(e for e in sample.estimates if e.status == "ran" and e.tracks)
    told = replace(told, estimator="roll_map", reason="roll_map ran")
    every = (told, *(e for e in skipped if e.estimator != "roll_map"))
    page = html_of(build_document(replace(sample, estimates=every, limits=("roll_map tells little.",))))
    page = page.replace("<wbr>", "")
    for name in NAMES:
        assert len(re.findall(rf"(?<![\w/]){name}(?!\w|\.\w)", page)) == 1, name
    assert "Roll dynamics tells little." in page


def test_the_console_names_methods_by_their_titles() -> None:
    sample = rich()
    name, estimate = next(iter(sample.verdict.items()))
    reason = "no estimator gave it: marginalized_particle_filter lacks mass_kg"
    table = verdict_table(replace(sample, verdict={name: replace(estimate, reason=reason)}))
    assert "marginalized_particle_filter" not in table
    assert "Particle filter on roll" in table


def test_titles_twice_are_titles_once() -> None:
    once = with_titles(rich())
    assert [e.estimator for e in with_titles(once).estimates] == [e.estimator for e in once.estimates]
