"""The start that a table's head states, and tables in code pages of other scripts."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest
from csv_tables import read

from parsers.code_pages import code_page
from parsers.importer import ImportLog
from parsers.table_preamble import stated_start
from parsers.table_rows import RowRules

RULES = RowRules(ord(","), 4, 4)


def _ns(moment: datetime) -> int:
    log = ImportLog()
    log.began(moment)
    assert log.local_start_ns is not None
    return log.local_start_ns


@pytest.mark.parametrize(
    ("date", "time", "moment"),
    [
        ('"Log Date","15/03/2024",,,"Origin Time","0.000"', '"Log Time","14:05:22",,,"Start Time","0"', datetime(2024, 3, 15, 14, 5, 22)),
        ('"Date","Saturday, March 16, 2024"', '"Time","2:05 PM"', datetime(2024, 3, 16, 14, 5)),
        ("Date,Saturday, March 16, 2024", "Time,12:05 AM", datetime(2024, 3, 16, 0, 5)),
        ("Log Date,03/04/2024", "Log Time,14:05:22.5", datetime(2024, 4, 3, 14, 5, 22, 500000)),
        ("Log Date,3/4/2024", "Log Time,2:05:22 PM", datetime(2024, 3, 4, 14, 5, 22)),
        ("Date:,2024-03-16", "Time:,14:05:22", datetime(2024, 3, 16, 14, 5, 22)),
    ],
)  # fmt: skip
def test_a_stated_start(date: str, time: str, moment: datetime) -> None:
    found = stated_start(f'"Format","X"\n{date}\n{time}\n\n"Time","Speed"\n"s","km/h"\n', RULES)
    assert found is not None
    assert found[0] == moment


@pytest.mark.parametrize(
    "head",
    [
        "Date,morning\nTime,14:05:22\n",
        "Date,16/03/2024\n",
        "Time,Speed\n",
        "Date,31/02/2024\nTime,14:05:22\n",
        "",
    ],
)
def test_no_start_is_invented(head: str) -> None:
    assert stated_start(head, RULES) is None


def test_a_table_begins_when_its_head_says(tmp_path: Path) -> None:
    head = '"Log Date","15/03/2024",,\n"Log Time","14:05:22",,\n\n"Time","Speed","A"\n"s","km/h","g"\n'
    rows = "".join(f'"{k / 50:.3f}","{k}","0"\n' for k in range(100))
    table = read(tmp_path, head + rows)
    assert table.log.local_start_ns == _ns(datetime(2024, 3, 15, 14, 5, 22))
    assert not table.log.zone_known
    assert "stamps count from 2024-03-15 14:05:22" in table.said


JAPANESE = "時間 [s],車速 [km/h],前後加速度 [g],ヨーレート [deg/s]\n"
CHINESE = "时间 [s],车速 [km/h],纵向加速度 [g],横摆角速度 [deg/s]\n"
RUSSIAN = "Время [s],Скорость [km/h],Ускорение X [g],Рыскание [deg/s]\n"


@pytest.mark.parametrize(
    ("header", "codec", "second"),
    [
        (JAPANESE, "cp932", "車速"),
        (JAPANESE, "utf-8", "車速"),
        (CHINESE, "gb18030", "车速"),
        (RUSSIAN, "cp1251", "Скорость"),
    ],
)
def test_letters_of_other_scripts(tmp_path: Path, header: str, codec: str, second: str) -> None:
    table = read(tmp_path, (header + "".join(f"{k / 50},{k},0.5,1\n" for k in range(100))).encode(codec))
    assert table.time[-1] == 99 * 20_000_000
    assert table.columns[second][:2].tolist() == [0.0, 1.0]
    assert table.info[second].unit == "km/h"


@pytest.mark.parametrize(
    "text",
    [
        "Zeit [s];Längsbeschleunigung [m/s²];Gierrate [°/s];Übersteuern;Größe;µ\n",
        "Temps;Vitesse;Accélération latérale;Tangage [°];à é è ê ç œ …\n",
        "t;“quoted” – µm ±°²³ ½ Å Ø Æ å ø æ\n",
        "Tid;Hastighet;Längsacc;Sidoacc;Girvinkelhastighet [°/s];Ä Ö Å\n",
    ],
)
def test_western_letters_stay_so(text: str) -> None:
    assert code_page(text.encode("cp1252")) == "cp1252"
    assert code_page(3 * text.encode("cp1252") + b"0;1;2;3\n") == "cp1252"
