"""What a report is made of, whatever it is printed as.

`reports.document` builds one `Document`; the HTML template and the Typst template print the same one, so that both
say the same. Every text in here is plain: no markup, and nothing is ever read as markup.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from reports.text import DASH

Tone = Literal["plain", "good", "warn", "bad", "quiet"]
CellKind = Literal["text", "code", "badge", "bar", "meter"]
Align = Literal["left", "right", "center"]


@dataclass(frozen=True)
class Bar:
    """A parameter's prior (grey) and interval (coloured) on one scale: all in 0-100, None where there is none."""

    prior_low: float | None = None
    prior_high: float | None = None
    low: float | None = None
    high: float | None = None
    value: float | None = None
    reference: float | None = None
    tone: Tone = "plain"


@dataclass(frozen=True)
class Cell:
    """One cell. sub: a second, quieter line. lines: further lines below the text.

    bar: for kind "bar", whose `text` is what a reader hears, and for kind "meter", which prints the text and the bar.
    """

    text: str
    sub: str = ""
    kind: CellKind = "text"
    tone: Tone = "plain"
    bar: Bar | None = None
    lines: tuple[str, ...] = ()


@dataclass(frozen=True)
class Column:
    """A column's head. weight: its share of the page's width; 0 = as narrow as its content."""

    title: str
    align: Align = "left"
    weight: float = 1.0


@dataclass(frozen=True)
class Table:
    """Rows of cells; the first column leads. note: printed below. dense: in smaller type, for long tables of figures."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: str = ""
    note: str = ""
    dense: bool = False
    kind: Literal["table"] = "table"


def _says_something(cell: Cell) -> bool:
    return cell.bar is not None or cell.text not in ("", DASH)


def filled(table: Table) -> Table:
    """A table without the columns that say nothing in any row."""
    kept = [i for i in range(len(table.columns)) if any(_says_something(row[i]) for row in table.rows)]
    columns = tuple(table.columns[i] for i in kept)
    return replace(table, columns=columns, rows=tuple(tuple(row[i] for i in kept) for row in table.rows))


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of plain text."""

    text: str
    tone: Tone = "plain"
    kind: Literal["paragraph"] = "paragraph"


@dataclass(frozen=True)
class Heading:
    """A heading inside a section."""

    text: str
    kind: Literal["heading"] = "heading"


@dataclass(frozen=True)
class Item:
    """One line of a list. badge: a word in front of it, in a tone."""

    text: str
    badge: str = ""
    tone: Tone = "plain"


@dataclass(frozen=True)
class Bullets:
    """A list of sentences."""

    items: tuple[Item, ...]
    kind: Literal["bullets"] = "bullets"


@dataclass(frozen=True)
class Fact:
    """A labelled figure or text. code: print it as a name (paths, hashes, commands)."""

    label: str
    text: str
    sub: str = ""
    code: bool = False
    tone: Tone = "plain"


@dataclass(frozen=True)
class Facts:
    """Labelled figures, one below the other. prose: the texts are sentences, not figures."""

    rows: tuple[Fact, ...]
    prose: bool = False
    kind: Literal["facts"] = "facts"


@dataclass(frozen=True)
class Plot:
    """A drawn figure: one or more SVG pieces one below the other; or none, and why. alt: what a reader hears."""

    name: str
    title: str
    svgs: tuple[str, ...]
    caption: str = ""
    missing: str = ""
    alt: str = ""
    kind: Literal["plot"] = "plot"


@dataclass(frozen=True)
class Folded:
    """What only some readers want: on the screen behind its title until it is opened; on paper `printed` in its place,
    or a line that says where it stands. elsewhere: those files.
    """

    title: str
    blocks: tuple[Table | Paragraph | Heading | Bullets | Facts, ...]
    printed: tuple[Table | Paragraph | Heading | Bullets | Facts, ...] = ()
    elsewhere: str = "report.html and results.json"
    kind: Literal["folded"] = "folded"


Block = Table | Paragraph | Heading | Bullets | Facts | Plot | Folded


@dataclass(frozen=True)
class Card:
    """A box on the first screen."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Section:
    """A chapter behind the first screen. anchor: its address in the file. short: its name in the contents."""

    anchor: str
    title: str
    short: str
    blocks: tuple[Block, ...]
    intro: str = ""


@dataclass(frozen=True)
class Document:
    """A whole report. lead: the figures of the first screen.

    alerts: what a reader must know before the verdict, above its table. verdict_title: what stands above its first table.
    claims: that table holds sentences, not a verdict's figures.
    """

    title: str
    subtitle: str
    summary: str
    verdict: Table
    cards: tuple[Card, ...]
    lead: tuple[Plot, ...]
    sections: tuple[Section, ...]
    footer: str
    version: str
    facts: tuple[Fact, ...] = field(default=())
    alerts: tuple[Item, ...] = ()
    verdict_title: str = "Verdict"
    claims: bool = False
