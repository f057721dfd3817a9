"""`cogest inspect`: the text, the JSON, and the starter mapping file that it writes."""

from __future__ import annotations

import json

import polars as pl
import pytest


def test_the_text_names_channels_signals_checks_and_estimators(inside, samples):
    run = inside("inspect", samples / "vbo" / "drive.vbo")
    assert (run.code, run.err) == (0, "")
    for text in (
        ": Racelogic VBO, complete",
        "Channels",
        "Signals",
        "-> accel_y",
        "Estimators",
        "roll_map: can run",
    ):
        assert text in run.out


def test_the_json_says_the_same(inside, samples):
    run = inside("inspect", samples / "vbo" / "drive.vbo", "--json")
    assert (run.code, run.err) == (0, "")
    found = json.loads(run.out)
    assert (found["format"], found["status"], found["problem"]) == ("Racelogic VBO", "complete", None)
    channels = {channel["name"]: channel for channel in found["channels"]}
    assert channels["velocity"]["signal"] == "speed"
    assert channels["velocity"]["samples"] == found["messages"] == 1823
    assert 39 < channels["velocity"]["rate_hz"] < 41
    assert {entry["signal"] for entry in found["import"]["mapped"]} >= {"accel_y", "roll", "speed"}
    (ready,) = [e for e in found["estimators"] if e["estimator"] == "roll_map"]
    assert ready["ready"]


def test_rates_are_those_of_the_channel_and_what_was_dropped_is_said(inside, tmp_path):
    """100 rows a second, a column with a value in each tenth, a gap, nine repeated stamps, a clock set back for good."""
    rows = [
        f"{min(k, 900) if 900 < k < 910 else k / 1:.0f},{k % 7 - 3},{k if k % 10 == 0 else ''}"
        for k in range(6000)
    ]
    rows = rows[:3000] + rows[4500:] + [f"{k},1,1" for k in range(100, 700)]
    log = tmp_path / "log.csv"
    log.write_text("t [ms],ay [m/s2],speed [m/s]\n" + "\n".join(r.replace(",", "0,", 1) for r in rows) + "\n")
    run = inside("inspect", log, "--json")
    found = json.loads(run.out)
    rates = {channel["name"]: channel["rate_hz"] for channel in found["channels"]}
    assert rates["ay"] == pytest.approx(100, rel=0.01)
    assert 9 < rates["speed"] < 21
    assert found["rejected"] == {"row beyond a jump of the clock": 600}
    text = inside("inspect", log).out
    assert "600 x row beyond a jump of the clock" in text
    assert "Put in order: 9 repeated stamps, 1 clock jump" in text


def test_what_nothing_maps_to_is_said_and_the_starter_file_can_be_filled_in(inside, drive, tmp_path):
    frame = pl.read_csv(drive).select(t="time_s", ay="accel_y_mps2", phi="roll_rad", v="speed_mps")
    log = tmp_path / "odd.csv"
    frame.rename({"ay": "kappa", "phi": "lambda", "v": "mu"}).write_csv(log)
    starter = tmp_path / "map.toml"
    run = inside("inspect", log, "--write-map", starter)
    assert run.code == 0
    assert "Signals: none. no channel maps to a signal" in run.out
    assert "roll_map: lacks accel_y" in run.out
    assert f"starter mapping file: {starter}" in run.out
    again = inside("inspect", log, "--write-map", starter)
    assert (again.code, again.out) == (1, "")
    assert "map.toml: is there already" in again.err
    starter.write_text(
        '[signals.accel_y]\nchannel = "kappa"\nunit = "m/s2"\n'
        '[signals.roll]\nchannel = "lambda"\nunit = "rad"\n'
        '[signals.speed]\nchannel = "mu"\nunit = "m/s"\n',
        encoding="utf-8",
    )
    assert "roll_map: can run" in inside("inspect", log, "--map", starter).out


def test_the_starter_file_maps_the_same_and_the_drive_can_be_analysed_with_it(
    inside, samples, quick, tmp_path
):
    log = samples / "vbo" / "drive.vbo"
    starter = tmp_path / "starter.toml"
    run = inside("inspect", log, "--json", "--write-map", starter)
    before = json.loads(run.out)["import"]["mapped"]
    after = json.loads(inside("inspect", log, "--map", starter, "--json").out)["import"]["mapped"]
    assert [(m["signal"], m["channel"], m["samples"]) for m in after] == [
        (m["signal"], m["channel"], m["samples"]) for m in before
    ]
    assert {m["unit_from"] for m in after} == {"map file"}
    out = tmp_path / "out"
    run = inside("analyze", log, "--map", starter, "--format", "json", "--settings", quick, "--out", out)
    assert (run.code, run.err) == (0, "")
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert results["inputs"]["map"] == str(starter)
    assert results["verdict"]["roll_gradient_degpg"]["status"] == "identified"


def test_control_characters_of_a_log_stay_out_of_the_terminal(inside, tmp_path):
    log = tmp_path / "log.parquet"
    rows = {"time_ns": [i * 10**8 for i in range(60)], "speed_mps": [float(i % 3) for i in range(60)]}
    pl.DataFrame({**rows, "bad\x1b]0;title\x07\x9bname": rows["speed_mps"]}).write_parquet(log)
    run = inside("inspect", log)
    assert run.code == 0
    assert "bad" in run.out
    assert all(c.isprintable() or c == "\n" for c in run.out)


def test_a_signal_that_the_checks_leave_out_is_shown_so(inside, drive, tmp_path):
    frame = pl.read_csv(drive).with_columns(pitch_rad=pl.lit(0.0))
    frame.write_csv(drive)
    run = inside("inspect", drive, "--json")
    found = json.loads(run.out)
    (channel,) = [c for c in found["channels"] if c["name"].startswith("pitch") and "rate" not in c["name"]]
    assert channel["signal"] is None
    assert channel["reason"].startswith("pitch, left out: pitch stands at 0°")
    (entry,) = [m for m in found["import"]["mapped"] if m["signal"] == "pitch"]
    assert not entry["used"]
    assert entry["rule"].startswith("left out by the checks")
    assert all(m["used"] for m in found["import"]["mapped"] if m["signal"] != "pitch")
