"""Tyre normal forces have a chapter of their own: figures, errors against measuring wheels; none without a map."""

from __future__ import annotations

from dataclasses import replace

from parsers.signals import WHEELS
from reports.blocks import Paragraph, Table
from reports.figures import fits
from reports.figures import tire_forces as figure
from reports.figures.drawing import Drawing, Missing
from reports.html import render_html
from reports.sections import tire_forces as section
from tests.reports.sample_forces import mapped
from tests.reports.sample_results import bare, rich


def test_no_map_no_chapter() -> None:
    assert section.build(bare(), {}) == ()
    assert isinstance(figure.draw(bare()), Missing)


def test_table_words_and_figure() -> None:
    results = replace(rich(), estimates=(mapped(rms_error_fl_n=38.0, inside_interval_fl=0.96),))
    words, table = section.build(results, {})
    assert isinstance(words, Paragraph)
    assert isinstance(table, Table)
    first = [cell.text for cell in table.rows[0]]
    assert first[0] == "fl"
    assert first[3].startswith("3")
    assert first[3].endswith("N")
    assert first[5].startswith("38")
    assert "96" in first[7]
    assert [row[5].text for row in table.rows[1:]] == ["—"] * 3
    drawn = figure.draw(results)
    assert isinstance(drawn, Drawing)
    assert all(f"tyre normal force {w}" in "".join(drawn.svgs) for w in WHEELS)
    assert "Tyre normal forces" in render_html(results)


def test_the_forces_are_not_drawn_twice() -> None:
    results = replace(rich(), estimates=(mapped(),))
    assert fits.trace_panels(results, residual=False) == []


def test_answers_are_drawn_before_witnesses() -> None:
    plain = rich().estimates[0]
    told = replace(plain, estimator="published", witness=True)
    titles = [p.title for p in fits.trace_panels(replace(rich(), estimates=(told, plain)), residual=False)]
    assert titles
    assert titles.index(next(t for t in titles if "published" in t)) == len(titles) // 2
