"""Text as a report prints it: cleaned of what a log could smuggle in, and numbers with the digits their interval earns."""

from __future__ import annotations

import math
import re

from pipelines.parameters import PARAMETERS, ParameterSpec

NARROW = "\u202f"
"""Narrow no-break space: between a number and its unit, and between thousands."""
NO_BREAK = "\u00a0"
MINUS = "\u2212"
DASH = "—"
EN_DASH = "–"
MAX_TEXT = 400
NEAR = 0.6
"""Share of a text that a cut at a word's end must leave: a long name without blanks is cut within."""

# Control characters, lone surrogates, non-characters and the marks that turn writing round: none of them belongs in
# a name, XML and Typst refuse the first three, and the last can make a line read as something else than it is.
_UNSAFE = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff\u202a-\u202e\u2066-\u2069\u200e\u200f\ufeff]"
)
_SPACES = re.compile("[ \t\r\n\u2028\u2029]+")


def clean(text: object, limit: int = MAX_TEXT) -> str:
    """Make any text fit for one printed line: unsafe characters become �, white space one space, the rest is cut, at a word's end if near."""
    line = _SPACES.sub(" ", _UNSAFE.sub("\ufffd", str(text)[: 4 * limit])).strip()
    if len(line) <= limit:
        return line
    kept = line[: limit - 1]
    whole = kept if line[limit - 1] == " " else kept.rpartition(" ")[0]
    return (whole if len(whole) >= NEAR * limit else kept).rstrip(" ,;:(") + "…"


def sentence(text: object, limit: int = MAX_TEXT) -> str:
    """Clean a text, begin it with a capital (names with an underscore stay) and end it with a stop."""
    line = clean(text, limit)
    if not line:
        return ""
    first = line.split(" ", 1)[0]
    if first.isalpha() and first.islower():
        line = line[0].upper() + line[1:]
    return line if line[-1] in ".!?…" else line + "."


_LOOSE_ENDS = frozenset(
    ("a", "an", "and", "as", "at", "by", "for", "from", "in", "is", "it", "its", "not", "of", "on", "or", "than", "that", "the", "to", "where", "which", "with")
)  # fmt: skip


def _whole_words(text: str) -> str:
    """A cut text without what cannot stand at an end: an opened bracket, a word that leads to the next."""
    opened = text.rfind("(")
    if opened > len(text) // 2 and ")" not in text[opened:]:
        text = text[:opened]
    words = text.split()
    while len(words) > 2 and words[-1].lower() in _LOOSE_ENDS:
        words.pop()
    return " ".join(words).rstrip(",;:")


def gist(text: object, limit: int = 190) -> str:
    """The first clauses of a long reason, whole ones as far as they fit; all of it where it is short."""
    line = clean(text, 4000)
    if len(line) <= limit:
        return line
    for mark in ("; ", ": ", ", "):
        ends = [found.start() for found in re.finditer(re.escape(mark), line[:limit])]
        if ends and ends[-1] >= limit // 3:
            return line[: ends[-1]] + f"{NO_BREAK}…"
    return _whole_words(line[: limit - 2].rsplit(" ", 1)[0]) + f"{NO_BREAK}…"


def spec_of(name: str) -> ParameterSpec:
    """The parameter's title, unit and digits; a plain one made of the name where it is not in the table."""
    known = PARAMETERS.get(name)
    return known if known is not None else ParameterSpec(name, clean(name, 60), "", 3, positive=False)


def decimals_for(half_width: float | None, otherwise: int) -> int:
    """Digits after the point (negative: tens, hundreds) so that two figures of the half-width show."""
    if half_width is None or not math.isfinite(half_width) or half_width <= 0:
        return otherwise
    return max(-6, min(6, 1 - math.floor(math.log10(half_width))))


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _power_of_ten(value: float, figures: int) -> str:
    """Print a size with so many significant figures as 9.6 × 10¹⁵: nobody should have to read 9.6e+15."""
    mantissa, _, power = f"{value:.{figures - 1}e}".replace("-", MINUS, 1 if value < 0 else 0).partition("e")
    return f"{mantissa}{NARROW}×{NARROW}10{str(int(power)).translate(_SUPERSCRIPTS)}"


def number(value: float | None, decimals: int = 3) -> str:
    """Print a number with digits after the point, thousands apart and a true minus; — where there is none."""
    if value is None or not math.isfinite(value):
        return DASH
    rounded = round(value, decimals)
    if abs(rounded) >= 1e12:
        return _power_of_ten(value, 4)
    shown = f"{abs(rounded):,.{max(decimals, 0)}f}"
    head, _, tail = shown.partition(".")
    if len(head) <= 5:  # 1632 needs no gap, 16 320 does
        head = head.replace(",", "")
    text = head.replace(",", NARROW) + (f".{tail}" if tail else "")
    return MINUS + text if rounded < 0 else text


def significant(value: float | None, figures: int = 3) -> str:
    """Print a number with so many significant figures; plain digits for usual sizes."""
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    if value == round(value) and abs(value) < 1e12:
        return number(value, 0)
    size = math.floor(math.log10(float(f"{value:.{figures - 1}e}".lstrip("-"))))
    if -5 <= size < 12:
        return number(value, figures - 1 - size if size < figures else 0)
    return _power_of_ten(value, figures)


def with_unit(text: str, unit: str) -> str:
    """Put a unit behind a printed number, where both are there."""
    if text == DASH or unit in ("", EN_DASH, "-", "1"):
        return text
    return f"{text}{NARROW}{unit}" if unit != "%" else f"{text}{NARROW}%"


def percent(share: float | None) -> str:
    """Print a share of 1 as percent."""
    if share is None or not math.isfinite(share):
        return DASH
    return with_unit(number(100 * share, 0 if share >= 0.0995 or share == 0 else 1), "%")


def span(low: float | None, high: float | None, decimals: int) -> str:
    """Print an interval; "to" where a minus would meet the dash."""
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return DASH
    between = " to " if low < 0 or high < 0 else EN_DASH
    return f"{number(low, decimals)}{between}{number(high, decimals)}"


def seconds(value: float | None) -> str:
    """Print a duration: 0.25 s, 41.3 s, 12 min 05 s, 1 h 02 min."""
    if value is None or not math.isfinite(value):
        return DASH
    if abs(value) < 119.95:
        return with_unit(number(value, 2 if abs(value) < 10 else 1), "s")
    minutes, rest = divmod(round(value), 60)
    if minutes < 60:
        return f"{minutes}{NARROW}min {rest:02d}{NARROW}s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours}{NARROW}h {minutes:02d}{NARROW}min"


def count(value: int, one: str, many: str | None = None) -> str:
    """Print "1 gap", "12 gaps"."""
    return f"{number(float(value), 0)} {one if value == 1 else many or one + 's'}"
