"""The PDF's first page: the decisions on signs and units are on it, however long the verdict is."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import pytest
from sample_results import rich

from pipelines.drive_results import DriveResults
from pipelines.parameters import PARAMETERS
from reports.document import build_document
from reports.pdf import pdf_of

pytestmark = pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext on this machine")


def with_verdict_of(parameters: int) -> DriveResults:
    """The sample with so many parameters told, each with a prior."""
    sample = rich()
    told = next(e for e in sample.verdict.values() if e.status == "identified" and e.prior is not None)
    return replace(sample, verdict={name: replace(told, name=name) for name in [*PARAMETERS][:parameters]})


def first_page(results: DriveResults) -> str:
    done = subprocess.run(
        ["pdftotext", "-l", "1", "-layout", "-", "-"],
        input=pdf_of(build_document(results)), capture_output=True, check=True,
    )  # fmt: skip
    return done.stdout.decode("utf-8")


@pytest.mark.parametrize("parameters", [12, 21, len(PARAMETERS)])
def test_signs_and_units_are_on_the_first_page(parameters: int) -> None:
    assert "Signs, units and spikes" in first_page(with_verdict_of(parameters))


def test_a_usual_verdict_leaves_room_for_all_cards() -> None:
    page = first_page(with_verdict_of(18))
    for title in ("Rollover", "What limited the result", "Signs, units and spikes", "Data quality"):
        assert title in page
