"""The report as PDF: the same document as the HTML, set by Typst, which comes as a wheel and needs no system package."""

from __future__ import annotations

import json
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from parsers.errors import ReportError
from pipelines.drive_results import DriveResults
from reports.blocks import Document
from reports.document import build_document
from reports.html import template_text


def on_paper(part: Any) -> Any:
    """A document as plain values, with a line in the place of each folded block that is not printed: where it stands."""
    if isinstance(part, dict):
        if part.get("kind") == "folded" and not part["printed"]:
            return {"kind": "note", "text": f"{part['title']}: in {part['elsewhere']}."}
        return {key: on_paper(value) for key, value in part.items()}
    if isinstance(part, list | tuple):
        return [on_paper(value) for value in part]
    return part


def _svgs_to_files(part: Any, folder: Path, count: list[int]) -> Any:
    """Put every figure into a file of its own and its name in its place: Typst reads pictures from files."""
    if isinstance(part, dict):
        if part.get("kind") == "plot":
            names = []
            for svg in part["svgs"]:
                count[0] += 1
                name = f"figure{count[0]}.svg"
                (folder / name).write_text(svg, encoding="utf-8")
                names.append(name)
            return {**part, "svgs": names}
        return {key: _svgs_to_files(value, folder, count) for key, value in part.items()}
    if isinstance(part, list | tuple):
        return [_svgs_to_files(value, folder, count) for value in part]
    return part


def _font_folder() -> Path:
    """DejaVu, which matplotlib brings: the figures' text is set in it, and it fills in for Typst's own fonts."""
    import matplotlib

    return Path(matplotlib.get_data_path()) / "fonts" / "ttf"


def _covered(text: str) -> bool:
    """Whether DejaVu Sans has every character; if not, the machine's own fonts may help."""
    from matplotlib.font_manager import get_font

    known = get_font(str(_font_folder() / "DejaVuSans.ttf")).get_charmap()
    return all(ord(c) in known for c in set(text) if c > "\x7f")


def pdf_of(document: Document) -> bytes:
    """Set a document as PDF. Raises ReportError where Typst cannot.

    The same document gives the same bytes, unless it holds characters that only the machine's own fonts have.
    """
    import typst

    with tempfile.TemporaryDirectory(prefix="cogest-") as name:
        folder = Path(name)
        content = json.dumps(_svgs_to_files(on_paper(asdict(document)), folder, [0]), ensure_ascii=False)
        (folder / "report.json").write_text(content, encoding="utf-8")
        (folder / "report.typ").write_text(template_text("report.typ"), encoding="utf-8")
        try:
            made = typst.compile(
                str(folder / "report.typ"),
                root=str(folder),
                font_paths=[str(_font_folder())],
                ignore_system_fonts=_covered(content),
                timestamp=0,
            )
        except (RuntimeError, OSError, ValueError) as error:
            first = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
            raise ReportError(
                f"the PDF cannot be set ({first})", hint="--format html,json works without it"
            ) from error
    if not isinstance(made, bytes):
        raise ReportError(
            "the PDF cannot be set (no single file came back)", hint="--format html,json works without it"
        )
    return made


def render_pdf(results: DriveResults) -> bytes:
    """Results as PDF bytes."""
    return pdf_of(build_document(results))
