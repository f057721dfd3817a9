"""The fleet's page: self-contained, escaped, complete, small, the same again."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import polars as pl
import pytest
from sample_fleet import HOSTILE, empty_fleet, facts, sample_fleet, silent_fleet

from reports.fleet.page import script_text
from reports.fleet.payload import script_json
from reports.fleet.write import fleet_pages


def made(tables: dict[str, pl.DataFrame], **others: object) -> str:
    return fleet_pages(tables, facts(**others), ["html"])["fleet.html"].decode()


class Tags(HTMLParser):
    """Every element with its attributes, and the text of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self.cdata_elem == "script":
            self.scripts[-1] += data


def data_of(html: str) -> Any:
    return json.loads(Tags(html).scripts[0])


def test_nothing_is_fetched(fleet_html: str) -> None:
    for tag, attributes in Tags(fleet_html).found:
        for name in ("src", "href", "srcset", "action", "data"):
            link = attributes.get(name)
            assert link is None or link.startswith("#"), f"<{tag} {name}={link}>"
    assert not re.search(r"url\((?!#)|@import", fleet_html)
    assert re.findall(r"https?://[^\"' <]*", fleet_html.replace("http://www.w3.org/2000/svg", "")) == []


def test_only_the_pages_own_script_may_run(hostile_fleet_html: str) -> None:
    tags = Tags(hostile_fleet_html)
    policy = next(a["content"] for t, a in tags.found if a.get("http-equiv") == "Content-Security-Policy")
    digest = base64.b64encode(hashlib.sha256(tags.scripts[1].encode()).digest()).decode()
    assert policy is not None
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert len(tags.scripts) == 2


def test_hostile_text_makes_no_element(fleet_html: str, hostile_fleet_html: str) -> None:
    names = {tag for tag, _ in Tags(hostile_fleet_html).found}
    assert "img" not in names
    assert names <= {tag for tag, _ in Tags(fleet_html).found}
    assert not any(
        name.startswith("on") for _, attributes in Tags(hostile_fleet_html).found for name in attributes
    )
    assert data_of(hostile_fleet_html)["drives"]["name"][0] == HOSTILE[0]
    assert "\u202e" not in hostile_fleet_html


@pytest.mark.parametrize("text", [*HOSTILE[:4], "]]><!--", "\u2028\u2029"])
def test_json_in_a_script_ends_nothing(text: str) -> None:
    shown = script_json({"a": text})
    assert not set("<>&\u2028\u2029") & set(shown)
    assert json.loads(shown) == {"a": text}


def test_the_script_takes_no_text_as_markup() -> None:
    script = script_text()
    for word in (
        "innerHTML",
        "outerHTML",
        "insertAdjacentHTML",
        "document.write",
        "eval(",
        "new Function",
        "fetch(",
    ):
        assert word not in script


def test_the_tables_are_in_the_page(fleet: dict[str, pl.DataFrame], fleet_html: str) -> None:
    data = data_of(fleet_html)
    rows = fleet["drives"]
    assert data["drives"]["name"] == rows["drive"].to_list()
    margins = [None if m is None else round(m, 3) for m in rows["least_margin_g"]]
    assert data["drives"]["margin"] == pytest.approx(margins, abs=1e-9)
    assert [data["drives"]["statuses"][k] for k in data["drives"]["status"]] == rows["status"].to_list()
    assert [data["drives"]["reasons"][k] for k in data["drives"]["reason"]] == rows["reason"].to_list()
    height = next(p for p in data["parameters"] if p["name"] == "cg_height_m")
    assert len(height["joined"]["value"]) == len(height["own"]["status"]) == rows.height
    assert sum(len(v["shared"]) for v in data["vehicles"]) == fleet["vehicles"].height
    assert sum(len(v["trends"]) for v in data["vehicles"]) == fleet["trends"].height


def test_the_chapters_are_there(fleet_html: str) -> None:
    for anchor in (
        "findings",
        "drives",
        "vehicles",
        "distribution",
        "outliers",
        "load-changes",
        "trends",
        "failures",
        "reading",
    ):
        assert f'id="{anchor}"' in fleet_html
    for words in (
        "False-alarm rate 1",
        "not identifiable",
        "1270 measured vehicles",
        "falls: -16.0 % a year",
    ):
        assert words in fleet_html
    assert "&#39;" not in fleet_html[fleet_html.index("<script>") :]


def test_the_same_tables_make_the_same_page(fleet: dict[str, pl.DataFrame], fleet_html: str) -> None:
    assert made(fleet) == fleet_html
    assert made(fleet, created="") != fleet_html


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        (empty_fleet(), "No drive was found"),
        ({}, "No drive was found"),
        (silent_fleet(), "No drive could be analysed"),
        (sample_fleet(5, 1, failed=1.0), "No drive could be analysed"),
        (sample_fleet(1, 1, failed=0.0), "1 vehicle, 1 drive"),
        (sample_fleet(12, 2, dated=0.0), "without a start time"),
    ],
    ids=["empty", "no tables", "nulls", "all failed", "one drive", "no dates"],
)
def test_odd_fleets_make_a_page(tables: dict[str, pl.DataFrame], words: str) -> None:
    html = made(tables)
    assert words in html
    data_of(html)


def test_without_joined_vehicles_the_drives_speak_alone(fleet: dict[str, pl.DataFrame]) -> None:
    alone = {"drives": fleet["drives"], "parameters": fleet["parameters"].filter(pl.col("source") == "drive")}
    data = data_of(made(alone))
    assert all(p["joined"] is None for p in data["parameters"])
    assert any(value is not None for value in data["parameters"][0]["own"]["value"])


def test_a_thousand_drives_are_small(record_property: Callable[[str, object], None]) -> None:
    tables = sample_fleet(1000, 25)
    size = len(made(tables).encode())
    record_property("megabytes", size / 1e6)
    assert size < 3e6
