"""What figures say of themselves: whose a note is, and where the curve of an answer stands."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.results import ParameterEstimate
from reports.figures.fits import TracePanel, _notes
from reports.figures.learned import _as_told


def panel(title: str, note: str) -> TracePanel:
    return TracePanel(title, "deg", (), note)


def test_a_note_is_said_once_with_its_panel_or_with_whose_panels_it_is_of() -> None:
    shown = [
        panel("Roll dynamics\nroll fit", "low-passed"),
        panel("Roll dynamics\nroll rate fit", "low-passed"),
        panel("Braking and roll\nwheel slips", "eq. (1)"),
        panel("Others\nplain", ""),
    ]
    assert _notes(shown) == "Roll dynamics: low-passed. Wheel slips: eq. (1)."


@pytest.mark.parametrize(("value", "std"), [(0.6, 0.02), (0.63, 0.02), (0.6, 0.05)])
def test_a_curve_stands_at_the_answer_that_doubts_moved_and_widened(value: float, std: float) -> None:
    grid = np.linspace(0.4, 0.8, 801)
    density = np.exp(-0.5 * ((grid - 0.6) / 0.02) ** 2)
    answer = ParameterEstimate("cg_height_m", value, std, None, None, "weak", "", None, None, ())
    at = _as_told(grid, density, answer)
    weights = density * np.gradient(at)
    mean = np.average(at, weights=weights)
    assert mean == pytest.approx(value, abs=1e-6)
    assert np.sqrt(np.average((at - mean) ** 2, weights=weights)) == pytest.approx(std, rel=1e-6)


def test_a_curve_without_an_answer_stays_where_it_is() -> None:
    grid = np.linspace(0.0, 1.0, 11)
    assert _as_told(grid, np.ones(11), None) is grid
