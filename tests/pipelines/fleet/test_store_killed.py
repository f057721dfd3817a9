"""A batch that is killed again and again ends with the same tables; and no damage to a store's files is a traceback."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipelines.fleet.gather import gather
from pipelines.fleet.store import Store, open_store
from pipelines.fleet.tables import TABLES
from tests.pipelines.fleet.stored_drives import (
    facts_of_drive,
    fleet_of,
    found_drive,
    join_plainly,
    kept_of_drive,
    results_of_drive,
    work,
)

ROOT = Path(__file__).resolve().parents[3]
COUNT = 14

WORKER = f"""
import sys
sys.path.insert(0, sys.argv[2])
from tests.pipelines.fleet.stored_drives import work
print("ready", flush=True)
work(sys.argv[1], {COUNT})
"""


def tables(place: Path) -> dict[str, bytes]:
    names = ["tables.json", *(f"{name}.parquet" for name in TABLES)]
    return {name: (place / name).read_bytes() for name in names}


def test_killed_again_and_again(tmp_path: Path) -> None:
    work(str(tmp_path / "whole"), COUNT)
    killed = tmp_path / "killed"
    ended = 0
    for attempt in range(4):
        worker = subprocess.Popen(
            [sys.executable, "-c", WORKER, str(killed), str(ROOT)], stdout=subprocess.PIPE, cwd=ROOT
        )
        assert worker.stdout is not None
        worker.stdout.readline()
        time.sleep(0.03 + 0.12 * attempt)
        worker.send_signal(signal.SIGKILL)
        worker.stdout.close()
        if worker.wait() == 0:
            break
        ended += 1
        catalogue = open_store(str(killed)).all() if (killed / "store.json").exists() else None
        assert catalogue is None or not catalogue.damaged
        if catalogue is not None and len(catalogue.drives) == COUNT:
            break
    assert ended >= 1
    work(str(killed), COUNT)
    assert tables(killed) == tables(tmp_path / "whole")
    assert list((killed / ".partial").iterdir()) == []


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with three drives, joined."""
    store = open_store(str(tmp_path_factory.mktemp("sound") / "store"), create=True)
    for number in range(3):
        results, kept = results_of_drive(number), kept_of_drive(number)
        store.put(found_drive(number), "key", facts_of_drive(number), results, kept, {"report.html": b"x"})
    _tables(store)
    return Path(store.place)


def _tables(store: Store) -> dict[str, int]:
    fleet = fleet_of(*(found_drive(number) for number in range(3)))
    made = gather(store, fleet, join_plainly, lambda *_: ())
    return {name: table.height for name, table in made.items()}


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_no_damage_is_a_traceback(sound: Path, tmp_path: Path, data: st.DataObject) -> None:
    place = tmp_path / "store"
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(sound, place)
    files = sorted(
        path for part in ("drives", "vehicles") for path in (place / part).rglob("*") if path.is_file()
    )
    path = data.draw(st.sampled_from(files), label="file")
    content = bytearray(path.read_bytes())
    start = data.draw(st.integers(0, len(content)), label="start")
    kind = data.draw(st.sampled_from(["cut", "change", "insert"]), label="kind")
    if kind == "cut":
        del content[start:]
    else:
        stop = start if kind == "insert" else start + data.draw(st.integers(1, 8))
        content[start:stop] = data.draw(st.binary(min_size=1, max_size=8))
    path.write_bytes(content)
    store = open_store(str(place), create=True)
    heights = _tables(store)
    assert heights["drives"] == 3
    # what was damaged is to be done again, unless it was no more than another form of the same
    problems = store.all().damaged
    assert len(problems) <= 1


def test_a_changed_figure_of_a_vehicle_is_joined_anew(sound: Path, tmp_path: Path) -> None:
    place = tmp_path / "store"
    shutil.copytree(sound, place)
    (file,) = (place / "vehicles").rglob("*.json")
    whole = file.read_bytes()
    value = re.search(rb'"value":\s*(\d+\.\d+)', whole)
    assert value is not None
    for damage in (b"9" + value[1], value[1][::-1]):
        file.write_bytes(whole.replace(value[1], damage))
        assert _tables(open_store(str(place), create=True))["drives"] == 3
        assert file.read_bytes() == whole
