"""Every figure is drawn or says why not; SVGs are small, deterministic and mind their own business."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest
from sample_results import bare, hostile, rich

from reports.document import build_document, draw_plot
from reports.figures import registry, standing
from reports.figures.drawing import Drawing, FigureSpec, Missing
from reports.figures.registry import FIGURES

IDS = [spec.name for spec in FIGURES]


@pytest.fixture(scope="module")
def drawn() -> dict[str, Drawing | Missing]:
    sample = rich()
    return {spec.name: spec.draw(sample) for spec in FIGURES}


@pytest.mark.parametrize("name", IDS)
def test_a_rich_drive_draws_every_figure(name: str, drawn: dict[str, Drawing | Missing]) -> None:
    figure = drawn[name]
    assert isinstance(figure, Drawing)
    assert figure.alt
    for svg in figure.svgs:
        root = ElementTree.fromstring(svg)
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert len(svg) < 400_000


@pytest.mark.parametrize("spec", FIGURES, ids=IDS)
def test_a_bare_drive_says_why_there_is_no_figure(spec: FigureSpec) -> None:
    drawn = spec.draw(bare())
    assert isinstance(drawn, Missing)
    assert len(drawn.reason) > 20
    assert drawn.reason.endswith(".")


def test_a_body_style_that_was_stated_is_not_called_unstated() -> None:
    good = rich()
    assert good.standing is not None
    drawn = standing.draw(
        replace(good, standing=replace(good.standing, body=None))
    )  # "body" that is none of the measured
    assert isinstance(drawn, Drawing)
    assert "No measured body style is known of this vehicle" in drawn.caption
    assert "not stated" not in drawn.caption


@pytest.mark.parametrize("spec", FIGURES, ids=IDS)
def test_hostile_names_stay_text_in_the_picture(spec: FigureSpec) -> None:
    drawn = spec.draw(hostile())
    assert isinstance(drawn, Drawing)
    for svg in drawn.svgs:
        tags = {element.tag.rpartition("}")[2] for element in ElementTree.fromstring(svg).iter()}
        assert tags <= {"svg", "title", "g", "path", "text", "tspan", "use", "defs", "clipPath", "rect"}


def test_figures_are_deterministic_and_leave_matplotlib_alone(drawn: dict[str, Drawing | Missing]) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    for spec in FIGURES[:3]:
        assert spec.draw(rich()) == drawn[spec.name]
    assert dict(matplotlib.rcParams) == before


def test_the_users_matplotlibrc_does_not_reach_the_report(drawn: dict[str, Drawing | Missing]) -> None:
    import matplotlib

    spec = FIGURES[0]
    with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "black", "svg.fonttype": "path"}):
        assert spec.draw(rich()) == drawn[spec.name]


def test_identifiers_of_all_figures_differ(drawn: dict[str, Drawing | Missing]) -> None:
    found: list[str] = []
    for figure in drawn.values():
        assert isinstance(figure, Drawing)
        for svg in figure.svgs:
            own = re.findall(r' id="([^"]*)"', svg)
            assert set(re.findall(r'(?:url\(#|href="#)([^")]*)', svg)) <= set(own)
            found += own
    assert len(found) == len(set(found))


def test_the_peak_of_a_long_signal_is_in_the_picture() -> None:
    def heights(results: object) -> float:
        drawn = next(s for s in FIGURES if s.name == "signals").draw(results)  # type: ignore[arg-type]
        assert isinstance(drawn, Drawing)
        return max(float(t) for t in re.findall(r">(\d+)</text>", drawn.svgs[0]))

    sample = rich()
    only = replace(sample, signals=tuple(s for s in sample.signals if s.name == "steering_wheel_angle"))
    assert heights(only) >= 500  # the one sample of 11 rad = 630 deg sets the axis


def test_a_new_figure_is_one_function_and_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = FigureSpec("extra", "An extra plot", "lead", lambda _: Missing("Not drawn: a test."))
    monkeypatch.setattr("reports.document.FIGURES", (*registry.FIGURES, spec))
    plots = build_document(bare()).lead
    assert plots[-1].missing == "Not drawn: a test."


def test_a_figure_that_breaks_does_not_cost_the_report() -> None:
    def broken(_: object) -> Drawing:
        raise ValueError("shapes (3,) and (4,)")

    plot = draw_plot(FigureSpec("broken", "Broken", "lead", broken), bare())
    assert plot.missing == "Not drawn: ValueError: shapes (3,) and (4,)"
