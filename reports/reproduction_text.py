"""A paper's tables and claims beside ours, for a terminal, and as data."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pipelines.reproduce.base import Reproduction
from reports.files import make_folder, write_whole
from reports.layout import printable, table, wrapped
from reports.reproduction import (
    STUDY_HEADS,
    build_reproduction,
    by_setup,
    figures,
    heading_of,
    met,
    study_cells,
    summary,
)
from reports.results_json import plain
from reports.text import NARROW, NO_BREAK

ENDINGS = {"html": "html", "pdf": "pdf", "json": "json"}


def _spaced(text: str) -> str:
    return text.replace(NARROW, " ").replace(NO_BREAK, " ")


def _grid(rows: Sequence[Sequence[str]], width: int) -> list[str]:
    """Rows as text, all but the first column flush right."""
    cells = [[_spaced(cell) for cell in row] for row in rows]
    # the last column of a text table wraps as a sentence would: an empty one keeps the figures in line
    closed = [[*row, ""] for row in cells]
    return [line.rstrip() for line in table(closed, width, right=range(1, len(rows[0])), names=(0,))]


def reproduction_text(reproduction: Reproduction, width: int) -> str:
    """Claims, study, tables and remarks as plain text of at most `width` columns."""
    out = [
        printable(reproduction.title),
        *wrapped(reproduction.citation, width),
        *wrapped(summary(reproduction), width),
        "",
    ]
    out.append("Claims")
    for claim in reproduction.claims:
        out += wrapped(f"[{claim.agreement}] {claim.place}: {claim.published}", width)
        out += wrapped(f"ours: {claim.ours}", width, indent=4)
        if claim.companion:
            out += wrapped(f"companion: {claim.companion}", width, indent=4)
        if claim.remark:
            out += wrapped(claim.remark, width, indent=4)
    for setup, rows in by_setup(reproduction.study).items():
        out += [
            "",
            *wrapped(f"Against the Cramér-Rao bound: {setup} ({rows[0].runs} seeds)", width, indent=0),
        ]
        out += _grid([STUDY_HEADS, *(study_cells(row) for row in rows)], width)
        for row in rows:
            if row.remark or met(row) is False:
                missed = "target missed. " if met(row) is False else ""
                out += wrapped(f"{row.method}, {row.parameter}: {missed}{row.remark}", width)
    for entry in reproduction.tables:
        out += ["", *wrapped(f"{entry.place}: {entry.title}", width, indent=0)]
        heads = [heading_of(column) for column in entry.columns]
        body = [[figures(v, c.digits) for v, c in zip(row, entry.columns, strict=True)] for row in entry.rows]
        out += _grid([heads, *body], width)
        if entry.remark:
            out += wrapped(entry.remark, width)
    out += ["", "Set-up"]
    for text in (*reproduction.setup, *reproduction.notes):
        out += wrapped(f"- {text}", width)
    return "\n".join(out)


def reproduction_json(reproduction: Reproduction, version: str) -> str:
    """All figures as JSON, without the traces."""
    data = asdict(reproduction)
    for name in ("traces", "scatters"):
        data.pop(name)
    for row, entry in zip(reproduction.study, data["study"], strict=True):
        entry["ratio"] = row.ratio
    return (
        json.dumps(plain({"cogest": version, **data}), ensure_ascii=False, allow_nan=False, indent=2) + "\n"
    )


def write_reproduction(
    reproduction: Reproduction, version: str, out: Path, formats: Sequence[str]
) -> list[Path]:
    """Write <paper>.html, .pdf, .json into `out` and give their paths. Raises ReportError."""
    make_folder(out)
    made: dict[str, bytes] = {}
    if "json" in formats:
        made["json"] = reproduction_json(reproduction, version).encode("utf-8")
    if "html" in formats or "pdf" in formats:
        from reports.html import html_of
        from reports.pdf import pdf_of

        document = build_reproduction(reproduction, version)
        if "html" in formats:
            made["html"] = html_of(document).encode("utf-8")
        if "pdf" in formats:
            made["pdf"] = pdf_of(document)
    paths = []
    for name in formats:
        path = out / f"{reproduction.paper}.{ENDINGS[name]}"
        write_whole(path, made[name])
        paths.append(path)
    return paths
