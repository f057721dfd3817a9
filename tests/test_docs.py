"""The documentation says what the program does: commands, options, links, examples, generated pages."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import typer

from cogest_cli.main import app
from parsers.mapping import read_map
from parsers.registry import importers
from parsers.signals import SIGNALS
from pipelines.estimators.registry import estimators
from pipelines.parameters import PARAMETERS
from pipelines.vehicles.keys import LOAD_KEYS, SENSOR_KEYS, TEXT_KEYS, VEHICLE_KEYS
from pipelines.vehicles.vehicle_file import parse_vehicle

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
COMMANDS: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
OPTIONS = {name: {flag for p in command.params for flag in p.opts} for name, command in COMMANDS.items()}
GENERAL = {"--help", "--version"}


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return re.findall(rf"^```{language}(?: [^\n]*)?\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def calls(text: str) -> list[list[str]]:
    """Every `cogest …` in code: inline, and in lines of blocks."""
    inline = re.findall(r"`(cogest(?: [^`]*)?)`", text)
    lines = [line for block in blocks(text, "sh") for line in block.splitlines()]
    lines = [part for line in lines for part in line.split("&&")]
    found = [*inline, *(m[1] for line in lines if (m := re.search(r"(?:^|/|\s)(cogest\s.*)", line)))]
    return [shlex.split(call.replace("…", ""), comments=True)[1:] for call in found]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_and_option_that_a_page_names_exists(page):
    for arguments in calls(text_of(page)):
        if not arguments:
            continue
        command, *rest = arguments
        if command.startswith("-"):
            assert command in GENERAL
            continue
        assert command in COMMANDS, f"{page.name}: cogest {command}"
        for flag in (word.split("=")[0] for word in rest if word.startswith("--")):
            assert flag in OPTIONS[command] | GENERAL, f"{page.name}: cogest {command} {flag}"


def test_options_in_prose_exist():
    known = set().union(*OPTIONS.values()) | GENERAL
    for page in PAGES:
        for flag in re.findall(r"`(--[a-z-]+)", text_of(page)):
            assert flag in known, f"{page.name}: {flag}"


def test_every_command_and_option_has_help():
    for name, command in COMMANDS.items():
        assert command.help, name
        for parameter in command.params:
            assert parameter.help, f"{name} {parameter.name}"


def test_every_command_is_in_the_readme():
    named = {arguments[0] for arguments in calls(text_of(ROOT / "README.md")) if arguments}
    assert set(COMMANDS) <= named


def test_the_readme_has_its_two_commands_in_blocks_of_one_line():
    text = text_of(ROOT / "README.md")
    for number, words in ((1, ("pip install", "cogest analyze sample_logs/")), (2, ("'.[test]'", "pytest"))):
        (block,) = re.findall(rf"^```sh command-{number}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
        assert block.count("\n") == 1
        assert all(word in block for word in words)
    log = re.search(r"cogest analyze (\S+)", text)
    assert log
    assert (ROOT / log[1]).exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if "://" in target or target.startswith("#"):
            continue
        path, _, _ = target.partition("#")
        assert (page.parent / path).exists(), f"{page.name} links to {target}"


def test_files_of_the_repository_that_pages_name_exist():
    for page in PAGES:
        for name in re.findall(
            r"`((?:docs|parsers|pipelines|reports|tests|sample_logs|cogest_cli|benchmarks)/[\w./]+)`",
            text_of(page),
        ):
            path = ROOT / name
            assert path.exists() or path.with_suffix(".py").exists(), f"{page.name} names {name}"


def made_pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_reference", ROOT / "docs" / "make_reference.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_generated_pages_are_fresh():
    for path, text in made_pages().pages().items():
        assert path.exists(), f"run docs/make_reference.py: {path.name} is missing"
        assert text_of(path) == text, f"run docs/make_reference.py: {path.name} is old"


def test_every_signal_parameter_format_and_setting_is_documented():
    signals = text_of(ROOT / "docs" / "signals.md")
    for spec in SIGNALS.values():
        assert f"| `{spec.name}` | `{spec.column}` |" in signals
    for name in PARAMETERS:
        assert f"| `{name}` |" in signals
    formats = text_of(ROOT / "docs" / "formats.md")
    for importer in importers():
        assert f"| {importer.title} | `{importer.name}` |" in formats
    settings = text_of(ROOT / "docs" / "settings.md")
    for estimator in estimators():
        assert f"## {estimator.name}: " in settings
        assert all(f"| `{setting.name}` |" in settings for setting in estimator.settings)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_of_mapping_and_vehicle_files_can_be_used(page, tmp_path):
    for block in blocks(text_of(page), "toml"):
        tables = tomllib.loads(block)
        if {"signals", "time"} & tables.keys():
            path = tmp_path / "map.toml"
            path.write_text(block, encoding="utf-8")
            assert read_map(path).signals
        elif "vehicle" in tables:
            assert parse_vehicle(block, tmp_path / "vehicle.toml").quantities


def test_the_mapping_page_shows_every_key():
    from parsers.mapping import map_file

    (block,) = blocks(text_of(ROOT / "docs" / "mapping.md"), "toml")
    tables = tomllib.loads(block)
    assert set(tables["time"]) == set(map_file._TIME_KEYS)
    assert {key for entry in tables["signals"].values() for key in entry} == set(map_file._SIGNAL_KEYS)
    assert all(unit in block for unit in map_file.TIME_UNITS)


def test_the_vehicle_page_shows_every_key():
    (block,) = blocks(text_of(ROOT / "docs" / "vehicle.md"), "toml")
    tables = tomllib.loads(block)
    assert set(tables["vehicle"]) == VEHICLE_KEYS | TEXT_KEYS
    assert set(tables["load"]) == LOAD_KEYS
    assert set(tables["sensors"]) == SENSOR_KEYS
    assert set(tables["reference"]) <= set(PARAMETERS)


def test_the_results_page_shows_the_fixed_names():
    (block,) = blocks(text_of(ROOT / "docs" / "results.md"), "json")
    for name in ("cogest", "inputs", "import", "verdict", "estimates", "rollover", "static_stability_factor"):
        assert f'"{name}"' in block


def test_no_page_has_lines_of_its_own_machine():
    for page in PAGES:
        assert not re.search(r"(?:^|[\s`\"'(])/(?:home|root|tmp|work|Users)/", text_of(page)), page.name
