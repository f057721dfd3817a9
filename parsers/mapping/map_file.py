"""The user's mapping file (TOML): read strictly, so that a slip of the pen is an error and never a silent no.

[time]                     # CSV only
channel = "t"
unit = "s"                 # s, min, ms, us, ns, iso8601 or hhmmss

[buses]                    # CAN only: of which buses of the log a database is, where several define one identifier
"susp.dbc" = 2             # or a list

[wheels]                   # the radius that the wheels roll on: wheel speeds in rad/s or rpm are taken with it
radius_m = 0.31            # or radius_front_m and radius_rear_m

[signals.accel_y]          # a canonical signal without its unit
channel = "AY"
unit = "g"                 # of the channel; the log's own unit, else SI, where it is left out
scale, offset              # value = channel * scale + offset, in `unit`
invert = true
sign_channel = "AY_sign"   # not zero: the value is negative
valid_range = [-5, 5]      # in `unit`
add = ["AY_fraction"]      # channels that are added to the main one
where = ["Axle", 0, 15]    # only rows where this channel lies between the two numbers
sum_axles = true           # of those rows, the sum over the axles (16 numbers of that channel each), each with its latest value

[signals.pitch]
ignore = true              # do not map this signal at all
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from parsers.errors import MappingError
from parsers.finite import is_number
from parsers.mapping.wheel_radius import RADII_M, WheelRadius, turn_rate
from parsers.signals import COLUMNS, SIGNALS
from parsers.small_text import read_small_text
from parsers.units import Unit, find_unit, require_unit

TIME_UNITS = ("s", "min", "ms", "us", "ns", "iso8601", "hhmmss")
_TABLES = ("time", "buses", "wheels", "signals")
MOST_BUS = 32_767
_TIME_KEYS = ("channel", "unit")
_WHEEL_KEYS = ("radius_m", "radius_front_m", "radius_rear_m")
_SIGNAL_KEYS = (
    "channel",
    "unit",
    "scale",
    "offset",
    "invert",
    "sign_channel",
    "valid_range",
    "add",
    "where",
    "sum_axles",
    "ignore",
)


@dataclass(frozen=True)
class MapEntry:
    """One [signals.NAME] table. unit: None where the file leaves it to the log."""

    signal: str
    channel: str
    unit: Unit | None = None
    scale: float = 1.0
    offset: float = 0.0
    invert: bool = False
    sign_channel: str | None = None
    valid_range: tuple[float, float] | None = None
    add: tuple[str, ...] = ()
    where: tuple[str, float, float] | None = None
    sum_axles: bool = False
    ignore: bool = False

    @property
    def needed(self) -> tuple[str, ...]:
        """All channels that the entry names."""
        names = [self.channel, *self.add, self.sign_channel or "", self.where[0] if self.where else ""]
        return tuple(name for name in names if name)


@dataclass(frozen=True)
class MapFile:
    """A mapping file. strict: a channel that the log lacks is an error (False for a file that was found, not
    given: then the entry is passed over and `missing_channels` says so). buses: of a CAN database, by its file's name. radius: of the
    wheels, where [wheels] tells it."""

    path: Path
    signals: Mapping[str, MapEntry]
    time_channel: str | None = None
    time_unit: str | None = None
    strict: bool = True
    buses: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    radius: WheelRadius | None = None


def read_map(path: Path, *, strict: bool = True) -> MapFile:
    """Read a mapping file. Raises MappingError with the table, what was found and the nearest right name."""
    try:
        text = read_small_text(path)
    except OSError as error:
        raise MappingError(f"cannot be opened ({error.strerror})", path=path) from error
    except UnicodeDecodeError as error:
        hint = "save the file as UTF-8"
        raise MappingError("is not UTF-8 text", path=path, place=f"byte {error.start}", hint=hint) from None
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise MappingError(f"is not valid TOML: {error}", path=path) from None
    check_keys(data, _TABLES, path, None)
    time = _table(data.get("time", {}), path, "[time]")
    channel, unit = _read_time(time, path)
    tables = _table(data.get("signals", {}), path, "[signals]")
    entries = {name: _read_signal(name, table, path) for name, table in tables.items()}
    buses = _table(data.get("buses", {}), path, "[buses]")
    radius = _read_radius(data.get("wheels", {}), path)
    return MapFile(
        path, entries, channel, unit, strict, {name: _read_buses(name, buses, path) for name in buses}, radius
    )


def nearest(name: str, right: Iterable[str]) -> str | None:
    """ "did you mean …?", or None where nothing is near."""
    names = list(right)
    folded = {each.casefold(): each for each in names}
    close = difflib.get_close_matches(name.casefold(), list(folded), n=3, cutoff=0.6)
    return f"did you mean {' or '.join(repr(folded[each]) for each in close)}?" if close else None


def check_keys(table: Mapping[str, Any], known: tuple[str, ...], path: Path, place: str | None) -> None:
    """Raise MappingError for the first key that is not known, naming the nearest right one."""
    for key in table:
        if key not in known:
            hint = nearest(key, known) or f"known are {', '.join(known)}"
            raise MappingError(f"unknown key {key!r}", path=path, place=place, hint=hint)


def _table(value: object, path: Path, place: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise MappingError(f"must be a table, found {value!r}", path=path, place=place)
    return cast("Mapping[str, Any]", value)


def _is_step(unit: str) -> bool:
    """Whether a unit is the step of a column that counts rows: "10 ms"."""
    return unit[:1].isdigit() and find_unit(unit, "time") is not None


def _read_time(table: Mapping[str, Any], path: Path) -> tuple[str | None, str | None]:
    check_keys(table, _TIME_KEYS, path, "[time]")
    reader = _Values(table, path, "[time]")
    channel, unit = reader.text("channel"), reader.text("unit")
    if unit is not None and unit not in TIME_UNITS and not _is_step(unit):
        hint = f'use one of {", ".join(TIME_UNITS)}, or the step of a column that counts rows: "10 ms"'
        raise MappingError(f"unknown time unit {unit!r}", path=path, place="[time]", hint=hint)
    return channel, unit


def _read_buses(name: str, table: Mapping[str, Any], path: Path) -> tuple[int, ...]:
    value = table[name]
    numbers = value if isinstance(value, list) else [value]
    if not numbers or not all(type(each) is int and 0 <= each <= MOST_BUS for each in numbers):
        raise MappingError(
            f"{name!r} must be a bus's number or a list of them, found {value!r}",
            path=path,
            place="[buses]",
            hint="`cogest inspect` names the buses of channels: @bus2 is bus 2",
        )
    return tuple(numbers)


def _read_radius(value: object, path: Path) -> WheelRadius | None:
    """[wheels]: one radius for all wheels, or one for each axle."""
    table = _table(value, path, "[wheels]")
    check_keys(table, _WHEEL_KEYS, path, "[wheels]")
    if not table:
        return None
    reader = _Values(table, path, "[wheels]")
    both = reader.number("radius_m", 0.0)
    front, rear = reader.number("radius_front_m", both), reader.number("radius_rear_m", both)
    for radius in (front, rear):
        if not RADII_M[0] <= radius <= RADII_M[1]:
            hint = "radius_m, or radius_front_m and radius_rear_m, in metres"
            raise MappingError(
                f"no wheel has a radius of {radius:g} m", path=path, place="[wheels]", hint=hint
            )
    return WheelRadius(front, rear, path.name)


def _read_signal(name: str, value: object, path: Path) -> MapEntry:
    place = f"[signals.{name}]"
    if name not in SIGNALS:
        if name in COLUMNS:
            hint: str | None = f"leave the unit away: {COLUMNS[name].name!r}"
        else:
            hint = nearest(name, SIGNALS) or "`cogest inspect --write-map` writes a file with the right names"
        raise MappingError(f"unknown signal {name!r}", path=path, place=place, hint=hint)
    table = _table(value, path, place)
    check_keys(table, _SIGNAL_KEYS, path, place)
    reader = _Values(table, path, place)
    ignore = reader.flag("ignore")
    channel = reader.text("channel")
    if not channel and not ignore:
        hint = 'say which channel it is: channel = "…" (or ignore = true)'
        raise MappingError("the key 'channel' is missing", path=path, place=place, hint=hint)
    if channel and ignore:
        hint = "remove one of the two keys"
        raise MappingError(
            f"'ignore = true' leaves the signal out, and 'channel' maps it to {channel!r}",
            path=path,
            place=place,
            hint=hint,
        )
    text = reader.text("unit")
    unit = None if text is None else _unit(text, name, path, place)
    span = reader.numbers("valid_range", 2)
    if span and not span[0] < span[1]:
        raise MappingError(f"valid_range {list(span)} must be [low, high]", path=path, place=place)
    add, sign, where, summed = (
        reader.texts("add"),
        reader.text("sign_channel"),
        reader.where("where"),
        reader.flag("sum_axles"),
    )
    if summed and (where is None or add or sign):
        problem = "sum_axles needs where, and neither add nor sign_channel"
        hint = 'where = ["channel that tells the axle", low, high]'
        raise MappingError(problem, path=path, place=place, hint=hint)
    return MapEntry(
        signal=name,
        channel=channel or "",
        unit=unit,
        scale=reader.number("scale", 1.0),
        offset=reader.number("offset", 0.0),
        invert=reader.flag("invert"),
        sign_channel=sign,
        valid_range=None if span is None else (span[0], span[1]),
        add=add,
        where=where,
        sum_axles=summed,
        ignore=ignore,
    )


def _unit(text: str, signal: str, path: Path, place: str) -> Unit:
    turning = turn_rate(text, signal)
    if turning is not None:
        return turning
    try:
        return require_unit(text, SIGNALS[signal].quantity, place=place)
    except MappingError as error:
        raise MappingError(error.problem, path=path, place=place, hint=error.hint) from None


@dataclass(frozen=True)
class _Values:
    """Typed reading of one table's values."""

    table: Mapping[str, Any]
    path: Path
    place: str

    def _wrong(self, key: str, expected: str) -> MappingError:
        found = self.table[key]
        return MappingError(f"{key} must be {expected}, found {found!r}", path=self.path, place=self.place)

    def text(self, key: str) -> str | None:
        value = self.table.get(key)
        if value is None:
            return None
        if not isinstance(value, str) or not value.strip():
            raise self._wrong(key, "a text")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        value = self.table.get(key, [])
        items = [value] if isinstance(value, str) else value
        if not isinstance(items, list) or not all(isinstance(item, str) and item for item in items):
            raise self._wrong(key, "a channel or a list of channels")
        return tuple(items)

    def flag(self, key: str) -> bool:
        value = self.table.get(key, False)
        if not isinstance(value, bool):
            raise self._wrong(key, "true or false")
        return value

    def number(self, key: str, default: float) -> float:
        value = self.table.get(key, default)
        if not is_number(value):
            raise self._wrong(key, "a finite number")
        if key == "scale" and value == 0:
            raise self._wrong(key, "a number other than 0")
        return float(value)

    def numbers(self, key: str, count: int) -> tuple[float, ...] | None:
        value = self.table.get(key)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != count or not all(is_number(each) for each in value):
            raise self._wrong(key, f"a list of {count} numbers")
        return tuple(float(each) for each in value)

    def where(self, key: str) -> tuple[str, float, float] | None:
        value = self.table.get(key)
        if value is None:
            return None
        good = isinstance(value, list) and len(value) == 3 and isinstance(value[0], str)
        if not good or not all(is_number(each) for each in value[1:]):
            raise self._wrong(key, '["channel", low, high]')
        return (value[0], float(value[1]), float(value[2]))
