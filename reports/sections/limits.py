"""What limited the result, in the first screen's words."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from reports.blocks import Block, Bullets, Item, Paragraph
from reports.text import gist, sentence

MOST = 8


def build(results: DriveResults) -> tuple[Block, ...]:
    """The card's blocks."""
    if not results.limits:
        return (
            Paragraph(
                "Nothing in particular: every estimator that was asked for had what it needs.", "quiet"
            ),
        )
    items = [Item(sentence(gist(limit, 320))) for limit in results.limits[:MOST]]
    if len(results.limits) > MOST:
        items.append(Item(f"{len(results.limits) - MOST} more are in results.json.", tone="quiet"))
    return (Bullets(tuple(items)),)
