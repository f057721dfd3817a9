"""Stored results give the same report again; a damaged file is refused in words."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sample_results import bare, hostile, rich

from parsers.errors import ReportError
from pipelines.drive_results import DriveResults
from reports.archive import load_results, save_results
from reports.html import render_html
from reports.reduce import reduce_results
from reports.results_json import to_json


def same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and np.array_equal(a, b, equal_nan=True)
    if hasattr(a, "__dataclass_fields__"):
        return type(a) is type(b) and all(same(getattr(a, f), getattr(b, f)) for f in a.__dataclass_fields__)
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    return a == b or (a != a and b != b)


@pytest.mark.parametrize("sample", [rich(), bare()], ids=["rich", "bare"])
def test_round_trip(sample: DriveResults, tmp_path: Path) -> None:
    save_results(sample, tmp_path / "drive.json")
    loaded = load_results(tmp_path / "drive.json")
    assert same(loaded, reduce_results(sample))
    assert to_json(loaded) == to_json(sample)


@pytest.mark.parametrize("which", ["rich", "hostile"])
def test_the_report_from_the_archive_is_the_same_report(
    which: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    sample = {"rich": rich, "hostile": hostile}[which]()
    save_results(sample, tmp_path / "drive.json")
    assert (tmp_path / "drive.json").stat().st_size < 3_000_000
    assert render_html(load_results(tmp_path / "drive.json")) == request.getfixturevalue(f"{which}_html")


def test_a_later_field_with_a_default_may_be_missing(tmp_path: Path) -> None:
    path = tmp_path / "drive.json"
    save_results(bare(), path)
    raw = json.loads(path.read_text())
    del raw["results"]["notes"]
    raw["results"]["from_the_future"] = 1
    path.write_text(json.dumps(raw))
    assert load_results(path) == replace(bare(), notes=())


def _damage(raw: dict[str, object], how: str) -> object:
    results = raw["results"]
    assert isinstance(results, dict)
    if how == "format":
        raw["cogest_archive"] = 99
    elif how == "missing":
        del results["record"]
    elif how == "type":
        results["record"]["messages"] = "many"
    elif how == "huge number":
        results["record"]["duration_s"] = 10**400
    elif how == "literal":
        results["record"]["status"] = "perfect"
    elif how == "huge array":
        results["signals"][0]["time_s"]["values"] = 10**15
    elif how == "wrong length":
        results["signals"][0]["time_s"]["values"] += 1
    elif how == "bytes":
        results["signals"][0]["time_s"]["zlib"] = "AAAA"
    elif how == "other":
        return {"results": results}
    return raw


@pytest.mark.parametrize(
    "how",
    ["format", "missing", "type", "huge number", "literal", "huge array", "wrong length", "bytes", "other"],
)
def test_a_damaged_archive_is_refused_in_one_line(how: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.json"
    save_results(rich(), path)
    path.write_text(json.dumps(_damage(json.loads(path.read_text()), how)))
    with pytest.raises(ReportError) as caught:
        load_results(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe\x00", b"[" * 100_000])
def test_what_is_no_archive_is_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "drive.json").write_bytes(content)
    with pytest.raises(ReportError):
        load_results(tmp_path / "drive.json")
    with pytest.raises(ReportError, match="cannot be read"):
        load_results(tmp_path / "absent.json")
