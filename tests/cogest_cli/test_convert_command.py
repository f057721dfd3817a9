"""`cogest convert`: what it says on the console."""

from __future__ import annotations


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
