"""What the texts of a database's value table say: which raw values stand for no value."""

from __future__ import annotations

import re
from collections.abc import Mapping

_INVALID = re.compile(
    r"not[\s_-]*avail|unavail|invalid|\bsna\b|_sna\b|\bsna_|\berror|_error|\bfault|_fault|ung(ü|ue)ltig|\bfehler|_fehler"
    r"|(?<![a-z])init(?![a-z])|(?<![a-z])initiali[sz]|not[\s_-]*valid|signal[\s_-]*not"
    r"|(?<![a-z])not[\s_-]*(present|used|defined|installed|fitted|connected|plausible)(?![a-z])"
    r"|(?<![a-z])err(?![a-z])|(?<![a-z])(n/a|n\.\s?a\.?|na)(?![a-z])|(?<![a-z])no[\s_-]*(value|data|signal|info|information)(?![a-z])"
    r"|(?<![a-z])(unknown|unused|unplausib\w*|implausib\w*|undef|undefined|erreur|unbekannt|unterspannung)(?![a-z])"
    r"|(?<![a-z])(fail|failed|failure)(?![a-z])(?![\s_-]*safe)|(?<![a-z])defe[ck]t|(?<![a-z])(over|under)flow(?![a-z])"
    r"|out[\s_-]*of[\s_-]*range|non[\s_-]*disponible|indisponible|nicht[\s_-]*(verf|verbaut|definiert|plausib|belegt)",
    re.IGNORECASE,
)
_WRONG = r"(error|fault|fail(ed|ure)?|fehler|defe[ck]t|erreur|(over|under)flow)"
_VALID = re.compile(
    rf"(\b|_)(no|non|not|kein|keine|without|ohne|sans)[\s_-]*{_WRONG}|{_WRONG}[\s_-]*(free|frei|none|off|inactive)\b",
    re.IGNORECASE,
)
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")


def invalid_codes(choices: Mapping[int, object], length: int) -> tuple[int, ...]:
    """Raw values (modulo 2**length) that a value table calls invalid.

    Only where the table names fewer than half of all values, so that the signal is a quantity with a few special
    codes; in an enumeration "fault" is an answer like any other.
    """
    if not choices or 2 * len(choices) >= 1 << length:
        return ()
    mask = (1 << length) - 1
    codes = {int(raw) & mask for raw, label in choices.items() if is_invalid(str(label))}
    return tuple(sorted(codes))


def is_invalid(label: str) -> bool:
    """Whether a text says that there is no value."""
    apart = _HUMP.sub(" ", label)  # "SensorFailure", "NoFault"
    return bool(_INVALID.search(apart)) and not _VALID.search(apart)
