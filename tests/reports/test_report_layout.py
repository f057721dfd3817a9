"""Text for terminals: cut names, tables that fit, and encodings that lack characters."""

from __future__ import annotations

import io

import pytest

from reports.layout import middle, never_fail, table, terminal_width, wrapped


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("ascii", "0.69 +- 0.02 m, 3-4 deg, 2.6 x 10^-7, ? ..."),
        ("latin-1", "0.69 ± 0.02 m, 3-4 °, 2.6 × 10^-7, ? ..."),
        ("cp1252", "0.69 ± 0.02 m, 3–4 °, 2.6 × 10^-7, ? …"),
        ("utf-8", "0.69 ± 0.02\u202fm, 3–4 °, 2.6 × 10⁻⁷, 车 …"),
    ],
)
def test_a_narrow_encoding_gets_plain_characters(encoding: str, shown: str) -> None:
    target = io.BytesIO()
    stream = io.TextIOWrapper(target, encoding=encoding, newline="\n")
    never_fail(stream)
    text = "0.69 ± 0.02\u202fm, 3–4 °, 2.6 × 10⁻⁷, 车 …"
    print(text.replace("°", "deg") if encoding == "ascii" else text, file=stream, flush=True)
    assert target.getvalue().decode(encoding) == shown + "\n"


def test_a_lone_surrogate_of_a_file_name_does_not_stop_the_program() -> None:
    target = io.BytesIO()
    stream = io.TextIOWrapper(target, encoding="utf-8")
    never_fail(stream)
    print("log\udcff.csv", file=stream, flush=True)
    assert target.getvalue() == b"log?.csv\n"


def test_a_long_name_keeps_its_end() -> None:
    assert middle("short", 12) == "short"
    cut = middle("/vehicle/wheel_odometry/twist.twist.linear.x", 20)
    assert len(cut) == 20
    assert cut.endswith("linear.x")
    assert cut.startswith("/vehic")


def test_sentences_hang_and_names_stay_whole() -> None:
    lines = wrapped("a sentence of some words with /one/very/long/name.that_is_wider_than_the_line", 30)
    assert lines[0].startswith("  a sentence")
    assert lines[-1] == "    /one/very/long/name.that_is_wider_than_the_line"


ROWS = [
    ["channel", "unit", "samples", "what"],
    ["speed", "m/s", "12", "-> speed"],
    ["/a/topic/with/a/long/name.and.a.long.field", "", "123456", "a reason of many words that takes more than a line"],
    ["/a/topic/with/a/long/name.and.a.text", "", "", "text"],
]  # fmt: skip


def test_a_table_fits_and_loses_no_name_of_its_first_column() -> None:
    lines = table(ROWS, 80, right=(2,), names=(0,))
    assert max(len(line) for line in lines) <= 80
    assert "/a/topic/with/a/long/name.and.a.long.field" in "\n".join(lines)
    narrow = table(ROWS, 64, right=(2,), names=(0,))
    assert "  /a/topic/with/a/long/name.and.a.long.field" in narrow
    assert "  /a/topic/with/a/long/name.and.a.text  text" in narrow
    head = next(line for line in narrow if "samples" in line)
    row = next(line for line in narrow if "123456" in line)
    assert row.index("123456") + 6 == head.index("samples") + 7


def test_the_width_is_the_terminals_within_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    for columns, width in (("40", 80), ("133", 133), ("900", 200)):
        monkeypatch.setenv("COLUMNS", columns)
        assert terminal_width() == width
