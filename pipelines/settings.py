"""The settings file (TOML): one table an estimator, each key checked against what that estimator has."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from parsers.errors import SettingsError
from parsers.finite import is_number
from pipelines.estimators.base import (
    Configurable,
    Estimator,
    FullSettings,
    PriorEntry,
    PriorError,
    Setting,
    Settings,
    TextSetting,
)

PRIORS = "priors"
PRIOR_FORMS = (
    'distribution = "uniform"  # low, high',
    'distribution = "normal"   # value, std',
    'distribution = "beta"     # low, high, a, b',
)
MOST_BYTES = 1_000_000
MOST_PRIORS = 50
LONGEST_WORD = 100
"""A settings file that is larger is none; what is longer is not repeated in a message."""


def _nearest(word: str, known: Iterable[str]) -> str:
    names = sorted(known)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names)}"


def choose(names: str | None, known: Sequence[Estimator]) -> tuple[Estimator, ...]:
    """The estimators that `--estimators a,b` names, in whatever case; all of them for None. Raises SettingsError for an unknown one."""
    if names is None:
        return tuple(known)
    by_name = {estimator.name: estimator for estimator in known}
    chosen = []
    for name in filter(None, (part.strip().lower() for part in names.split(","))):
        if name not in by_name:
            raise SettingsError(
                f"there is no estimator {name!r}", hint=_nearest(name, by_name), wrong_usage=True
            )
        chosen.append(by_name[name])
    if not chosen:
        raise SettingsError(
            "--estimators names none", hint=f"known are {', '.join(by_name)}", wrong_usage=True
        )
    return tuple(dict.fromkeys(chosen))


def defaults(estimator: Estimator) -> dict[str, float]:
    """An estimator's numbers as they are without a file."""
    return {setting.name: setting.default for setting in estimator.settings}


def texts(estimator: Estimator) -> tuple[TextSetting, ...]:
    """An estimator's settings that are words; most have none."""
    return estimator.text_settings if isinstance(estimator, Configurable) else ()


def read_settings(path: Path | None, known: Sequence[Estimator]) -> Mapping[str, Settings]:
    """Settings of every estimator, by its name: the file's over the defaults.

    An estimator with words or priors gets `FullSettings`. Raises SettingsError for an unreadable file, an unknown table or
    key, or a value outside its range.
    """
    by_name = {estimator.name: estimator for estimator in known}
    raw = {} if path is None else _read(path)
    tables: dict[str, Mapping[str, object]] = {}
    for table, entries in raw.items():
        if table not in by_name:
            raise SettingsError(f"unknown table [{table}]", path=path, hint=_nearest(table, by_name))
        if not isinstance(entries, Mapping):
            raise SettingsError(
                f"{table!r} is no table", path=path, hint=f"write [{table}] on a line of its own"
            )
        tables[table] = entries
    return {name: _settings(estimator, tables.get(name, {}), path) for name, estimator in by_name.items()}


def _read(path: Path) -> Mapping[str, object]:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise SettingsError(f"larger than {MOST_BYTES // 1000} kB: no settings file", path=path)
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise SettingsError(f"cannot be read ({error.strerror})", path=path) from error
    except (ValueError, RecursionError) as error:
        raise SettingsError(f"not valid TOML ({error})", path=path) from error


def _settings(estimator: Estimator, entries: Mapping[str, object], path: Path | None) -> Settings:
    """One estimator's table over its defaults."""
    numbers = {s.name: s for s in estimator.settings}
    words = {s.name: s for s in texts(estimator)}
    configurable = isinstance(estimator, Configurable)
    found, chosen = defaults(estimator), {s.name: s.default for s in words.values()}
    priors: dict[str, PriorEntry] = {}
    for key, value in entries.items():
        place = f"[{estimator.name}] {key}"
        if key in numbers:
            found[key] = _number(value, numbers[key], path, place)
        elif key in words:
            chosen[key] = _word(value, words[key], path, place)
        elif configurable and key == PRIORS:
            priors = _priors(value, estimator.name, path)
        else:
            names = [*numbers, *words, *([PRIORS] if configurable else [])]
            raise SettingsError("unknown setting", path=path, place=place, hint=_nearest(key, names))
    if not isinstance(estimator, Configurable):
        return found
    try:
        estimator.check_priors(chosen, priors)
    except PriorError as error:
        place = f"[{estimator.name}.{PRIORS}.{error.place}]"
        raise SettingsError(error.message, path=path, place=place, hint=error.hint) from error
    return FullSettings(found, chosen, priors)


def _number(value: object, spec: Setting, path: Path | None, place: str) -> float:
    if not is_number(value):
        raise SettingsError(f"found {value!r}, expected a finite number", path=path, place=place)
    if not spec.low <= value <= spec.high:
        raise SettingsError(
            f"found {value:g}, expected {spec.low:g} to {spec.high:g} {spec.unit}".rstrip(),
            path=path,
            place=place,
        )
    return float(value)


def _word(value: object, spec: TextSetting, path: Path | None, place: str) -> str:
    if not isinstance(value, str):
        raise SettingsError(
            f"found {value!r}, expected a word in quotes", path=path, place=place,
            hint=f"known are {', '.join(spec.choices)}",
        )  # fmt: skip
    if value not in spec.choices:
        shown = value if len(value) <= LONGEST_WORD else value[:LONGEST_WORD] + "…"
        raise SettingsError(
            f"there is no {spec.name} {shown!r}", path=path, place=place, hint=_nearest(shown, spec.choices)
        )
    return value


def _priors(raw: object, estimator: str, path: Path | None) -> dict[str, PriorEntry]:
    """[estimator.priors.NAME] tables: words and finite numbers only; what they mean is the estimator's to check."""
    place = f"[{estimator}.{PRIORS}]"
    if not isinstance(raw, Mapping):
        raise SettingsError(
            "found no table of priors", path=path, place=place, hint=f"write [{estimator}.{PRIORS}.PARAMETER]"
        )
    if len(raw) > MOST_PRIORS:
        raise SettingsError(f"{len(raw)} priors, at most {MOST_PRIORS} are read", path=path, place=place)
    found: dict[str, PriorEntry] = {}
    for name, entry in raw.items():
        here = f"[{estimator}.{PRIORS}.{name[:LONGEST_WORD]}]"
        if not isinstance(entry, Mapping) or len(entry) > MOST_PRIORS:
            raise SettingsError(
                "a prior is a table",
                path=path,
                place=here,
                hint='distribution = "normal", value = …, std = …',
            )
        read: dict[str, float | str] = {}
        for key, value in entry.items():
            if isinstance(value, str):
                read[key] = value[:LONGEST_WORD]
            elif not is_number(value):
                raise SettingsError(
                    f"found {value!r}, expected a finite number", path=path, place=f"{here} {key}"
                )
            else:
                read[key] = float(value)
        found[name] = read
    return found


def settings_text(known: Sequence[Estimator]) -> str:
    """A settings file with every default, unit and meaning."""
    lines: list[str] = []
    for estimator in known:
        lines += [f"[{estimator.name}]  # {estimator.title}"]
        for s in estimator.settings:
            unit = f" [{s.unit}]" if s.unit and s.unit != "–" else ""
            lines.append(f"{s.name} = {s.default:g}  # {s.meaning}{unit}, {s.low:g} to {s.high:g}")
        for t in texts(estimator):
            lines.append(f'{t.name} = "{t.default}"  # {t.meaning}: {", ".join(t.choices)}')
        if isinstance(estimator, Configurable):
            lines += [f"# [{estimator.name}.{PRIORS}.PARAMETER]", *(f"# {line}" for line in PRIOR_FORMS)]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"
