"""Commands on logs in a store: as on logs of the disk, and errors in one line without secrets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

SECRET = "hunter2"


def test_a_drive_in_a_store_is_analysed_with_the_files_beside_it(
    inside, s3_store, samples: Path, tmp_path: Path, quick: Path
) -> None:
    url = s3_store.put(samples / "can", "fleet/van")
    s3_store.put(samples / "vehicle.toml", "fleet/vehicle.toml")
    there = tmp_path / "there"
    few = ("--estimators", "roll_map", "--settings", str(quick), "--format", "json")
    run = inside("analyze", f"{url}/drive.blf", "--out", str(there), *few)
    assert run.code == 0, run.err
    found = json.loads((there / "results.json").read_text())
    assert found["inputs"]["log"]["path"] == f"{url}/drive.blf"
    assert found["inputs"]["vehicle"] == "s3://drives/fleet/vehicle.toml"
    assert found["inputs"]["map"] == f"{url}/map.toml"
    assert any("s3 etag" in note for note in found["import"]["notes"])
    assert {"accel_y", "roll", "speed"} <= set(found["import"]["signals"])
    assert found["verdict"]["cg_height_m"]["value"] > 0


def test_a_fleet_and_its_results_in_a_bucket(
    inside, s3_store, samples: Path, tmp_path: Path, quick: Path
) -> None:
    for name in ("vehicle.toml", "map.toml", "track.vbo", "town.parquet"):
        s3_store.put(samples / "fleet" / "sedan" / name, f"fleet/sedan/{name}")
    s3_store.put(quick, "fleet/settings.toml")
    few = ("--engine", "serial", "--estimators", "roll_map", "--reports", "none", "--format", "html")
    run = inside("batch", "s3://drives/fleet", "--out", "s3://drives/results", *few)
    assert run.code == 0, run.err
    assert "2 done" in run.out
    again = inside("batch", "s3://drives/fleet", "--out", "s3://drives/results", *few)
    assert "0 done, 2 kept" in again.out
    # the same logs on the disk say the same
    here = tmp_path / "fleet" / "sedan"
    here.mkdir(parents=True)
    for name in ("vehicle.toml", "map.toml", "track.vbo", "town.parquet"):
        (here / name).write_bytes((samples / "fleet" / "sedan" / name).read_bytes())
    (here.parent / "settings.toml").write_bytes(quick.read_bytes())
    assert inside("batch", here.parent, "--out", tmp_path / "store", *few).code == 0
    shown = [
        inside("results", store, "--csv", "--table", "parameters")
        for store in ("s3://drives/results", tmp_path / "store")
    ]
    assert shown[0].out == shown[1].out
    assert shown[0].out.count("cg_height_m") >= 4


def test_a_log_in_a_store_is_inspected_and_converted(inside, s3_store, samples: Path, tmp_path: Path) -> None:
    url = s3_store.put(samples / "ros", "bags") + "/drive_mcap"
    run = inside("inspect", url, "--json")
    assert run.code == 0, run.err
    assert json.loads(run.out)["format"] == "ROS 2 bag"
    run = inside("convert", url, "--out", str(tmp_path / "tables"))
    assert run.code == 0, run.err
    assert list((tmp_path / "tables").glob("*.parquet"))


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("s3://drives/none.mcap", "s3://drives/none.mcap: no such file"),
        ("s3://no-bucket/none.mcap", "s3://no-bucket/none.mcap: cannot be opened (there is no such bucket)"),
        ("nosuch://a/b.mcap", "no library knows nosuch://"),
    ],
)
def test_a_place_that_is_not_there_is_one_line(inside, s3_store, url: str, said: str) -> None:
    run = inside("analyze", url)
    assert run.code == 1
    assert said in run.err
    assert len(run.err.strip().splitlines()) == 1


@pytest.mark.parametrize("option", ["--dbc", "--map", "--vehicle", "--settings", "--suspension-map"])
def test_a_file_that_a_store_does_not_give_is_one_line(inside, s3_store, samples: Path, option: str) -> None:
    for url, said in (("s3://drives/none", "no such file"), ("s3://no-bucket/x", "there is no such bucket")):
        run = inside("analyze", str(samples / "can" / "drive.blf"), option, url)
        assert run.code == 1
        assert url in run.err
        assert said in run.err.lower()
        assert len(run.err.strip().splitlines()) == 1


def test_secrets_of_a_url_are_not_shown(inside, s3_store, monkeypatch: pytest.MonkeyPatch) -> None:
    from parsers import places_fs

    monkeypatch.setattr(places_fs, "WAITS_S", ())
    host = s3_store.endpoint.removeprefix("http://")
    run = inside("analyze", f"http://me:{SECRET}@{host}/drives/none.mcap?X-Amz-Signature={SECRET}")
    assert run.code == 1
    assert f"http://…@{host}/drives/none.mcap?…: no such file" in run.err
    assert SECRET not in run.err


def test_a_report_is_not_written_to_a_url(inside, samples: Path) -> None:
    run = inside("analyze", str(samples / "csv" / "drive.csv"), "--out", "s3://drives/report")
    assert run.code == 1
    assert "written to folders of this machine" in run.err
