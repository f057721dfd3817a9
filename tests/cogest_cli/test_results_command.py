"""`cogest results`: the overview to read, exports to a file and to standard output, and refusals."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import dataclass
from pathlib import Path

import polars as pl
import pytest
import typer
from typer.testing import CliRunner

from cogest_cli.results_command import results
from parsers.errors import CogestError
from pipelines.fleet.store import open_store
from pipelines.fleet.tables import TABLES
from tests.reports.sample_fleet import sample_fleet

FLEET = sample_fleet(24, 3, failed=0.2)


@dataclass(frozen=True)
class Ran:
    code: int
    out: bytes
    error: str

    @property
    def text(self) -> str:
        return self.out.decode()


def run(*arguments: object) -> Ran:
    """The command alone; a known error as `cogest` would tell it."""
    app = typer.Typer()
    app.command()(results)
    done = CliRunner(env={"COLUMNS": "160"}).invoke(app, [str(a) for a in arguments])
    if isinstance(done.exception, CogestError):
        return Ran(1, b"", str(done.exception))
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return Ran(done.exit_code, done.stdout_bytes, done.stderr)


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with tables."""
    place = tmp_path_factory.mktemp("results") / "store"
    open_store(str(place), create=True).write_tables(FLEET)
    return place


def test_overview_has_values_with_intervals_and_failures_with_reasons(store: Path) -> None:
    done = run(store)
    assert done.code == 0
    failed = FLEET["drives"].filter(pl.col("status") != "done")
    ok = FLEET["drives"].height - failed.height
    assert f"24 drives of 3 vehicles, {ok} done, {failed.height} failed" in done.text
    for row in failed.iter_rows(named=True):
        assert f"{row['status']}: " in done.text
    words = " ".join(done.text.split())
    assert all(" ".join(reason.split())[:40] in words for reason in failed["reason"])
    assert done.text.count("Vehicle van-") == 3
    assert "CG height above ground" in done.text
    assert "± 0.014 m (" in done.text
    assert max(len(line) for line in done.text.splitlines()) <= 160


def test_overview_of_some(store: Path) -> None:
    done = run(store, "--vehicle", "van-01", "--parameter", "cg_lateral_offset_m", "--status", "done")
    assert done.code == 0
    assert "CG lateral offset" in done.text
    assert "Mass" not in done.text
    assert done.text.count("Vehicle van-") == 1
    assert "timeout" not in done.text


@pytest.mark.parametrize("name", [name for name in TABLES if name != "drives"])
def test_every_table_to_read(store: Path, name: str) -> None:
    done = run(store, "--table", name)
    assert done.code == 0
    assert len(done.text.splitlines()) >= FLEET[name].height


def test_exports_to_standard_output(store: Path) -> None:
    drives = run(store, "--csv")
    cells = list(csv.DictReader(io.StringIO(drives.text)))
    assert [cell["drive_id"] for cell in cells] == FLEET["drives"]["drive_id"].to_list()
    mass = json.loads(run(store, "--json", "--parameter", "mass_kg").out)
    assert {row["parameter"] for row in mass} == {"mass_kg"}
    parquet = pl.read_parquet(io.BytesIO(run(store, "--parquet", "--table", "vehicles").out))
    assert parquet.equals(FLEET["vehicles"])


@pytest.mark.parametrize("form", ["csv", "json", "parquet"])
def test_exports_to_a_file_whose_suffix_says_the_form(store: Path, tmp_path: Path, form: str) -> None:
    by_suffix, by_option = tmp_path / f"a.{form}", tmp_path / "b"
    assert run(store, "--out", by_suffix).text.strip().endswith(f"a.{form}")
    run(store, f"--{form}", "--out", by_option)
    assert by_suffix.read_bytes() == by_option.read_bytes() == run(store, f"--{form}").out


def test_text_to_a_file(store: Path, tmp_path: Path) -> None:
    run(store, "--out", tmp_path / "overview.txt")
    assert "24 drives" in (tmp_path / "overview.txt").read_text(encoding="utf-8")


def test_refusals(store: Path, tmp_path: Path) -> None:
    assert run(store, "--csv", "--json").code == 2
    assert run(store, "--csv", "--out", tmp_path / "drives.parquet").code == 2
    assert "no results store" in run(tmp_path).error
    assert "unknown table 'x'; known are drives" in run(store, "--table", "x").error
    assert "no vehicle x" in run(store, "--vehicle", "x").error
    assert "no status fialed" in run(store, "--status", "fialed").error
    for arguments in (("--csv",), ("--table", "parameters")):
        odd = run(store, *arguments, "--status", "failed", "--status", "fialed")
        assert odd.code == 1
        assert "; there are " in odd.error
    assert run(store, "--status", "memory").code == 0
    assert "as '.xlsx'; choose .csv" in run(store, "--out", tmp_path / "drives.xlsx").error
    assert not (tmp_path / "drives.xlsx").exists()
    assert "no parameter 'mass'" in run(store, "--parameter", "mass").error
    open_store(str(tmp_path / "new"), create=True)
    assert "the table is not there yet" in run(tmp_path / "new").error
    open_store(str(tmp_path / "new")).write_tables(FLEET)
    (tmp_path / "new" / "drives.parquet").write_bytes(b"PAR1 rubbish PAR1")
    assert "is not what was written there; run `cogest batch` again" in run(tmp_path / "new").error
    open_store(str(tmp_path / "new")).write_tables({"drives": pl.DataFrame({"a": [1]})})
    assert "not the columns" in run(tmp_path / "new").error


def test_texts_of_a_hostile_store_do_not_steer_the_terminal(tmp_path: Path) -> None:
    odd = FLEET["drives"].with_columns(
        drive=pl.lit("\x1b[31mred\x07"), reason=pl.lit("=1\n\u202ex"), vehicle_id=pl.lit("a\x9b2J"), status=pl.lit("error")
    )  # fmt: skip
    open_store(str(tmp_path / "s"), create=True).write_tables({**FLEET, "drives": odd})
    for arguments in ((), ("--json",), ("--csv",)):
        text = run(tmp_path / "s", *arguments).text
        assert all(c.isprintable() or c in "\r\n" for c in text)
