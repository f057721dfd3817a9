"""The table of words and names in `parsers/profiles/names.toml`, and how a name is cut into its words."""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from parsers.signals import WHEELS

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})

_JAPANESE = re.compile(r"[\u3040-\u30ff\u3400-\u9fff]+")
_UNKNOWN = "untranslated"
_DIMENSIONS = re.compile(r"(?<![A-Za-z0-9])([23])D(?![A-Za-z0-9])")
"""Of a "GPS (2D)": one word, and no second one called D."""

_PARTICLES = re.compile(r"(?<=[A-Za-z])[ _](?:di|del|della|dei|delle|du|au)(?=[ _][A-Za-z])", re.IGNORECASE)
"""Between two words of a name: "Velocità di imbardata". No "des": that is what somebody desires ("v_des_x")."""


@dataclass(frozen=True)
class NameTable:
    """The table: spelling -> word, and word sets -> signal with its place in the list."""

    words: Mapping[str, str]
    japanese: Mapping[str, str]
    noise: frozenset[str]
    worse: frozenset[str]
    sets: Mapping[tuple[str, ...], tuple[str, int]]
    directions: Mapping[tuple[str, ...], str]
    weak: frozenset[tuple[str, ...]]
    unit_free: frozenset[tuple[str, ...]]
    abbreviated: frozenset[str]
    blocked: frozenset[str]
    blocked_fields: frozenset[str]
    contexts: frozenset[str]
    references: frozenset[str]
    measured: frozenset[str]
    commands: frozenset[str]
    blocked_endings: frozenset[str]
    ambiguous: Mapping[tuple[str, ...], str]


@cache
def load_names() -> NameTable:
    """The built-in table."""
    text = files("parsers.profiles").joinpath("names.toml").read_text(encoding="utf-8")
    data: dict[str, Any] = tomllib.loads(text)
    blocked = {key: frozenset(text.split()) for key, text in data["blocked"].items()}
    words = {spelling: word for word, spellings in data["words"].items() for spelling in spellings.split()}
    sets: dict[tuple[str, ...], tuple[str, int]] = {}
    for signal, rows in data["names"].items():
        for place, row in enumerate(rows):
            for key, name in zip(_wheel_keys(row), _wheel_names(signal, row), strict=True):
                sets.setdefault(key, (name, place))
    return NameTable(
        words=words,
        japanese={each: word for word, row in data["japanese"].items() for each in row.split()},
        noise=frozenset(data["noise"]["words"].split()),
        worse=frozenset(data["noise"]["worse"].split()),
        sets=sets,
        directions={_key(row): name for name, rows in data["directions"].items() for row in rows},
        weak=_spread(data["weak"]["sets"]),
        unit_free=_spread(data["weak"]["without_unit"]),
        abbreviated=frozenset(data["weak"]["abbreviated"].split()),
        blocked=blocked["words"] | blocked["commands"] | blocked["others"],
        blocked_fields=blocked["fields"],
        contexts=blocked["commands"] | blocked["others"],
        references=blocked["references"],
        measured=blocked["measured"],
        commands=blocked["commands"],
        blocked_endings=blocked["endings"],
        ambiguous={_key(row): reason for row, reason in data["ambiguous"].items()},
    )


def _spread(rows: list[str]) -> frozenset[tuple[str, ...]]:
    return frozenset(key for row in rows for key in _wheel_keys(row))


def _key(row: str) -> tuple[str, ...]:
    return tuple(sorted(row.split()))


def _wheel_keys(row: str) -> list[tuple[str, ...]]:
    return [_key(row.replace("{w}", wheel)) for wheel in WHEELS] if "{w}" in row else [_key(row)]


def _wheel_names(signal: str, row: str) -> list[str]:
    return [signal.replace("{w}", wheel) for wheel in WHEELS] if "{w}" in row else [signal]


def plain_letters(name: str) -> str:
    """A name without accents, umlauts as two letters: "Längs" -> "Laengs", "Accélération" -> "Acceleration"."""
    if name.isascii():
        return name
    apart = unicodedata.normalize("NFKD", unicodedata.normalize("NFC", name).translate(_UMLAUTS))
    return "".join(letter for letter in apart if not unicodedata.combining(letter))


def is_japanese(text: str) -> bool:
    """Whether a text holds kana or Chinese characters."""
    return not text.isascii() and _JAPANESE.search(unicodedata.normalize("NFKC", text)) is not None


def _from_japanese(name: str, table: NameTable) -> str:
    """A name with its Japanese in the table's words; what the table does not know becomes a word that nothing is called."""
    text = unicodedata.normalize("NFKC", name)
    known = _phrases(tuple(table.japanese))
    latin = {piece.lower() for piece in re.findall(r"[A-Za-z]+", text)}

    def put(found: re.Match[str]) -> str:
        words = table.japanese.get(found[0], _UNKNOWN).split()
        # "車速 Speed" says it twice
        return f" {' '.join(word for word in words if word not in latin)} "

    return _JAPANESE.sub(lambda run: f" {_UNKNOWN} ", known.sub(put, text))


@cache
def _phrases(phrases: tuple[str, ...]) -> re.Pattern[str]:
    return re.compile("|".join(map(re.escape, sorted(phrases, key=len, reverse=True))))


def _particles_out(name: str) -> str:
    return _PARTICLES.sub("", _DIMENSIONS.sub(r"\1d", name))


def words_of(name: str, table: NameTable) -> list[str]:
    """A name's words, each in the table's spelling: "LatAcc" -> ["lateral", "accel"]."""
    name = _from_japanese(name, table) if is_japanese(name) else name
    text = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", _particles_out(plain_letters(name)))
    text = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1 \2", text)
    pieces = [piece for piece in re.split(r"[^A-Za-z0-9]+", text) if piece]
    words: list[str] = []
    for piece in pieces:
        words += [table.words.get(part, part) for part in _cut(piece.lower(), table)]
    return _pair_wheels(words)


def _cut(piece: str, table: NameTable) -> list[str]:
    """Cut "accely", "yawrate" or "wheelspeedfl" into known words; a piece that is not made of them stays whole."""
    if piece in table.words or len(piece) < 4 or len(piece) > 40:
        return [piece]
    for at in range(len(piece) - 1, 1, -1):
        head, tail = piece[:at], piece[at:]
        if head in table.words and (tail in table.words or tail in ("x", "y", "z")):
            return [head, tail]
    for tail in (*WHEELS, "lf", "rf", "lr"):
        head = piece.removesuffix(tail)
        if head != piece:
            parts = _cut(head, table)
            if all(part in table.words for part in parts):
                return [*parts, tail]
    return [piece]


def _pair_wheels(words: list[str]) -> list[str]:
    """ "front left" -> fl."""
    for end in ("front", "rear"):
        for side in ("left", "right"):
            if words.count(end) == 1 and words.count(side) == 1:
                rest = [word for word in words if word not in (end, side)]
                return [*rest, end[0] + side[0]]
    return words


def known_words(words: Iterable[str], known: Collection[str]) -> frozenset[str]:
    """Those of `known` that are among a name's words, digits and an "s" behind them or not: "target" of "target1"."""
    bare = {word.rstrip("0123456789") for word in words}
    return frozenset(known) & (bare | {word.removesuffix("s") for word in bare})
