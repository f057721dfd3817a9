"""Names of months, time zones and the signs of Chinese and Japanese dates, as kernels find them in a text."""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from parsers.table_bytes import byte_at

MONTHS = (
    ("jan",), ("feb", "fev"), ("mar",), ("apr", "avr"), ("may", "mai"), ("jun", "juin"), ("jul", "juil"),
    ("aug", "aou"), ("sep",), ("oct", "okt"), ("nov",), ("dec", "dez"),
)  # fmt: skip
"""What the months' names begin with, in English, German and French, without accents."""
MONTH_WORD = r"(?:jan|f[eé][bv]|m[aä]r|apr|avr|ma[iy]|jun|juin|jul|juil|aug|ao[uû]|sep|o[ck]t|nov|d[eé][cz])[^\W\d_]*\.?"
"""A month's name as a pattern, for any case."""

ZONES = {
    "Z": 0, "UTC": 0, "GMT": 0, "WET": 0, "WEST": 60, "CET": 60, "CEST": 120, "MEZ": 60, "MESZ": 120, "EET": 120,
    "EEST": 180, "MSK": 180, "JST": 540, "KST": 540, "EST": -300, "EDT": -240, "CDT": -300, "MDT": -360, "PST": -480,
    "PDT": -420, "AEST": 600, "AEDT": 660, "NZST": 720, "NZDT": 780,
}  # fmt: skip
"""Minutes east of Greenwich of the zones whose names mean one thing; CST, IST, BST and MST mean several."""
_LONGEST_ZONE = 5

SIGNS = ("年", "月", "日", "時时", "分", "秒")
"""Behind year, month, day, hour, minute and second, in Japanese and Chinese."""


def _number(text: bytes) -> int:
    return int.from_bytes(text, "big")


_MONTH_KEYS = np.array(
    [
        (_number(name[:3].encode()), ord(name[3]) if len(name) > 3 else 0, k + 1)
        for k, names in enumerate(MONTHS)
        for name in names
    ]
)
_ZONE_KEYS = np.array([(_number(name.lower().encode()), minutes) for name, minutes in ZONES.items()])
_SIGN_KEYS = np.array(
    sorted(
        {
            (len(code), _number(code), k + 1)
            for k, signs in enumerate(SIGNS)
            for sign in signs
            for codec in ("utf-8", "shift_jis")
            if (code := sign.encode(codec, "ignore"))
        },
        reverse=True,
    )
)


@kernel
def _letter(at: int, stop: int) -> tuple[int, int]:
    """A small letter without its accent, in UTF-8 or cp1252, and where it ends (`at`: there is none)."""
    if at >= stop:
        return 0, at
    c = byte_at(at)
    if 97 <= c | 32 <= 122:
        return c | 32, at + 1
    end = at + 1
    code = c | 32
    if c == 0xC3 and at + 1 < stop:
        end = at + 2
        code = (byte_at(at + 1) | 32) + 0x40
    if code == 0xE4:
        return 97, end
    if code == 0xE9:
        return 101, end
    if code == 0xFB:
        return 117, end
    return 0, at


@kernel
def word_at_letters(start: int, stop: int) -> int:
    """Where a word of letters ends."""
    i = start
    _, end = _letter(i, stop)
    while end > i:
        i = end
        _, end = _letter(i, stop)
    return i


@kernel
def month_at(start: int, stop: int) -> tuple[int, int]:
    """The month whose name begins at `start`, and where the name ends (0 and `start`: none)."""
    first, i = _letter(start, stop)
    second, i = _letter(i, stop)
    third, i = _letter(i, stop)
    fourth, _ = _letter(i, stop)
    key = first << 16 | second << 8 | third
    for k in range(_MONTH_KEYS.shape[0]):
        if _MONTH_KEYS[k, 0] == key and (_MONTH_KEYS[k, 1] == 0 or _MONTH_KEYS[k, 1] == fourth):
            return int(_MONTH_KEYS[k, 2]), word_at_letters(start, stop)
    return 0, start


@kernel
def zone_named(start: int, stop: int) -> tuple[int, int]:
    """Minutes east of Greenwich of a zone's name, and where it ends (`start`: none); 0 of one that nobody knows."""
    i = start
    key = 0
    while i < stop and i - start < _LONGEST_ZONE and 97 <= byte_at(i) | 32 <= 122:
        key = key << 8 | byte_at(i) | 32
        i += 1
    for k in range(_ZONE_KEYS.shape[0]):
        if _ZONE_KEYS[k, 0] == key:
            return int(_ZONE_KEYS[k, 1]), i
    return 0, i if i - start >= 3 else start


@kernel
def sign_at(start: int, stop: int) -> tuple[int, int]:
    """Which sign of a date or time stands at `start` (1 to 6, year to second), and where it ends (0 and `start`: none)."""
    for k in range(_SIGN_KEYS.shape[0]):
        size = int(_SIGN_KEYS[k, 0])
        if start + size > stop:
            continue
        key = 0
        for i in range(size):
            key = key << 8 | byte_at(start + i)
        if _SIGN_KEYS[k, 1] == key:
            return int(_SIGN_KEYS[k, 2]), start + size
    return 0, start
