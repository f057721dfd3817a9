"""Text for a terminal: names cut in their middle, columns that fit, and characters that the terminal can show."""

from __future__ import annotations

import codecs
import shutil
import textwrap
from collections.abc import Sequence
from io import TextIOWrapper

NARROWEST, WIDEST = 80, 200
USUAL = 160
"""Columns where the output is no terminal: room for long names, as it is read in a file or a pager."""

LEAST_LAST = 30
"""Columns that the last column of a table gets at least: it holds sentences."""

LEAST_NAME = 20

_PLAIN = str.maketrans(
    {
        "±": "+-", "–": "-", "—": "-", "−": "-", "…": "...", "×": "x", "·": ".", "°": "deg", "µ": "u", "μ": "u",
        "²": "2", "³": "3", "π": "pi", "█": "#", "\u00a0": " ", "\u202f": " ", "→": "->",
        "⁻": "^-", "⁰": "0", "¹": "1", "⁴": "4", "⁵": "5", "⁶": "6", "⁷": "7", "⁸": "8", "⁹": "9",
    }
)  # fmt: skip
_HANDLER = "cogest-plain"


def _replaced(error: UnicodeError) -> tuple[str, int]:
    """Codec error handler: what the encoding lacks in plain characters, "?" where there are none."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    plain = error.object[error.start : error.end].translate(_PLAIN)
    return "".join(c if c.isascii() else "?" for c in plain), error.end


def never_fail(stream: TextIOWrapper) -> None:
    """Let a stream print every text, whatever its encoding: ± becomes +-, a letter that it lacks a question mark."""
    codecs.register_error(_HANDLER, _replaced)
    stream.reconfigure(errors=_HANDLER)


def terminal_width() -> int:
    """Columns to fill: the terminal's within reason, a usual page where the output is none."""
    return max(NARROWEST, min(WIDEST, shutil.get_terminal_size((USUAL, 24)).columns))


def printable(text: str) -> str:
    """A log's text without control characters: a terminal must not be steered by a file."""
    return "".join(c if c.isprintable() else "?" for c in text)


def middle(text: str, width: int) -> str:
    """Cut a long name in its middle: its end tells most, its beginning where it is from."""
    if len(text) <= width:
        return text
    head = max(1, (width - 1) // 3)
    return text[:head] + "…" + text[len(text) - (width - 1 - head) :]


def wrapped(text: str, width: int, *, indent: int = 2, hang: int = 2) -> list[str]:
    """Lines of a sentence: indented, the further ones by `hang` more; long names are not broken."""
    lines = textwrap.wrap(
        printable(text), width, initial_indent=" " * indent, subsequent_indent=" " * (indent + hang),
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    return lines or [""]


def _widths(cells: Sequence[Sequence[str]], width: int, names: Sequence[int]) -> list[int]:
    """Columns' widths but for the last: names share what the others leave."""
    last = len(cells[0]) - 1
    widths = [max(len(row[i]) for row in cells) for i in range(last)]
    tail = min(LEAST_LAST, max(len(row[last]) for row in cells))
    room = width - 2 - 2 * last - tail - sum(w for i, w in enumerate(widths) if i not in names)
    for place, i in enumerate(sorted(names, key=lambda i: widths[i])):
        widths[i] = min(widths[i], max(LEAST_NAME, room // (len(names) - place)))
        room -= widths[i]
    return widths


def table(
    rows: Sequence[Sequence[str]], width: int, *, right: Sequence[int] = (), names: Sequence[int] = ()
) -> list[str]:
    """Set rows (the first is the head) in columns of text; the last column wraps.

    right: columns set flush right. names: columns that may be narrower than their content: a long name in the first
    column stands on a line of its own, above the rest of its row, and one in another column is cut in its middle.
    """
    cells = [[printable(cell) for cell in row] for row in rows]
    widths = _widths(cells, width, names)
    start = 2 + sum(widths) + 2 * len(widths)
    out = []
    for row in cells:
        if len(row[0]) > widths[0]:
            if not any(row[1:-1]):
                out.append(f"  {middle(row[0], width - 4 - len(row[-1]))}  {row[-1]}")
                continue
            out.append("  " + middle(row[0], width - 2))
            row = ["", *row[1:]]
        fitted = [
            middle(cell, w).rjust(w) if i in right else middle(cell, w).ljust(w)
            for i, (cell, w) in enumerate(zip(row, widths, strict=False))
        ]
        text = textwrap.wrap(row[-1], max(LEAST_LAST, width - start), break_long_words=False) or [""]
        out.append(("  " + "  ".join((*fitted, text[0]))).rstrip())
        out += [" " * start + line for line in text[1:]]
    return out
