"""What goes wrong is one line on stderr with the file, what was found and the next step; never a traceback."""

from __future__ import annotations

import os
import re

import pytest

import parsers.convert
import parsers.load


def one_line(run, *words, code=1):
    """Whether a run ended as a known error whose only line holds the words."""
    assert run.code == code, run
    assert run.out == ""
    assert run.err.startswith("cogest: ")
    assert run.err.endswith("\n")
    assert run.err.count("\n") == 1, run.err
    assert "Traceback" not in run.err
    for word in words:
        assert str(word) in run.err
    return True


def test_the_installed_program_on_a_missing_an_empty_and_a_cut_log(cogest, samples, tmp_path):
    assert one_line(cogest("analyze", tmp_path / "none" / "drive.csv"), "none/drive.csv: no such file")
    empty = tmp_path / "empty.vbo"
    empty.touch()
    assert one_line(cogest("convert", empty, "--out", tmp_path / "o"), empty, "the file is empty (0 bytes)")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes((samples / "ros" / "drive_ros2.mcap").read_bytes()[:40])
    assert one_line(cogest("convert", cut, "--out", tmp_path / "o"), cut)


@pytest.mark.parametrize("command", ["analyze", "inspect", "convert"])
def test_a_log_that_is_none(inside, tmp_path, command):
    out = () if command == "inspect" else ("--out", tmp_path / "out")
    empty_folder = tmp_path / "folder"
    empty_folder.mkdir()
    assert one_line(inside(command, empty_folder, *out), empty_folder, "the folder is neither")
    (empty_folder / "drive.csv").write_text("t,speed\n0,1\n", encoding="utf-8")
    assert one_line(inside(command, empty_folder, *out), "it holds drive.csv; give the log file itself")
    picture = tmp_path / "picture.mcap"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    assert one_line(inside(command, picture, *out), picture, "not a format that cogest knows")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert one_line(inside(command, pipe, *out), pipe, "a pipe or a device")
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    assert one_line(inside(command, loop, *out), loop, "cannot be opened")
    assert one_line(inside(command, tmp_path / ("x" * 300), *out), "cannot be opened (File name too long)")
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="needs a file that opens but cannot be read")
def test_a_log_that_cannot_be_read(inside, tmp_path, drive):
    assert one_line(inside("analyze", "/proc/self/mem"), "/proc/self/mem: cannot be opened")
    if os.geteuid() != 0:
        drive.chmod(0)
        assert one_line(inside("analyze", drive), drive, "cannot be opened (Permission denied)")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s\n0.0\n0.1\n0.2\n", ("no rows of numbers",)),
        ("time_s,accel_y_mps2\n0.0,1.0\n", ("no signal has two valid samples: accel_y",)),
        ("a,b\n" + "".join(f"{i * 7 % 5},{i}\n" for i in range(9)), ("no time column", "[time] channel")),
        (
            "time_s,banana,apple\n" + "".join(f"{i / 10},{i},{i}\n" for i in range(50)),
            ("no channel maps to a signal", "2 numeric channels (banana, apple)", "--write-map"),
        ),
    ],
)
def test_a_table_without_a_usable_channel(inside, tmp_path, text, words):
    log = tmp_path / "log.csv"
    log.write_text(text, encoding="utf-8")
    assert one_line(inside("analyze", log, "--out", tmp_path / "out"), log, *words)
    assert one_line(inside("convert", log, "--out", tmp_path / "out"), log, *words)


def test_a_can_log_without_a_database_says_how_to_give_one(inside, tmp_path):
    log = tmp_path / "can.log"
    log.write_text(
        "".join(f"({1.0 + i / 100:.6f}) can0 123#0011223344556677\n" for i in range(50)), encoding="utf-8"
    )
    why = "no numbers could be read: the log holds 1 CAN identifier"
    assert one_line(inside("analyze", log, "--out", tmp_path / "out"), log, why, "--dbc")
    absent = tmp_path / "absent.dbc"
    assert one_line(inside("analyze", log, "--dbc", absent), f"{absent}: no such file")


@pytest.mark.parametrize(
    ("option", "text", "words"),
    [
        ("--vehicle", "[vehicle]\nmas_kg = 1\n", ("mas_kg", "mass_kg")),
        ("--vehicle", "[vehicle\n", ("not valid TOML",)),
        ("--vehicle", None, ("cannot be read (No such file",)),
        ("--settings", "[roll_mop]\n", ("[roll_mop]", "did you mean 'roll_map'?")),
        ("--settings", "[roll_map]\ndraw = 3\n", ("[roll_map] draw", "did you mean 'draws'?")),
        ("--settings", "[roll_map]\ndraws = 3\n", ("found 3, expected 1000 to",)),
        ("--settings", "[roll_map]\ndraws = true\n", ("found True, expected a finite number",)),
        ("--settings", "roll_map = 1\n", ("is no table",)),
        ("--settings", "a = " + "[" * 5000, ("not valid TOML",)),
        ("--settings", None, ("cannot be read (No such file",)),
        ("--map", "[signals.roll]\nchannel = 3\n", ("channel must be a text, found 3",)),
        ("--map", None, ("cannot be opened (No such file",)),
    ],
)
def test_a_wrong_file_beside_the_log(inside, drive, tmp_path, option, text, words):
    path = tmp_path / "wrong.toml"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    run = inside("analyze", drive, option, path, "--out", tmp_path / "out")
    assert one_line(run, path, *words)
    assert not (tmp_path / "out").exists()


def test_names_that_are_unknown(inside, drive, tmp_path):
    run = inside("analyze", drive, "--estimators", "rol_map", "--out", tmp_path / "out")
    assert one_line(run, "there is no estimator 'rol_map'; did you mean 'roll_map'?", code=2)
    run = inside("analyze", drive, "--estimators", ",")
    assert one_line(run, "--estimators names none", "roll_map", code=2)
    run = inside("analyze", drive, "--format", "html,docx", "--out", tmp_path / "out")
    assert one_line(run, "unknown format 'docx'", "html, pdf, json", code=2)


@pytest.mark.parametrize("command", ["analyze", "convert"])
def test_a_folder_that_cannot_be_written_is_said_before_the_work(
    inside, drive, tmp_path, monkeypatch, command
):
    monkeypatch.setattr(parsers.load, "load_drive", lambda *_: pytest.fail("the log was read"))
    monkeypatch.setattr(parsers.convert, "convert_logs", lambda *_: pytest.fail("the log was read"))
    assert one_line(inside(command, drive, "--out", drive), drive, "is a file", "--out")
    assert one_line(inside(command, drive, "--out", drive / "deep" / "er"), drive, "is a file", "--out")
    if os.geteuid() != 0:
        tmp_path.chmod(0o500)
        assert one_line(inside(command, drive, "--out", tmp_path / "out"), "no permission to write", "--out")
        tmp_path.chmod(0o700)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a folder in which nobody can write")
def test_a_folder_in_which_nobody_can_write(inside, drive):
    assert one_line(inside("convert", drive, "--out", "/proc/self/out"), "/proc/self/out", "--out")
    run = inside("inspect", drive, "--write-map", "/proc/self/map.toml")
    assert one_line(run, "/proc/self/map.toml: cannot be written")


def test_a_report_of_what_is_none(inside, tmp_path):
    assert one_line(inside("report", tmp_path / "absent"), tmp_path / "absent", "no stored results")
    (tmp_path / "results.archive.json").write_text("{", encoding="utf-8")
    assert one_line(inside("report", tmp_path), "not whole JSON", "run `cogest analyze` again")


def test_text_of_a_log_cannot_steer_the_terminal(inside, tmp_path):
    log = tmp_path / "a\n\x1b[31mred\x07 \u202e.csv"
    log.write_text("x", encoding="utf-8")
    run = inside("analyze", log)
    assert one_line(run, "?[31mred?")
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f\u202e]", run.err)


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError(), 1, "not enough memory")],
)
def test_interrupts_and_a_full_memory_have_no_traceback(
    inside, drive, tmp_path, monkeypatch, error, code, words
):
    def fail(*_):
        raise error

    monkeypatch.setattr(parsers.convert, "convert_logs", fail)
    run = inside("convert", drive, "--out", tmp_path / "out")
    assert (run.code, run.out) == (code, "")
    assert run.err.startswith(f"cogest: {words}")
    assert run.err.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("analyse",),
        ("analyze",),
        ("analyze", "log.csv", "--seed", "-1"),
        ("analyze", "log.csv", "--sed", "1"),
        ("convert", "log.csv"),
        ("report",),
        ("inspect", "one.csv", "two.csv"),
    ],
)
def test_wrong_usage_is_code_2(inside, arguments):
    assert inside(*arguments).code == 2
