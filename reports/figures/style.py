"""How every figure looks, and how it becomes a small, deterministic SVG that may stand inside an HTML page."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FULL_WIDTH = 8.6
LEAD_WIDTH, LEAD_HEIGHT = 3.75, 2.3
"""Inches. A page in print takes up the full width; the first screen holds two figures side by side and a card."""

INK = "#1f2933"
SOFT = "#5f6b7a"
GRID = "#e3e8ee"
BLUE = "#1c5d99"
ORANGE = "#c8591a"
TEAL = "#2a8a7f"
PURPLE = "#7a4fa3"
GREEN = "#1a7f4e"
AMBER = "#a86400"
GREY = "#7b8794"
PALE = "#cbd3dc"
GAP = "#f3e3d3"
LINES = (BLUE, ORANGE, TEAL, PURPLE, GREY, AMBER)
STATUS_COLOURS = {"identified": GREEN, "weak": AMBER, "not_identifiable": GREY}

FONTS = "'DejaVu Sans', Verdana, 'Helvetica Neue', Arial, sans-serif"

_STYLE: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text: small, sharp and selectable; widths are DejaVu's, the widest of FONTS
    "svg.image_inline": True,
    "font.family": ["DejaVu Sans"],
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.titleweight": "normal",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "lines.linewidth": 0.9,
    "lines.solid_capstyle": "round",
    "text.color": INK,
    "text.parse_math": False,  # a "$" in a channel's name is a dollar
    "text.usetex": False,
    "path.simplify": False,  # the traces are thinned already, and here no peak may go
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "agg.path.chunksize": 0,
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw inside this: our style over matplotlib's own defaults, whatever the user's matplotlibrc says."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        # A channel's name in another script is measured without its glyphs; the viewer's font shows it.
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        warnings.filterwarnings(
            "ignore", message="Matplotlib currently does not support", category=UserWarning
        )
        warnings.filterwarnings(
            "ignore", category=DeprecationWarning
        )  # setting old parameters to their defaults
        parameters: Any = matplotlib.rcParams
        parameters.update({k: v for k, v in matplotlib.rcParamsDefault.items() if k != "backend"})
        parameters.update(_STYLE)
        yield


def new_figure(width: float, height: float) -> Figure:
    """An empty figure in inches, bound to no window and to no global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_STYLE_TAG = re.compile(r"\s*<defs>\s*<style[^>]*>.*?</style>\s*</defs>", re.DOTALL)
_COMMENT = re.compile(r"\s*<!--.*?-->", re.DOTALL)
_ID = re.compile(r' id="([^"]*)"')
_DECIMALS = re.compile(r"(?<=\.\d\d)\d+")
_PATH = re.compile(r' d="([^"]*)"')
_BREAKS = re.compile(r"\s*\n\s*")
_ROOT = re.compile(r"<svg ([^>]*)>")
_SIZE = re.compile(r' (?:width|height)="[^"]*pt"')
_FAMILY = re.compile(r"(?:font-family: [^;\"]*;? ?)")


def _short_path(match: re.Match[str]) -> str:
    steps = _BREAKS.sub("", _DECIMALS.sub("", match.group(1))).strip()
    return f' d="{steps}"'


LEAST_PLAIN, MOST_PLAIN, PLAIN_SPAN = 1e-3, 1e4, 0.05
"""An axis that reaches so far, over at least this share of it, is never labelled with an offset or a power of ten."""


def _labelled_plainly(axes: Axes) -> bool:
    low, high = axes.get_ylim()
    reach = max(abs(low), abs(high))
    return LEAST_PLAIN < reach < MOST_PLAIN and abs(high - low) > PLAIN_SPAN * reach


def _place_less(figure: Figure) -> None:
    """Spare matplotlib places that are known: each costs a measuring of every tick, at every pass of the layout.

    A label that is empty needs none. A title stands at the top of its axes unless the power of ten above the axis is in its
    way; to say so of one of an axes' three titles (this one is empty) is to say it of all.
    """
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if not axis.get_label_text():
                axis.set_label_coords(0.0, 0.0)
        if not axes.get_title(loc="center") and _labelled_plainly(axes):
            axes.set_title("", loc="center", y=1.0)


def to_svg(figure: Figure, name: str, label: str) -> str:
    """Print a figure as one `<svg>` element without identifiers that could meet another figure's.

    name: makes the identifiers its own. label: the accessible name; it is escaped here.
    """
    from xml.sax.saxutils import escape

    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    _place_less(figure)
    target = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": name}):
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(target, metadata={"Date": None, "Creator": None, "Type": None, "Format": None})
    svg = _HEAD.sub("", target.getvalue(), count=1)
    for pattern in (_METADATA, _STYLE_TAG, _COMMENT):
        svg = pattern.sub("", svg)
    used = set(re.findall(r'(?:url\(#|href="#)([^")]*)', svg))
    svg = _ID.sub(lambda m: f' id="{name}-{m.group(1)}"' if m.group(1) in used else "", svg)
    svg = re.sub(r'(url\(#|href="#)', rf"\g<1>{name}-", svg)
    svg = _FAMILY.sub("", _PATH.sub(_short_path, svg))
    svg = svg.replace("xlink:href", "href").replace(' xmlns:xlink="http://www.w3.org/1999/xlink"', "")
    root = f'role="img" font-family="{FONTS}" stroke-linejoin="round" stroke-linecap="butt"'
    title = f"<title>{escape(label)}</title>"
    svg = _ROOT.sub(lambda m: f"<svg {root} {m.group(1)}>{title}", svg, count=1)
    return _BREAKS.sub("\n", svg).strip()


def finish(axes: Axes) -> None:
    """Ticks that do not crowd."""
    axes.margins(x=0.01)
    axes.locator_params(axis="y", nbins=5)
