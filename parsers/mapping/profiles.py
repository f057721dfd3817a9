"""Built-in mapping profiles: one TOML file a family or make in `parsers/profiles`. A new profile is one new file.

title = "Toyota (public DBCs)"
families = ["can", "mdf", "table"]    # which ChannelInfo.family the rules look at
rank = 10                             # of all its rules; lower wins over other profiles
words = { camera = "(realsense|zed)" }        # "{camera}" in any pattern below stands for this

[[rules]]
signal = "yaw_rate"                   # canonical name; "{w}" is each wheel of `wheels`
match = { message = "KINEMATICS", signal = "YAW_RATE" }
    # tag -> pattern; a regular expression that must fit the whole tag, upper and lower case alike. Tags as in
    # ChannelInfo.tags, and "name". A name "A.B" without tags counts as message "A", signal "B" too, so that
    # CSV and MF4 exports of decoded CAN are known. "{wheel}" is the wheel's word of `wheels`.
wheels = { fl = "FL", fr = "FR", rl = "RL", rr = "RR" }
unit = "deg/s"                        # where the log is silent; the log's own unit wins
require_unit = true                   # instead: no guess, the log must say the unit
scale, offset, invert, valid_range    # as in a mapping file
rank = 2                              # added to the profile's rank
rank_worse = { topic = ".*camera.*" } # tag -> pattern: such channels rank 4 lower
kind = "roll_of_quaternion"           # needs `add` with the y, z and w channels; "length": of the vector with those of `add`
add = [{ signal = "STEER_FRACTION", optional = true }]
sign = { signal = "ESP_VZ_Gierrate" }         # not zero: negative
where = { signal = "Axle", low = 0, high = 15, optional = true }
sum_axles = true                      # of the rows that `where` picks, the sum over axles: as in a mapping file
    # add, sign, where name siblings: channels of the same group, by pattern. Without a sibling that is not
    # optional the rule gives nothing.

[[unusable]]
match = { type = "dbw_mkz_msgs/WheelSpeedReport" }
reason = "…"                          # what `inspect` says of such a channel
even_with_unit = true                 # its name says nothing either where the log states a unit: a command
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, cast

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.mapping.bindings import BindingKind
from parsers.mapping.wheel_radius import turn_rate
from parsers.signals import SIGNALS
from parsers.table_names import split_header
from parsers.units import find_unit


@dataclass(frozen=True)
class Word:
    """A pattern that is but a word: most are, and to compile them all takes longer than to read a short log."""

    pattern: str
    lowered: str

    def fullmatch(self, text: str) -> bool:
        """Whether a text is the word, upper and lower case alike."""
        return text.lower() == self.lowered


Expression = re.Pattern[str] | Word
Pattern = tuple[tuple[str, Expression], ...]
_WORD = re.compile(r"[A-Za-z0-9_ ]+")
_RULE_KEYS = {
    "signal", "match", "wheels", "unit", "require_unit", "scale", "offset", "invert", "valid_range",
    "rank", "rank_worse", "kind", "add", "sign", "where", "sum_axles",
}  # fmt: skip
_FILE_KEYS = {"title", "families", "rank", "words", "rules", "unusable"}


@dataclass(frozen=True)
class Sibling:
    """Another channel of the same group."""

    pattern: Pattern
    optional: bool = False
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Rule:
    """One [[rules]] table, for one signal (wheels are spelt out)."""

    signal: str
    pattern: Pattern
    unit: str | None
    require_unit: bool
    scale: float
    offset: float
    invert: bool
    valid_range: tuple[float, float] | None
    rank: int
    worse: Pattern
    kind: BindingKind
    add: tuple[Sibling, ...]
    sign: Sibling | None
    where: Sibling | None
    sum_axles: bool


@dataclass(frozen=True)
class Unusable:
    """One [[unusable]] table: channels that are no signal, whatever their names look like."""

    pattern: Pattern
    reason: str
    even_with_unit: bool = False


@dataclass(frozen=True)
class Profile:
    """One file. name: the file's name without suffix."""

    name: str
    title: str
    families: frozenset[str]
    rules: tuple[Rule, ...]
    unusable: tuple[Unusable, ...]


def tags_of(channel: ChannelInfo) -> Mapping[str, str]:
    """What rules match on: the channel's tags, its name, and message and signal where the name holds both.

    A column's header is looked at without the unit behind it ("AVz (deg/s)").
    """
    tags = {"name": channel.name, "column": channel.name, "group": channel.group, **channel.tags}
    if channel.family in ("table", "mdf"):
        tags["column"] = split_header(tags["column"]).name
    if channel.family in ("table", "mdf") and "signal" not in tags and "." in channel.name:
        message, _, signal = channel.name.rpartition(".")
        tags |= {"message": message.rpartition(".")[2], "signal": signal}
    return tags


def fits(pattern: Pattern, tags: Mapping[str, str]) -> bool:
    """Whether every tag of a pattern fits."""
    return all(tag in tags and expression.fullmatch(tags[tag]) for tag, expression in pattern)


def unusable_reason(channel: ChannelInfo, tags: Mapping[str, str]) -> str | None:
    """Why a profile says that a channel is no signal, or None where none says it. tags: those of `tags_of`."""
    found = _unusable(channel, tags)
    return None if found is None else found.reason


def may_be_named(channel: ChannelInfo, tags: Mapping[str, str]) -> bool:
    """Whether a channel's name may tell its signal.

    What a profile knows to be something else is not guessed by its name, unless the log states a unit; and what it
    knows to be no measurement at all, not even then.
    """
    found = _unusable(channel, tags)
    return found is None or (bool(channel.unit) and not found.even_with_unit)


def _unusable(channel: ChannelInfo, tags: Mapping[str, str]) -> Unusable | None:
    return next(
        (
            each
            for profile in load_profiles()
            if channel.family in profile.families
            for each in profile.unusable
            if fits(each.pattern, tags)
        ),
        None,
    )


@cache
def load_profiles() -> tuple[Profile, ...]:
    """All built-in profiles, by name. Raises MappingError where one is wrong (a fault of the installation)."""
    folder = files("parsers.profiles")
    texts = {
        item.name.removesuffix(".toml"): item.read_text(encoding="utf-8")
        for item in folder.iterdir()
        if item.name.endswith(".toml") and item.name != "names.toml"
    }
    return tuple(parse_profile(name, texts[name]) for name in sorted(texts))


def parse_profile(name: str, text: str) -> Profile:
    """Read one profile. Raises MappingError that names the profile and the rule."""
    place = f"profile {name}"
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MappingError(f"is not valid TOML: {error}", place=place) from None
    unknown = set(data) - _FILE_KEYS
    if unknown:
        raise MappingError(f"unknown key {min(unknown)!r}", place=place)
    data = _spelt_out(data, data.get("words", {}))
    rules: list[Rule] = []
    for number, table in enumerate(data.get("rules", []), start=1):
        rules += _parse_rule(table, int(data.get("rank", 10)), f"{place}, rule {number}")
    unusable = tuple(
        Unusable(
            _pattern(table["match"], place), str(table["reason"]), bool(table.get("even_with_unit", False))
        )
        for table in data.get("unusable", [])
    )
    families = frozenset(data.get("families", []))
    return Profile(name, str(data.get("title", name)), families, tuple(rules), unusable)


def _spelt_out(node: Any, words: Mapping[str, str]) -> Any:
    """What a file holds, with the words in braces that it explains in place of them."""
    if isinstance(node, dict):
        return {key: _spelt_out(each, words) for key, each in node.items()}
    if isinstance(node, list):
        return [_spelt_out(each, words) for each in node]
    if isinstance(node, str):
        for word, meaning in words.items():
            node = node.replace(f"{{{word}}}", meaning)
    return node


def _parse_rule(table: Mapping[str, Any], rank: int, place: str) -> list[Rule]:
    unknown = set(table) - _RULE_KEYS
    if unknown or not {"signal", "match"} <= set(table):
        problem = f"unknown key {min(unknown)!r}" if unknown else "signal and match are needed"
        raise MappingError(problem, place=place)
    wheels: Mapping[str, str] = table.get("wheels", {"": ""})
    return [_one_rule(table, rank, place, wheel, word) for wheel, word in wheels.items()]


def _one_rule(table: Mapping[str, Any], rank: int, place: str, wheel: str, word: str) -> Rule:
    def siblings(key: str) -> tuple[Sibling, ...]:
        value = table.get(key, [])
        return tuple(_sibling(item, place, word) for item in (value if isinstance(value, list) else [value]))

    signal = str(table["signal"]).replace("{w}", wheel)
    if signal not in SIGNALS:
        raise MappingError(f"unknown signal {signal!r}", place=place)
    unit = table.get("unit")
    known = find_unit(unit, SIGNALS[signal].quantity) or turn_rate(unit, signal)
    if unit is not None and known is None:
        raise MappingError(f"unit {unit!r} is no unit of {signal}", place=place)
    span: Sequence[float] | None = table.get("valid_range")
    return Rule(
        signal=signal,
        pattern=_pattern(table["match"], place, word),
        unit=unit,
        require_unit=bool(table.get("require_unit", False)),
        scale=float(table.get("scale", 1.0)),
        offset=float(table.get("offset", 0.0)),
        invert=bool(table.get("invert", False)),
        valid_range=None if span is None else (float(span[0]), float(span[1])),
        rank=rank + int(table.get("rank", 0)),
        worse=_pattern(table.get("rank_worse", {}), place),
        kind=cast("BindingKind", table.get("kind", "scale")),
        add=siblings("add"),
        sign=next(iter(siblings("sign")), None),
        where=next(iter(siblings("where")), None),
        sum_axles=bool(table.get("sum_axles", False)),
    )


def _sibling(table: Mapping[str, Any], place: str, word: str) -> Sibling:
    rest = {key: value for key, value in table.items() if key not in ("optional", "low", "high")}
    low, high = float(table.get("low", 0.0)), float(table.get("high", 0.0))
    return Sibling(_pattern(rest, place, word), bool(table.get("optional", False)), low, high)


def _expression(text: str) -> Expression:
    return Word(text, text.lower()) if _WORD.fullmatch(text) else re.compile(text, re.IGNORECASE)


def _pattern(table: Mapping[str, str], place: str, word: str = "") -> Pattern:
    try:
        return tuple((tag, _expression(text.replace("{wheel}", word))) for tag, text in table.items())
    except (re.error, AttributeError):
        raise MappingError(f"{dict(table)} is no table of patterns", place=place) from None
