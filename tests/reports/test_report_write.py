"""Reports in a folder: all forms, whole or not at all."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from sample_results import bare

from parsers.errors import ReportError
from reports.archive import load_folder
from reports.files import write_whole
from reports.write import check_drive_reports, check_formats, write_reports


def test_all_three_forms(tmp_path: Path) -> None:
    paths = write_reports(bare(), tmp_path / "a" / "b", ["pdf", "json", "html"])
    assert [p.name for p in paths] == ["report.html", "report.pdf", "results.json"]
    names = ["report.html", "report.pdf", "results.archive.json", "results.json"]
    assert sorted(p.name for p in (tmp_path / "a" / "b").iterdir()) == names
    assert load_folder(tmp_path / "a" / "b") == bare()
    assert paths[1].read_bytes().startswith(b"%PDF")
    assert paths[0].read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_forms_may_come_as_one_text() -> None:
    assert check_formats("pdf, HTML") == ("html", "pdf")


def test_reports_of_a_batch_are_of_a_kind_that_is_named() -> None:
    assert check_drive_reports("pdf, HTML") == ("html", "pdf")
    assert check_drive_reports(" None") == ()
    for odd in ("json", "docx", "html,none", ","):
        with pytest.raises(ReportError, match="html, pdf, or none alone"):
            check_drive_reports(odd)


def test_one_form_only(tmp_path: Path) -> None:
    assert [p.name for p in write_reports(bare(), tmp_path, ["json"])] == ["results.json"]


def test_new_results_leave_no_report_of_earlier_ones(tmp_path: Path) -> None:
    write_reports(bare(), tmp_path, ["html", "json"])
    (tmp_path / "report.pdf").mkdir()
    (tmp_path / "mine.html").write_text("mine")
    write_reports(bare(), tmp_path, ["json"])
    assert (tmp_path / "report.html").exists()
    write_reports(bare(), tmp_path, ["json"], replace=True)
    names = ["mine.html", "report.pdf", "results.archive.json", "results.json"]
    assert sorted(p.name for p in tmp_path.iterdir()) == names


def test_a_report_where_no_run_was_is_somebody_elses(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("mine")
    write_reports(bare(), tmp_path, ["json"], replace=True)
    assert (tmp_path / "report.html").read_text() == "mine"


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ReportError, match="cogest analyze"):
        load_folder(tmp_path)


@pytest.mark.parametrize("formats", [["docx"], [], "html,docx", ""])
def test_an_unknown_form_is_refused(formats: list[str], tmp_path: Path) -> None:
    with pytest.raises(ReportError, match="html, pdf, json"):
        write_reports(bare(), tmp_path, formats)


def test_a_failed_write_leaves_the_old_file_and_no_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "report.html"
    path.write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(ReportError, match="No space left"):
        write_whole(path, b"new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.skipif(os.name != "posix", reason="permissions as on POSIX")
def test_a_report_is_as_readable_as_any_file(tmp_path: Path) -> None:
    write_whole(tmp_path / "report.html", b"x")
    (tmp_path / "plain").write_text("x")
    assert stat.S_IMODE((tmp_path / "report.html").stat().st_mode) == stat.S_IMODE(
        (tmp_path / "plain").stat().st_mode
    )


def test_heavy_libraries_load_only_when_drawn() -> None:
    code = "import sys, reports.write, reports.terminal, reports.document, reports.archive; print([m for m in ('matplotlib', 'typst', 'jinja2') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
