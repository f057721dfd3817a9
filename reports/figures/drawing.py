"""What a figure gives back: a drawing, or the reason why there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pipelines.drive_results import DriveResults


@dataclass(frozen=True)
class Drawing:
    """A drawn figure. svgs: pieces one below the other, so that a page can break between them.

    caption: printed below. alt: what a reader who cannot see it is told. title: in place of the figure's own, where what is drawn
    depends on the drive.
    """

    svgs: tuple[str, ...]
    caption: str
    alt: str
    title: str = ""


@dataclass(frozen=True)
class Missing:
    """No figure, and why, as a sentence."""

    reason: str


@dataclass(frozen=True)
class FigureSpec:
    """One figure of the report. place: "lead" (first screen) or the anchor of the section that it belongs to."""

    name: str
    title: str
    place: str
    draw: Callable[[DriveResults], Drawing | Missing]
