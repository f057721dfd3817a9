"""The PDF report: the same document, set by Typst."""

from __future__ import annotations

import re
import zlib
from dataclasses import asdict, replace

import pytest
from sample_results import rich

from parsers.errors import ReportError
from reports.blocks import Document, Folded, Paragraph, Section
from reports.document import build_document
from reports.pdf import on_paper, pdf_of


def page_count(pdf: bytes) -> int:
    """Pages, from the page tree or, where that is packed, from the object streams."""
    packed = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    parts = [pdf]
    for part in packed:
        try:
            parts.append(zlib.decompress(part))
        except zlib.error:
            continue
    return sum(len(re.findall(rb"/Type\s*/Page\b(?!s)", part)) for part in parts)


def test_a_rich_drive_fills_a_few_pages(rich_document: Document) -> None:
    pdf = pdf_of(rich_document)
    assert pdf.startswith(b"%PDF")
    assert 4 <= page_count(pdf) <= 9
    assert len(pdf) < 2_000_000
    assert pdf_of(rich_document) == pdf


def test_what_is_not_printed_is_said_in_its_place(rich_document: Document) -> None:
    folded = [b for s in rich_document.sections for b in s.blocks if isinstance(b, Folded)]
    left_out = [block.title for block in folded if not block.printed]
    assert left_out
    assert len(left_out) < len(folded)
    printed = [b for s in on_paper(asdict(rich_document))["sections"] for b in s["blocks"]]
    notes = [block["text"] for block in printed if block["kind"] == "note"]
    assert [note.partition(": in report.html")[0] for note in notes] == left_out
    assert "Every method's reason for its status: in report.html and results.json." in notes


def test_a_bare_drive_is_short(bare_document: Document) -> None:
    assert 1 <= page_count(pdf_of(bare_document)) <= 3


def test_hostile_text_is_set_as_text(hostile_document: Document) -> None:
    assert pdf_of(hostile_document).startswith(b"%PDF")


def test_text_is_never_read_as_typst(bare_document: Document) -> None:
    nasty = '#panic("run") #read("/etc/passwd") #import "@preview/x:1.0.0" $x$ = h \\ ` ``` <l> @r // /* #{'
    document = replace(
        bare_document, title=nasty, sections=(Section("a", nasty, "a", (Paragraph(nasty),), nasty),)
    )
    assert pdf_of(document).startswith(b"%PDF")


def test_a_picture_that_typst_cannot_read_is_a_known_error(bare_document: Document) -> None:
    broken = replace(bare_document.lead[0], svgs=("<svg",), missing="")
    with pytest.raises(ReportError, match="PDF cannot be set"):
        pdf_of(replace(bare_document, lead=(broken,)))


def test_twenty_methods_that_all_tell_the_same_stay_short() -> None:
    sample = rich()
    one = replace(
        sample.estimates[0], parameters=dict(sample.verdict), diagnostics={f"figure_{i}": 1.0 for i in range(24)},
        traces=(), tracks=(), scatters=(), reason="a reason of usual length, as methods give it",
    )  # fmt: skip
    many = tuple(replace(one, estimator=f"method_{i}", witness=i > 9) for i in range(20))
    document = build_document(replace(sample, estimates=many, signals=()))
    assert page_count(pdf_of(document)) <= 13
