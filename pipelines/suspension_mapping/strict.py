"""Read a TOML table that nobody vouches for: every key known, every number finite and in its range, errors that help."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from pathlib import Path

from parsers.errors import VehicleError
from parsers.finite import is_number

LONGEST_TEXT = 500


class StrictTable:
    """One table of a file; each key is asked for once, `finish` refuses what nobody asked for."""

    def __init__(self, raw: object, path: Path, place: str) -> None:
        """raw: what TOML gave. place: as errors name it ("[struts.fl]"). Raises VehicleError where it is no table."""
        if not isinstance(raw, Mapping):
            raise VehicleError(f"found {_short(raw)}, expected a table", path=path, place=place)
        self._raw: Mapping[str, object] = raw
        self._path = path
        self.place = place
        self._asked: set[str] = set()

    def error(self, problem: str, key: str | None = None, hint: str | None = None) -> VehicleError:
        """An error at this table, or at one of its keys."""
        place = self.place if key is None else f"{self.place} {key}"
        return VehicleError(problem, path=self._path, place=place, hint=hint)

    @property
    def names(self) -> tuple[str, ...]:
        """What the table holds."""
        return tuple(self._raw)

    def has(self, key: str) -> bool:
        """Whether the key is there; it counts as known."""
        self._asked.add(key)
        return key in self._raw

    def value(self, key: str) -> object:
        """The raw value of a key that must be there."""
        if not self.has(key):
            near = difflib.get_close_matches(
                key, [k for k in self._raw if k not in self._asked], n=1, cutoff=0.7
            )
            hint = f"is {near[0]!r} meant to be it?" if near else "train the map anew: cogest suspension-map"
            raise self.error(f"{key!r} is missing", hint=hint)
        return self._raw[key]

    def number(self, key: str, low: float = -1e12, high: float = 1e12) -> float:
        """A finite number from low to high."""
        return self.as_number(self.value(key), key, low, high)

    def as_number(self, value: object, key: str, low: float = -1e12, high: float = 1e12) -> float:
        """The same of a value that was taken out of a list."""
        if not is_number(value):
            raise self.error(f"found {_short(value)}, expected a finite number", key)
        if not low <= value <= high:
            raise self.error(f"found {value:g}, expected {low:g} to {high:g}", key)
        return float(value)

    def text(self, key: str) -> str:
        """A text of bearable length."""
        value = self.value(key)
        if not isinstance(value, str) or len(value) > LONGEST_TEXT:
            raise self.error(f"found {_short(value)}, expected a text", key)
        return value

    def one_of(self, key: str, known: Iterable[str]) -> str:
        """A text out of a few."""
        value, names = self.text(key), tuple(known)
        if value not in names:
            raise self.error(f"found {value[:40]!r}", key, _nearest(value, names))
        return value

    def rows(self, key: str, most: int) -> list[object]:
        """A list of at most `most` entries."""
        value = self.value(key)
        if not isinstance(value, list) or len(value) > most:
            raise self.error(f"found {_short(value)}, expected a list of at most {most}", key)
        return value

    def table(self, key: str) -> StrictTable:
        """A table below this one."""
        inner = self.place.strip("[]")
        name = f"[{inner}.{key}]" if inner else f"[{key}]"
        return StrictTable(self.value(key), self._path, name)

    def finish(self) -> None:
        """Raise VehicleError for a key that is not known, with the nearest that is."""
        for key in self._raw:
            if key not in self._asked:
                raise self.error(f"unknown key {key[:60]!r}", hint=_nearest(key, sorted(self._asked)))


def _nearest(word: str, known: Iterable[str]) -> str:
    names = tuple(known)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names)}"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}…"
