"""The one telling plot: roll against lateral acceleration with the fitted gradient and its 95 % band, or what else a drive shows best."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from reports.figures.drawing import Drawing, Missing
from reports.figures.scatters import draw_scatter, leading_scatter
from reports.figures.style import LEAD_HEIGHT, LEAD_WIDTH, new_figure, styled, to_svg
from reports.text import clean


def draw(results: DriveResults) -> Drawing | Missing:
    """Draw the leading scatter; without one, say which signals or estimators are missing."""
    scatter = leading_scatter(results)
    if scatter is None:
        return Missing(_why(results))
    with styled():
        figure = new_figure(LEAD_WIDTH, LEAD_HEIGHT)
        draw_scatter(figure.subplots(), scatter)
        label = clean(f"{scatter.title}: {scatter.x_label} across, {scatter.y_label} up")
        svg = to_svg(figure, "roll-scatter", label)
    return Drawing((svg,), clean(scatter.note), label, clean(scatter.title))


def _why(results: DriveResults) -> str:
    ran = [e for e in results.estimates if e.status == "ran"]
    if ran:
        return "Not drawn: no estimator that ran relates roll to lateral acceleration."
    lacks = {m.signal for m in results.record.mapped}
    missing = [
        word
        for name, word in (("accel_y", "lateral acceleration"), ("roll_rate", "roll rate"))
        if name not in lacks
    ]
    if missing:
        return f"Not drawn: the log has no {' and no '.join(missing)}, and no estimator ran."
    return "Not drawn: no estimator ran; the reasons are under Estimators."
