"""Small multiples: many panels over the same time, in pieces that fit a page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

from reports.figures.style import FULL_WIDTH, new_figure, to_svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PanelT = TypeVar("PanelT")


def panels(
    name: str,
    label: str,
    items: Sequence[PanelT],
    draw: Callable[[Axes, PanelT], None],
    *,
    across: int = 2,
    rows_a_piece: int = 6,
    row_height: float = 1.25,
    shared_x: str | None = "time, s",
) -> tuple[str, ...]:
    """Draw one panel an item, `across` in a row; a new SVG every `rows_a_piece` rows.

    shared_x: what all panels have across, written below the lowest; None = each panel has its own.
    """
    if shared_x is not None:
        across = min(across, len(items))
    a_piece = across * rows_a_piece
    pieces: list[str] = []
    for start in range(0, len(items), a_piece):
        part = items[start : start + a_piece]
        rows = -(-len(part) // across)
        figure = new_figure(FULL_WIDTH, rows * row_height + 0.35)
        grid = figure.subplots(rows, across, squeeze=False)
        flat = [axes for row in grid for axes in row]
        for place, axes in enumerate(flat):
            if place >= len(part):
                axes.set_axis_off()
                continue
            draw(axes, part[place])
            if shared_x is None:
                continue
            if place + across >= len(part):
                axes.set_xlabel(shared_x)
            else:
                axes.tick_params(labelbottom=False)
        pieces.append(to_svg(figure, f"{name}{len(pieces)}", label))
    return tuple(pieces)
