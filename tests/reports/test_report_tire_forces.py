"""Tyre normal forces have a chapter of their own: figures, errors against measuring wheels; none without a map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import Estimate, ParameterEstimate
from pipelines.tire_forces import TireForces, forces_as_traces
from reports.blocks import Paragraph, Table
from reports.figures import fits
from reports.figures import tire_forces as figure
from reports.figures.drawing import Drawing, Missing
from reports.html import render_html
from reports.sections import tire_forces as section
from tests.reports.sample_results import rich

TIME = np.linspace(0.0, 20.0, 400)
FORCE = {w: 4000.0 + 100.0 * i + 500.0 * np.sin(TIME) for i, w in enumerate(WHEELS)}


def mapped(**diagnostics: float) -> Estimate:
    """An estimate as the suspension map gives it."""
    low, high = ({w: f + side for w, f in FORCE.items()} for side in (-120.0, 120.0))
    forces = TireForces(TIME, FORCE, low, high, False, "map", 10.0)
    entry = ParameterEstimate("tire_normal_force_fl_n", 4000.0, 60.0, 3880.0, 4120.0, "identified", "at rest")
    return Estimate(
        "suspension_mapping", "ran", "from struts", {entry.name: entry},
        traces=forces_as_traces(forces, {"fl": FORCE["fl"] + 10.0}),
        diagnostics={"least_force_fl_n": 3500.0, "least_force_time_fl_s": 4.7, **diagnostics},
    )  # fmt: skip


def test_no_map_no_chapter() -> None:
    assert section.build(rich(), {}) == ()
    assert isinstance(figure.draw(rich()), Missing)


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
