"""`cogest convert`: what it says on the console."""

from __future__ import annotations

import polars as pl
import pytest


def table(rows):
    return "time_s,accel_y_mps2,speed_mps\n" + "".join(rows)


def test_gaps_are_said(inside, tmp_path):
    log = tmp_path / "drive.csv"
    log.write_text(table(f"{k / 100:.2f},{k % 7},{k % 5}\n" for k in range(2000) if not 1000 < k < 1250))
    run = inside("convert", log, "--out", tmp_path / "out")
    assert (run.code, run.err) == (0, "")
    assert "  gaps of the whole drive: 1 (10.0-12.5 s)\n" in run.out


def test_gaps_of_single_signals_and_what_damage_took_are_said(inside, tmp_path):
    rows = [f"{k / 100:.2f},{'' if 500 < k < 600 else k % 7},{k % 5}\n" for k in range(2000)]
    rows[1001:1006] = ["\0" * 40 + "\n"]
    log = tmp_path / "drive.csv"
    log.write_text(table(rows))
    run = inside("convert", log, "--out", tmp_path / "out")
    assert run.code == 0
    assert "  lost to damage: 1 (10.000-10.060 s)\n" in run.out
    assert "  gaps of single signals: accel_y 1\n" in run.out
    assert "Lost to damage: 1 (10.000-10.060 s)\n" in inside("inspect", log).out


def test_a_whole_log_has_no_such_line(inside, tmp_path):
    log = tmp_path / "drive.csv"
    log.write_text(table(f"{k / 100:.2f},{k % 7},{k % 5}\n" for k in range(2000)))
    run = inside("convert", log, "--out", tmp_path / "out")
    assert "gaps" not in run.out
    assert "lost" not in run.out


TURNING = "time,ay [m/s2]," + ",".join(f"omega_{w} [rad/s]" for w in ("fl", "fr", "rl", "rr")) + "\n"


def turning(folder):
    log = folder / "drive.csv"
    log.write_text(TURNING + "".join(f"{k / 100:.2f},{k % 7},50,50,50,{50 + k % 3}\n" for k in range(2000)))
    return log


def test_turn_rates_of_wheels_need_the_radius_and_the_console_says_where_it_goes(inside, tmp_path):
    run = inside("convert", turning(tmp_path), "--out", tmp_path / "out")
    assert run.code == 0
    assert "wheel_radius_m" in run.out
    assert "[wheels] radius_m" in run.out
    (path,) = (tmp_path / "out").glob("*.parquet")
    assert "wheel_speed_fl_mps" not in pl.read_parquet(path).columns


@pytest.mark.parametrize("given", [True, False])
def test_the_vehicle_file_s_radius_is_taken(inside, tmp_path, given):
    vehicle = tmp_path / ("car.toml" if given else "vehicle.toml")
    vehicle.write_text("[vehicle]\nwheel_radius_m = 0.3\n")
    options = ("--vehicle", vehicle) if given else ()
    run = inside("convert", turning(tmp_path), *options, "--out", tmp_path / "out")
    assert run.code == 0
    assert f"as {vehicle.name} has it" in run.out
    (path,) = (tmp_path / "out").glob("*.parquet")
    assert pl.read_parquet(path)["wheel_speed_fl_mps"].to_list()[0] == pytest.approx(15.0)


def test_the_mapping_file_s_radius_comes_first(inside, tmp_path):
    (tmp_path / "vehicle.toml").write_text("[vehicle]\nwheel_radius_m = 0.3\n")
    (tmp_path / "map.toml").write_text("[wheels]\nradius_m = 0.4\n")
    assert inside("convert", turning(tmp_path), "--out", tmp_path / "out").code == 0
    (path,) = (tmp_path / "out").glob("*.parquet")
    assert pl.read_parquet(path)["wheel_speed_fl_mps"].to_list()[0] == pytest.approx(20.0)


def test_a_vehicle_file_that_cannot_be_read_is_an_error(inside, tmp_path):
    vehicle = tmp_path / "car.toml"
    vehicle.write_text("[vehicle]\nwheel_radius = 0.3\n")
    run = inside("convert", turning(tmp_path), "--vehicle", vehicle, "--out", tmp_path / "out")
    assert run.code != 0
    assert "wheel_radius_m" in run.err
    assert not (tmp_path / "out").exists()
