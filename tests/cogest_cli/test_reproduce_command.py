"""`cogest reproduce`: every paper prints and writes its page; the same seed gives the same figures."""

from __future__ import annotations

import json

import pytest

from pipelines.reproduce.registry import PAPERS, choose_papers

RUNS = 3
"""Seeds of the study: enough to see every part work, not to judge a method by."""


@pytest.mark.parametrize("name", PAPERS)
def test_every_paper_prints_and_writes_its_page(inside, tmp_path, name):
    done = inside("reproduce", name, "--runs", RUNS, "--out", tmp_path, "--format", "html,json")
    assert done.code == 0
    assert "Claims" in done.out
    data = json.loads((tmp_path / f"{name}.json").read_text(encoding="utf-8"))
    assert data["paper"] == name
    assert data["tables"]
    assert data["claims"]
    for claim in data["claims"]:
        # a claim that differs says why
        assert claim["agreement"] == "agrees" or claim["remark"], claim["published"]
    for table in data["tables"]:
        assert table["rows"]
        assert all(len(row) == len(table["columns"]) for row in table["rows"]), table["place"]
    judged = [row for row in data["study"] if row["target"] is not None]
    assert judged
    for row in judged:
        assert f"Against the {row['yardstick']}" in done.out
        assert row["bound"] > 0
        assert row["coverage"] is not None
    html = (tmp_path / f"{name}.html").read_text(encoding="utf-8")
    assert "What the paper claims" in html
    assert html.count("<svg") >= 1


def test_papers_are_named_in_whatever_case() -> None:
    assert choose_papers("PENCE", PAPERS) == ("pence",)


def test_the_installed_program_repeats_itself_and_names_the_nearest_paper(cogest):
    first, second = (cogest("reproduce", "wu", "--runs", 2, "--seed", 5, COLUMNS="160") for _ in range(2))
    assert first.code == 0, first.err
    assert first.out == second.out
    assert max(len(line) for line in first.out.splitlines()) <= 160
    wrong = cogest("reproduce", "pense")
    assert wrong.code == 2
    assert "did you mean 'pence'" in wrong.err
    assert "known are" in cogest("reproduce", "nope").err  # like none of them
