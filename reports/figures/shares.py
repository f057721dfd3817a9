"""Information by relation: how many bits a parameter gained, and how many of them are lost without each relation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from pipelines.drive_results import DriveResults
from pipelines.results import Learned, Share
from reports.figures.drawing import Drawing, Missing
from reports.figures.style import (
    AMBER,
    BLUE,
    FULL_WIDTH,
    GREEN,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    SOFT,
    TEAL,
    new_figure,
    styled,
    to_svg,
)
from reports.sections.joint_words import bits_text, learned_in_order
from reports.sections.values import SINGLE_WHEELS
from reports.text import clean, spec_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = (
    BLUE,
    ORANGE,
    TEAL,
    PURPLE,
    AMBER,
    GREEN,
    "#7fb2d9",
    "#d98f9a",
    "#8c6d4f",
    "#4b4f9e",
    "#b5a642",
    "#5fb3a1",
)
OTHERS = "#a9b4c0"
MOST = 18
LEAST = 0.02


def _summed(entries: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Figures by name; two of one name are added."""
    found: dict[str, float] = {}
    for name, value in entries:
        found[name] = found.get(name, 0.0) + value
    return found


def pieces(learned: Learned) -> tuple[dict[str, float], dict[str, float]]:
    """The bits that are lost without each relation, and each one's part of those that several tell alike.

    All together is what was gained: where relations only help together, each loss is more than its part and is scaled
    down; what several tell alike is shared out by what each tells alone, and is nobody's ("") where that is not known.
    """
    gained = max(learned.bits, 0.0) if math.isfinite(learned.bits) else 0.0
    own = _summed((s.relation, s.bits) for s in learned.shares if math.isfinite(s.bits) and s.bits > 0)
    total = sum(own.values())
    if total > gained:
        return {relation: bits * gained / total for relation, bits in own.items()}, {}
    alone = _summed((s.relation, _bits_alone(learned, s)) for s in learned.shares)
    weight = sum(alone.values())
    if weight <= 0:
        return own, {"": gained - total}
    return own, {relation: (gained - total) * bits / weight for relation, bits in alone.items()}


def _bits_alone(learned: Learned, share: Share) -> float:
    """Information that the prior and this relation alone give."""
    if not (math.isfinite(share.std_alone) and share.std_alone > 0 and learned.prior.std > share.std_alone):
        return 0.0
    return math.log2(learned.prior.std / share.std_alone) if math.isfinite(learned.prior.std) else 0.0


def _legend_order(found: list[tuple[str, Learned]]) -> list[str]:
    """Relations by what they brought to all parameters together."""
    totals: dict[str, float] = {}
    for _, learned in found:
        for part in pieces(learned):
            for relation, bits in part.items():
                totals[relation] = totals.get(relation, 0.0) + bits
    return sorted((r for r, bits in totals.items() if r and bits > LEAST), key=lambda r: -totals[r])


def _bar(axes: Axes, place: int, learned: Learned, colours: dict[str, str]) -> None:
    """For each relation its own bits and, paler, its part of the shared ones."""
    left = 0.0
    own: dict[str, float] = {}
    shared: dict[str, float] = {}
    for part, gathered in zip(pieces(learned), (own, shared), strict=True):
        for relation, bits in part.items():
            colour = colours.get(relation, OTHERS) if relation else PALE
            gathered[colour] = gathered.get(colour, 0.0) + bits
    for colour in (*colours.values(), OTHERS, PALE):
        for bits, alpha in ((own.get(colour, 0.0), 1.0), (shared.get(colour, 0.0), 0.45)):
            if bits > 0:
                axes.barh(place, bits, left=left, height=0.66, color=colour, alpha=alpha, linewidth=0)
                left += bits
    axes.annotate(
        bits_text(learned.bits), (left, place), (4, 0), textcoords="offset points", va="center", fontsize=7.5,
        color=INK if learned.bits > LEAST else SOFT,
    )  # fmt: skip


def draw(results: DriveResults) -> Drawing | Missing:
    """One stacked bar a parameter."""
    if results.joint is None:
        return Missing("Not drawn: no relation of this log entered a joint posterior.")
    found = [
        (name, entry)
        for name, entry in learned_in_order(results)
        if math.isfinite(entry.bits) and not name.startswith(SINGLE_WHEELS)
    ][:MOST]
    order = _legend_order(found)
    if not order:
        return Missing("Not drawn: no relation of this log taught anything that was not known before.")
    colours = dict(zip(order, COLOURS, strict=False))
    with styled():
        rows = -(-(min(len(order), len(COLOURS) + 1) + 1) // 2)
        figure = new_figure(FULL_WIDTH, 0.18 * len(found) + 0.55 + 0.17 * rows)
        axes = figure.subplots()
        for place, (_, learned) in enumerate(reversed(found)):
            _bar(axes, place, learned, colours)
        axes.set_yticks(range(len(found)))
        axes.set_yticklabels([spec_of(name).title for name, _ in reversed(found)])
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("information gained, bits")
        axes.margins(x=0.06, y=0.01)
        named = [(colours[r], clean(r, 60)) for r in order[: len(COLOURS)]]
        if len(order) > len(COLOURS):
            named.append((OTHERS, "other relations"))
        for colour, label in named:
            axes.barh([0], [0], color=colour, label=label)
        figure.legend(loc="outside upper left", ncols=2, handlelength=1.0, handleheight=0.8, labelspacing=0.3)
        svg = to_svg(figure, "shares", "Information gained by parameter and relation")
    return Drawing(
        (svg,),
        "Full colour: what is lost without that relation. Pale: what several relations tell alike, so that it is lost with none of them alone; "
        "shared out by what each of them tells by itself.",
        "Information by relation",
    )
