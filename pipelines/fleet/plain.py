"""Records as JSON and back, strictly by their annotations: what a store holds is not trusted."""

from __future__ import annotations

import json
import math
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from parsers.errors import StoreError

Record = TypeVar("Record")

_UNFINITE = ("nan", "inf", "-inf")


def to_plain(value: Any) -> Any:
    """A record as JSON can hold it. Floats keep every digit; NaN and infinities become text, which `from_plain` knows."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(entry) for entry in value]
    if isinstance(value, str) or value is None or isinstance(value, bool):
        return value
    number = value.item() if hasattr(value, "item") else value
    if isinstance(number, float) and not math.isfinite(number):
        return repr(number)
    if not isinstance(number, bool | int | float):
        raise TypeError(f"a {type(value).__name__} has no form in JSON here")
    return number


def json_bytes(value: Any) -> bytes:
    """Records as one JSON text (ASCII: odd bytes in a file's name survive), the same for the same records."""
    return (
        json.dumps(to_plain(value), ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode()
        + b"\n"
    )


def read_json(content: bytes) -> dict[str, Any]:
    """A JSON text that must hold one table. Raises StoreError."""
    try:
        raw = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise StoreError(f"not whole JSON ({error})") from error
    if not isinstance(raw, dict):
        raise StoreError("not a table of JSON")
    return raw


class _WrongError(Exception):
    """Something is not what it must be: where (from the inside out), and what."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.places: list[str] = []

    def under(self, place: str) -> _WrongError:
        self.places.append(place)
        return self

    @property
    def text(self) -> str:
        where = "".join(reversed(self.places)).lstrip(".")
        return f"{where}: {self}" if where else str(self)


_Reader = Callable[[Any], Any]
"""Reads one value. Raises _WrongError."""


def from_plain(kind: type[Record], raw: Any) -> Record:
    """The record again. Raises StoreError that says where it is not what it must be."""
    try:
        return typing.cast(Record, _reader(typing.cast(Any, kind))(raw))
    except _WrongError as error:
        raise StoreError(error.text) from error
    except RecursionError as error:
        raise StoreError("nested too deep") from error


@cache
def _reader(kind: Any) -> _Reader:
    """What reads values of a kind, as its annotation says: worked out once, as stores hold millions of values."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        given = _reader(next(k for k in inner if k is not type(None)))
        return lambda raw: None if raw is None else given(raw)
    if origin is Literal:
        return lambda raw: _expected(raw, isinstance(raw, str) and raw in inner, " or ".join(map(str, inner)))
    if origin is tuple:
        return _tuple_reader(inner)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _mapping_reader(_reader(inner[1]))
    if isinstance(kind, type) and is_dataclass(kind):
        return _record_reader(kind)
    if kind is float:
        return _float
    if kind in (int, str, bool):
        return lambda raw: _expected(raw, type(raw) is kind, kind.__name__)
    raise TypeError(f"{kind} has no form in JSON here")


def _expected(raw: Any, right: bool, what: str) -> Any:
    if not right:
        raise _WrongError(f"found {str(raw)[:40]!r}, expected {what}")
    return raw


def _float(raw: Any) -> float:
    if type(raw) is float:
        return raw
    if isinstance(raw, str) and raw in _UNFINITE:
        return float(raw)
    _expected(raw, type(raw) is int and abs(raw) < 1e300, "a number")
    return float(raw)


def _record_reader(kind: type) -> _Reader:
    hints = typing.get_type_hints(kind)
    entries = [
        (f.name, _reader(hints[f.name]), f.default is MISSING and f.default_factory is MISSING)
        for f in fields(kind)
    ]

    def read(raw: Any) -> Any:
        _expected(raw, isinstance(raw, dict), "a record")
        given: dict[str, Any] = {}
        for name, reader, needed in entries:
            if name in raw:
                try:
                    given[name] = reader(raw[name])
                except _WrongError as error:
                    raise error.under(f".{name}") from None
            elif needed:
                raise _WrongError("is missing").under(f".{name}")
        return kind(**given)

    return read


def _mapping_reader(entry: _Reader) -> _Reader:
    def read(raw: Any) -> Any:
        _expected(raw, isinstance(raw, dict), "a table")
        found = {}
        for key, value in raw.items():
            try:
                found[key] = entry(value)
            except _WrongError as error:
                raise error.under(f".{key[:60]}") from None
        return found

    return read


def _tuple_reader(inner: tuple[Any, ...]) -> _Reader:
    """Of a list of any length (tuple[X, ...]), or of as many as there are kinds."""
    endless = len(inner) == 2 and inner[1] is Ellipsis
    readers = [_reader(kind) for kind in inner if kind is not Ellipsis]

    def read(raw: Any) -> Any:
        _expected(raw, isinstance(raw, list) and (endless or len(raw) == len(readers)), "a list")
        found = []
        for place, value in enumerate(raw):
            try:
                found.append(readers[0 if endless else place](value))
            except _WrongError as error:
                raise error.under(f"[{place}]") from None
        return tuple(found)

    return read
