"""A paper's tables and claims beside ours, for a terminal, and as data."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pipelines.reproduce.base import Reproduction
from reports.files import make_folder, write_whole
from reports.layout import printable, wrapped
from reports.reproduction import (
    STUDY_HEADS,
    build_reproduction,
    by_setup,
    figures,
    heading_of,
    study_cells,
    summary,
    target_words,
    yardsticks,
)
from reports.results_json import plain
from reports.text import NARROW, NO_BREAK

ENDINGS = {"html": "html", "pdf": "pdf", "json": "json"}


WIDEST_CELL = 30
"""Columns of a cell beyond which its words are broken over lines."""


def _spaced(text: str) -> str:
    return text.replace(NARROW, " ").replace(NO_BREAK, " ")


def _fitted(rows: Sequence[Sequence[str]], width: int) -> list[int]:
    """Columns' widths: a figure stays on one line, headings and words are broken, the first column gives way first."""
    words = [[max((len(word) for word in cell.split()), default=1) for cell in row] for row in rows]
    least = [max(column) for column in zip(*words, strict=True)]
    body = [max(len(cell) for cell in column) for column in zip(*rows[1:], strict=True)]
    wide = [min(max(low, content), WIDEST_CELL) for low, content in zip(least, body, strict=True)]
    over = sum(wide) + 2 * len(wide) - width
    for i in sorted(range(len(wide)), key=lambda i: wide[i] - least[i], reverse=True):
        less = max(0, min(over, wide[i] - least[i]))
        wide[i] -= less
        over -= less
    return wide


def _grid(rows: Sequence[Sequence[str]], width: int) -> list[str]:
    """Rows as text, the first one the head; all but the first column flush right, cells broken where they must be."""
    cells = [[printable(_spaced(cell)) for cell in row] for row in rows]
    widths = _fitted(cells, width)
    out = []
    for number, row in enumerate(cells):
        pieces = [
            textwrap.wrap(cell, w, break_long_words=False, break_on_hyphens=False) or [""]
            for cell, w in zip(row, widths, strict=True)
        ]
        height = max(map(len, pieces))
        for i, piece in enumerate(pieces):
            gap = [""] * (height - len(piece))
            # a heading stands on its figures, a cell hangs from its line
            pieces[i] = gap + piece if number == 0 else piece + gap
        for line in zip(*pieces, strict=True):
            fitted = [
                part.ljust(w) if i == 0 else part.rjust(w)
                for i, (part, w) in enumerate(zip(line, widths, strict=True))
            ]
            out.append(("  " + "  ".join(fitted)).rstrip())
    return out


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
            *wrapped(f"Against the {yardsticks(rows)}: {setup} ({rows[0].runs} seeds)", width, indent=0),
        ]
        out += _grid([STUDY_HEADS, *(study_cells(row) for row in rows)], width)
        for row in rows:
            if row.remark or target_words(row):
                said = f"{target_words(row)} {row.remark}".strip()
                out += wrapped(f"{row.method}, {row.parameter}: {said}", width)
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
        entry["ratio"], entry["ratio_std"], entry["target_met"] = row.ratio, row.ratio_std, row.target_met
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
