"""The HTML report: self-contained, escaped, complete, small."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from sample_results import bare, rich, signals

from parsers.drive import Decision, Gap, ImportRecord, MappedChannel
from parsers.errors import ReportError
from pipelines.results import ParameterEstimate, Prior, Trace
from reports.blocks import Document, Folded
from reports.document import build_document
from reports.html import breakable, html_of, render_html, template_text, write_html
from reports.sections import mapping
from reports.sections.rollover import band_of, nhtsa_context
from reports.sections.values import interval_cell


class Page(HTMLParser):
    """Tags with their attributes, and all text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.parts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.parts.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"[ \n]+", " ", "".join(self.parts))


def outside_links(html: str) -> list[str]:
    links = [
        v
        for _, attrs in Page(html).tags
        for k, v in attrs.items()
        if k in ("src", "href", "xlink:href", "srcset", "action", "data")
    ]
    links += re.findall(r"url\(([^)]*)\)", html)
    links += re.findall(r"@import[^;]*", html)
    return [link for link in links if link and not link.startswith(("#", "data:"))]


@pytest.mark.parametrize("which", ["rich_html", "hostile_html"])
def test_nothing_is_fetched_and_nothing_runs(which: str, request: pytest.FixtureRequest) -> None:
    html: str = request.getfixturevalue(which)
    assert outside_links(html) == []
    tags = {tag for tag, _ in Page(html).tags}
    assert not tags & {"script", "link", "iframe", "object", "embed", "form", "img", "base"}
    assert not [a for _, attrs in Page(html).tags for a in attrs if a.startswith("on")]
    assert "default-src 'none'" in html


def test_hostile_text_is_shown_not_run(hostile_html: str) -> None:
    assert "<script" not in hostile_html
    assert '<script>alert("x")</script>' in Page(hostile_html).text
    assert not re.search(r"[\x00-\x08\x1b\u202e]", hostile_html)


def test_the_first_screen_says_what_matters(rich_html: str) -> None:
    first = Page(rich_html.split('id="detail"')[0]).text
    for words in (
        "Volvo V40 T2, 2 persons", "slalom_35kph.vbo", "2024-05-17 09:41:20 UTC", "CG height above ground", "0.558\u202fm", "0.558\xa0±\xa00.029\u202fm",
        "0.502–0.614", "weak", "not identifiable", "The roll motion fixes K/(mh)", "Static stability factor", "1.38", "1.24–1.52", "NHTSA",
        "What limited the result", "truncated", "1 gap, 3.70\u202fs in all", "UTC time of day", "yaw_rate has the sign opposite to lateral acceleration",
        "inverted", "corrected", "only reported", "Sedan (640)", "61\u202f%",
    ):  # fmt: skip
        assert words in first, words


def test_a_prior_is_never_printed_as_a_result(rich_document: Document) -> None:
    detail = next(s for s in rich_document.sections if s.anchor == "detail").blocks[0]
    for table, head, prior in (
        (rich_document.verdict, "Prior, no result", "1380 ±\xa060\u202fkg"),
        (detail, "Prior (known before, not a result)", "1380 ± 60\u202fkg"),
    ):
        heads = [c.title for c in table.columns]  # type: ignore[union-attr]
        row = next(r for r in table.rows if r[0].text == "Sprung mass")  # type: ignore[union-attr]
        cells = dict(zip(heads, row, strict=True))
        assert cells["Value ± std"].text == "—"
        assert cells["95 % interval"].text == "—"
        assert cells[head].text == prior


def _told(
    name: str, reason: str, *, prior: Prior | None = None, value: float | None = None
) -> ParameterEstimate:
    if value is None:
        return ParameterEstimate(name, None, None, None, None, "not_identifiable", reason, prior)
    return ParameterEstimate(name, value, 1.0, value - 2, value + 2, "weak", reason, prior)


def test_the_first_screen_is_short_and_the_detail_is_whole() -> None:
    long = "roll motion gives a ratio only; " + "a further clause of the same reason, " * 9 + "and its end"
    prior = Prior(1500.0, 80.0, "204 measured vehicles, a source with a long name")
    results = replace(
        bare(),
        verdict={
            e.name: e
            for e in (
                _told("mass_kg", long, prior=prior),
                _told("sprung_mass_kg", long, prior=prior),
                _told("roll_gradient_degpg", "from the log alone: " + long, value=6.9),
                _told("cg_height_m", "the log does not tell it: " + long),
                _told("cg_lateral_offset_m", long),
            )
        },
    )
    document = build_document(results)
    rows = [[c.text for c in row] for row in document.verdict.rows]
    assert [row[0] for row in rows] == [
        "CG height above ground",
        "Roll gradient",
        "Mass; Sprung mass",
        "CG lateral offset (+ left)",
    ]
    assert rows[0][-2] == "Roll motion gives a ratio only; a further clause of the same reason\xa0…"
    assert rows[2][-1] == "1500 ±\xa080\u202fkg; 1500 ±\xa080\u202fkg"
    assert max(len(row[-2]) for row in rows) <= 110
    detail = Page(html_of(document).split('id="detail"')[1].split("<section")[0]).text
    assert "the same reason, and its end." in detail
    assert "204 measured vehicles, a source with a long name" in detail
    assert detail.count("Sprung mass") == 1


def test_no_check_is_passed_off_as_agreement() -> None:
    sample = replace(rich(), estimates=(), signals=(), joint=None)  # no figure is looked at here
    quiet = replace(
        sample.record, decisions=(), notes=("not checked against physics: lateral signs: no yaw rate",)
    )

    def card(record: ImportRecord) -> str:
        html = html_of(build_document(replace(sample, record=record)))
        return Page(html.split("Signs, units and spikes")[1].split("Data quality")[0]).text

    assert "Nothing found in what could be checked." in card(quiet)
    assert "not checked lateral signs: no yaw rate" in card(quiet)
    assert "Nothing found: signs, units and ranges agree." in card(replace(quiet, notes=()))
    assert "not checked" in card(replace(sample.record, notes=quiet.notes))


def test_columns_that_say_nothing_are_left_out(bare_document: Document) -> None:
    assert [c.title for c in bare_document.verdict.columns] == ["Parameter", "Verdict", "Why, in short"]


def test_what_repeats_the_prior_is_no_result() -> None:
    prior = Prior(0.55, 0.03, "measured vehicles")
    same = ParameterEstimate("cg_height_m", 0.55, 0.03, 0.4912, 0.6088, "not_identifiable", "no roll", prior)
    html = render_html(replace(bare(), verdict={"cg_height_m": same}))
    text = Page(html).text
    assert "It gives no CG height: no roll." in text
    assert "(0.491–0.609)prior only" in text
    assert "0.550 ± 0.030\u202fm" in text


def test_prior_only_stands_beside_the_priors_figures_alone() -> None:
    prior = Prior(0.55, 0.03, "measured vehicles")
    same = ParameterEstimate("cg_height_m", 0.5502, 0.03, 0.4912, 0.6090, "not_identifiable", "", prior)
    assert interval_cell(same).sub == "prior only"
    for other in (
        replace(same, low=0.45, high=1.94, value=1.196),
        replace(same, low=0.479),
        replace(same, high=0.621),
        replace(same, value=0.562),
        replace(same, prior=None),
    ):
        assert interval_cell(other).sub == "no result"
        assert interval_cell(other).text.startswith("(")
    assert interval_cell(replace(same, status="weak")).sub == ""
    assert interval_cell(replace(same, value=None, low=None, high=None)).text == "—"


def test_parameters_that_failed_alike_share_a_line(rich_document: Document) -> None:
    titles = [row[0].text for row in rich_document.verdict.rows]
    assert "Corner mass fl, fr, rl, rr" in titles
    assert len(titles) == 11


def test_the_error_table(rich_document: Document) -> None:
    errors = next(s for s in rich_document.sections if s.anchor == "errors")
    row = [c.text for c in errors.blocks[0].rows[0]]  # type: ignore[union-attr]
    assert row == [
        "CG height above ground",
        "0.558\u202fm",
        "0.549\u202fm",
        "+0.009",
        "+1.7",
        "0.502–0.614",
        "inside",
        "+0.3",
    ]
    damping = [c.text for r in errors.blocks[0].rows if r[0].text == "Roll damping ratio" for c in r]  # type: ignore[union-attr]
    assert "outside" in damping
    assert "−2.8" in damping
    methods = errors.blocks[1]
    assert isinstance(methods, Folded)
    assert [c.text for c in methods.blocks[0].rows[0]][:2] == ["CG height above ground", "Roll dynamics"]  # type: ignore[union-attr]


def test_without_a_reference_there_is_no_error_table(bare_document: Document) -> None:
    assert "errors" not in [s.anchor for s in bare_document.sections]


def test_contents_lead_to_every_chapter(rich_html: str) -> None:
    page = Page(rich_html)
    anchors = {attrs["id"] for _, attrs in page.tags if attrs.get("id")}
    links = {str(attrs["href"])[1:] for tag, attrs in page.tags if tag == "a"}
    assert links <= anchors
    assert {
        "errors",
        "tracks",
        "fits",
        "signals",
        "quality",
        "mapping",
        "estimators",
        "assumptions",
        "provenance",
    } <= links


def test_identifiers_are_unique(rich_html: str) -> None:
    found = [attrs["id"] for _, attrs in Page(rich_html).tags if attrs.get("id")]
    assert len(found) == len(set(found))


def test_every_chapter_of_the_mapping_estimators_and_provenance(rich_html: str) -> None:
    text = Page(rich_html).text
    for words in (
        "LatAcc", "from: channel units line", "VBOX profile", "/vehicle/wheel_odometry/twist.twist.linear.x", "needs drive_torque".capitalize(),
        "load_transfer", "failed", "skipped", "cogest analyze logs/slalom_35kph.vbo --vehicle", "3f8a" * 16, "77ab" * 16, "roll_map.bank_std_deg",
        "row with too few columns", "18\u202f234",
    ):  # fmt: skip
        assert words in text, words


def test_the_four_wheels_share_a_row_where_only_the_name_differs() -> None:
    rule = "canonical column '{}'"
    wheels = [
        MappedChannel(f"wheel_speed_{w}", f"wheel_speed_{w}_mps", "m/s", "name", rule.format(f"wheel_speed_{w}_mps"), 9, 100.0)
        for w in ("fl", "fr", "rl", "rr")
    ]  # fmt: skip
    sample = rich()

    def signals_of(mapped: list[MappedChannel]) -> list[str]:
        record = replace(sample.record, mapped=tuple(mapped))
        table = mapping.build(replace(sample, record=record, signals=()), {})[0]
        return [row[0].text for row in table.rows]  # type: ignore[union-attr]

    assert signals_of(wheels) == ["wheel_speed_fl, fr, rl, rr"]
    scaled = [*wheels[:3], replace(wheels[3], scale=1.02)]
    assert signals_of(scaled) == ["wheel_speed_fl, fr, rl", "wheel_speed_rr"]
    profile = [replace(w, rule="a profile") for w in wheels]
    assert len(signals_of(profile)) == 4


def test_a_bare_drive_gives_a_whole_report(bare_document: Document) -> None:
    text = Page(html_of(bare_document)).text
    assert "Vehicle not described (robot.mcap)" in text
    assert text.count("Not drawn") >= 5
    assert "no channel of the log became a signal" in text


def test_long_names_may_break_but_stay_the_same_text() -> None:
    made = breakable("/very/long/topic.name_of<b>&x")
    assert "<wbr>" in made
    assert Page(str(made)).text == "/very/long/topic.name_of<b>&x"


def test_half_an_hour_of_thirty_signals_stays_small() -> None:
    long = signals(1800.0)[0]
    rng = np.random.default_rng(0)
    many = tuple(
        Trace(f"accel_z_{i}", long.time_s, {f"c{i}": rng.normal(size=long.time_s.size)}, {f"c{i}": "m/s²"})
        for i in range(30)
    )
    sample = rich()
    gaps = tuple(Gap(float(a), float(a) + 0.01) for a in rng.uniform(0, 1790, 20_000))
    decisions = tuple(Decision(f"s{i}", "range", "found " * 200, "left", "e", True) for i in range(3000))
    mapped = tuple(MappedChannel("accel_x", "/topic" * 400, "m/s²", "x", "y", 1, 1.0) for _ in range(3000))
    record = replace(
        sample.record,
        gaps=gaps,
        decisions=decisions,
        mapped=mapped,
        duration_s=1800.0,
        rejected={f"r{i}": 1 for i in range(9000)},
    )
    heavy = replace(sample, signals=many, record=record, notes=tuple(f"note {i}" for i in range(5000)))
    html = render_html(heavy)
    assert len(html.encode()) < 2_500_000


def test_nhtsa_bands_and_careful_words() -> None:
    assert [band_of(f)[0] for f in (1.50, 1.446, 1.44, 1.25, 1.244, 1.13, 1.04, 1.03)] == [
        5,
        5,
        4,
        4,
        3,
        3,
        2,
        1,
    ]
    spread = ParameterEstimate("static_stability_factor", 1.384, 0.07, 1.24, 1.52, "weak", "")
    words = nhtsa_context(spread)
    assert "4 of 5 stars" in words
    assert "from 3 to 5 stars" in words
    assert "no rating of this vehicle" in words
    assert nhtsa_context(replace(spread, value=None)) == ""
    assert nhtsa_context(replace(spread, status="not_identifiable")) == ""


def test_a_file_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file, no folder")
    with pytest.raises(ReportError, match="taken") as caught:
        write_html(bare(), tmp_path / "taken" / "report.html")
    assert "\n" not in str(caught.value)
    write_html(bare(), tmp_path / "new" / "deep" / "report.html")
    assert [p.name for p in (tmp_path / "new" / "deep").iterdir()] == ["report.html"]


def test_figures_and_intervals_of_dense_tables_do_not_break() -> None:
    rule = re.search(r"\.dense td\.right,\.dense td\.tight \{([^}]*)\}", template_text("report.css"))
    assert rule is not None
    assert "white-space:nowrap" in rule[1]
