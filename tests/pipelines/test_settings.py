"""The settings file: defaults, what it changes, and every slip of the pen named."""

from __future__ import annotations

import tomllib

import pytest

from parsers.errors import SettingsError
from pipelines.estimators.registry import estimators
from pipelines.settings import choose, defaults, read_settings, settings_text, texts

KNOWN = estimators()
FIRST = KNOWN[0]
SETTING = FIRST.settings[0]


def written(tmp_path, text):
    path = tmp_path / "settings.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_without_a_file_all_are_defaults():
    assert read_settings(None, KNOWN) == {e.name: {s.name: s.default for s in e.settings} for e in KNOWN}


def test_a_file_changes_what_it_names_and_nothing_else(tmp_path):
    settings = read_settings(written(tmp_path, f"[{FIRST.name}]\n{SETTING.name} = {SETTING.high}\n"), KNOWN)
    assert settings[FIRST.name] == {**defaults(FIRST), SETTING.name: SETTING.high}
    assert isinstance(settings[FIRST.name][SETTING.name], float)


def test_both_ends_of_a_range_are_allowed(tmp_path):
    for value in (SETTING.low, SETTING.high):
        assert read_settings(written(tmp_path, f"[{FIRST.name}]\n{SETTING.name} = {value!r}\n"), KNOWN)


def test_a_byte_order_mark_is_no_mistake(tmp_path):
    path = written(tmp_path, b"\xef\xbb\xbf" + f"[{FIRST.name}]\n".encode())
    assert read_settings(path, KNOWN) == read_settings(None, KNOWN)


def test_the_printed_file_is_valid_and_changes_nothing(tmp_path):
    text = settings_text(KNOWN)
    words = {e.name: {t.name: t.default for t in texts(e)} for e in KNOWN}
    assert tomllib.loads(text) == {e.name: {**defaults(e), **words[e.name]} for e in KNOWN}
    assert read_settings(written(tmp_path, text), KNOWN) == read_settings(None, KNOWN)
    for estimator in KNOWN:
        for setting in estimator.settings:
            assert setting.meaning in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"[{FIRST.name}x]", rf"unknown table \[{FIRST.name}x\]; did you mean '{FIRST.name}'"),
        (
            "[vehicle]",
            f"unknown table .*known are .*{FIRST.name}",
        ),  # a vehicle file: not "did you mean 'pitch_plane'"
        ("[zzz]", f"unknown table .*known are .*{FIRST.name}"),
        (
            f"[{FIRST.name}]\n{SETTING.name}z = 1",
            rf"\[{FIRST.name}\] {SETTING.name}z: unknown setting; did you",
        ),
        (f"[{FIRST.name}]\n{SETTING.name} = '1'", "found '1', expected a finite number"),
        (f"[{FIRST.name}]\n{SETTING.name} = false", "found False, expected a finite number"),
        (f"[{FIRST.name}]\n{SETTING.name} = nan", "found nan, expected a finite number"),
        (f"[{FIRST.name}]\n{SETTING.name} = inf", "found inf, expected a finite number"),
        (
            f"[{FIRST.name}]\n{SETTING.name} = 1e99",
            f"found 1e.99, expected {SETTING.low:g} to {SETTING.high:g}",
        ),
        (f"{FIRST.name} = 3", "is no table; write"),
        ("[", "not valid TOML"),
        (b"\xff\xfe", "not valid TOML"),
        ("a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_mistakes_are_named(tmp_path, text, message):
    with pytest.raises(SettingsError, match=message) as caught:
        read_settings(written(tmp_path, text), KNOWN)
    assert "settings.toml" in str(caught.value)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(SettingsError, match="cannot be read"):
        read_settings(tmp_path / "none.toml", KNOWN)


def test_estimators_by_name():
    assert choose(None, KNOWN) == KNOWN
    assert choose(f" {FIRST.name} ,{FIRST.name},", KNOWN) == (FIRST,)
    assert choose(FIRST.name.upper(), KNOWN) == (FIRST,)
    with pytest.raises(SettingsError, match=f"no estimator '{FIRST.name[:-1]}'; did you mean '{FIRST.name}'"):
        choose(FIRST.name[:-1], KNOWN)
    with pytest.raises(SettingsError, match=f"names none; known are .*{FIRST.name}"):
        choose(" , ", KNOWN)
