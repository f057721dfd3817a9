"""The first figure stands under what it shows: roll where a drive shows it, else what it shows best."""

from __future__ import annotations

from dataclasses import replace

from sample_results import rich

from reports.document import draw_plot
from reports.figures.registry import FIGURES

LEAD = FIGURES[0]


def test_the_lead_figure_is_named_after_what_is_drawn() -> None:
    results = rich()
    assert draw_plot(LEAD, results).title == "Roll against lateral acceleration"
    other = tuple(
        replace(
            e, scatters=tuple(replace(s, title="Axle load over force along the road") for s in e.scatters)
        )
        for e in results.estimates
    )
    assert draw_plot(LEAD, replace(results, estimates=other)).title == "Axle load over force along the road"
