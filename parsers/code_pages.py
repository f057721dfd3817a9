"""Which code page a text has that is no UTF-8: Windows' western one, or one of Japan, China or the Cyrillic script."""

from __future__ import annotations

import re

NATIONAL = ("cp932", "gb18030", "cp1251")
"""Python's names of Shift-JIS, of China's, and of the Cyrillic one. A comma, a tab or a quote is never part of their letters."""

_HIGH = re.compile(rb"[\x80-\xff]")
_SHIFT_JIS = re.compile(rb"[\x81-\x9f\xe0-\xfc][\x40-\x7e\x80-\xfc]")
_PAIRS = re.compile(rb"[\xb0-\xf7][\xa1-\xfe]")
_CYRILLIC = re.compile(rb"[\xc0-\xff\xa8\xb8]{3,}")
_LEAST = 0.6
"""Least share of the bytes beyond ASCII that tell a code page. In western texts they stand among plain letters, one by one."""


def code_page(head: bytes) -> str:
    """The code page of a text by its first bytes: cp1252 where nothing tells another."""
    high = len(_HIGH.findall(head))
    if high < 4:
        return "cp1252"
    double = _SHIFT_JIS.findall(head)
    # signs of punctuation in cp1252, of which no word is made
    japanese = [pair for pair in double if pair[0] <= 0x9F]
    if 2 * len(japanese) >= _LEAST * high and _decodes(head, "cp932"):
        return "cp932"
    runs = b"".join(run for run in re.findall(rb"[\x80-\xff]{4,}", head))
    if len(runs) < _LEAST * high:
        return "cp1252"
    if sum(map(len, _CYRILLIC.findall(head))) >= _LEAST * high and _small(runs) >= _LEAST:
        return "cp1251"
    if 2 * len(_PAIRS.findall(runs)) >= _LEAST * high and _decodes(head, "gb18030"):
        return "gb18030"
    return "cp1252"


def _small(runs: bytes) -> float:
    """Share of small Cyrillic letters."""
    return sum(byte >= 0xE0 for byte in runs) / len(runs)


def _decodes(head: bytes, codec: str) -> bool:
    """Whether bytes are text of a code page, but for a letter that the end cuts through."""
    for cut in range(4):
        try:
            head[: len(head) - cut].decode(codec)
        except UnicodeDecodeError:
            continue
        return True
    return False
