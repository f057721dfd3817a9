"""The settings file (TOML): one table an estimator, each key checked against what that estimator has."""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from parsers.errors import SettingsError
from pipelines.estimators.base import Estimator, Settings


def _nearest(word: str, known: Iterable[str]) -> str:
    names = sorted(known)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.4)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names)}"


def choose(names: str | None, known: Sequence[Estimator]) -> tuple[Estimator, ...]:
    """The estimators that `--estimators a,b` names; all of them for None. Raises SettingsError for an unknown one."""
    if names is None:
        return tuple(known)
    by_name = {estimator.name: estimator for estimator in known}
    chosen = []
    for name in filter(None, (part.strip() for part in names.split(","))):
        if name not in by_name:
            raise SettingsError(f"there is no estimator {name!r}", hint=_nearest(name, by_name))
        chosen.append(by_name[name])
    if not chosen:
        raise SettingsError("--estimators names none", hint=f"known are {', '.join(by_name)}")
    return tuple(dict.fromkeys(chosen))


def defaults(estimator: Estimator) -> dict[str, float]:
    """An estimator's settings as they are without a file."""
    return {setting.name: setting.default for setting in estimator.settings}


def read_settings(path: Path | None, known: Sequence[Estimator]) -> Mapping[str, Settings]:
    """Settings of every estimator, by its name: the file's over the defaults.

    Raises SettingsError for an unreadable file, an unknown table or key, or a value outside its range.
    """
    settings = {estimator.name: defaults(estimator) for estimator in known}
    if path is None:
        return settings
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise SettingsError(f"cannot be read ({error.strerror})", path=path) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise SettingsError(f"not valid TOML ({error})", path=path) from error
    specs = {estimator.name: {s.name: s for s in estimator.settings} for estimator in known}
    for table, entries in raw.items():
        if table not in specs:
            raise SettingsError(f"unknown table [{table}]", path=path, hint=_nearest(table, specs))
        if not isinstance(entries, Mapping):
            raise SettingsError(
                f"{table!r} is no table", path=path, hint=f"write [{table}] on a line of its own"
            )
        for key, value in entries.items():
            place = f"[{table}] {key}"
            spec = specs[table].get(key)
            if spec is None:
                raise SettingsError(
                    "unknown setting", path=path, place=place, hint=_nearest(key, specs[table])
                )
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise SettingsError(f"found {value!r}, expected a finite number", path=path, place=place)
            if not spec.low <= value <= spec.high:
                raise SettingsError(
                    f"found {value:g}, expected {spec.low:g} to {spec.high:g} {spec.unit}".rstrip(),
                    path=path,
                    place=place,
                )
            settings[table][key] = float(value)
    return settings


def settings_text(known: Sequence[Estimator]) -> str:
    """A settings file with every default, unit and meaning."""
    lines: list[str] = []
    for estimator in known:
        lines += [f"[{estimator.name}]  # {estimator.title}"]
        for s in estimator.settings:
            unit = f" [{s.unit}]" if s.unit and s.unit != "–" else ""
            lines.append(f"{s.name} = {s.default:g}  # {s.meaning}{unit}, {s.low:g} to {s.high:g}")
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"
