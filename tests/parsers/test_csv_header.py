"""Headers of text tables: their rows, names and units."""

from __future__ import annotations

from pathlib import Path

import pytest
from csv_tables import T, read
from hypothesis import given
from hypothesis import strategies as st

from parsers.errors import LogError
from parsers.importer import ReadOptions
from parsers.load import load_drive
from parsers.registry import find_importer
from parsers.table_names import ColumnName, split_header, unique_names
from parsers.unit_words import is_unit


def test_motec_style_preamble_and_unit_row(tmp_path: Path) -> None:
    text = (
        '"Format","MoTeC CSV File",,,"Workbook",""\n"Venue","Track",,,"Worksheet",""\n"Sample Rate","100.000","Hz",,,\n\n'
        '"Time","Ground Speed","G Force Lat","Gear","Beacon","Comment"\n"s","km/h","G","","",""\n\n\n'
        '"0.000","36.0","0.51","2","",""\n"0.010","36.1","0.52","2","",""\n"0.020","36.2","0.53","2","",""\n'
    )
    table = read(tmp_path, text)
    assert table.columns["Ground Speed"].tolist() == [36.0, 36.1, 36.2]
    assert table.info["Ground Speed"].unit == "km/h"
    assert table.info["G Force Lat"].unit == "G"
    assert table.time.tolist() == T[:3]


def test_a_row_of_units_that_contradicts_the_names_is_said(tmp_path: Path) -> None:
    head = "Time [s],Speed [km/h],Accel X [g],Accel Y [m/s2],accel_z_g,Brake [bar],Gear [-]\ns,mph,m/s2,m/s²,g,km/h,-\n"
    table = read(tmp_path, head + "".join(f"{0.1 * k:.1f},1,2,3,4,5,6\n" for k in range(5)))
    assert table.info["Speed"].unit == "mph"
    assert (
        "(Speed [km/h] over mph, Accel X [g] over m/s2, Brake [bar] over km/h): the row's are taken"
        in table.said
    )
    agreed = read(
        tmp_path,
        head.replace("mph,m/s2", "kph,G").replace("km/h,-", "bar,-") + "0,1,2,3,4,5,6\n0.1,1,2,3,4,5,6\n",
    )
    assert "row of units" not in agreed.said


def test_three_header_rows(tmp_path: Path) -> None:
    text = (
        "This file was made by a phone\nFormat,3\n\ntimestamp,speed,lateral_acc\nunix time,m/s,G\n,100: gps,calc\n"
        "1681400000.100,10.5,0.1\n1681400000.200,10.6,0.2\n1681400000.300,10.7,0.3\n"
    )
    table = read(tmp_path, text)
    assert table.reader.absolute
    assert table.time.tolist() == [1681400000_100000000 + k * 100_000_000 for k in range(3)]
    assert table.info["lateral_acc"].unit == "G"


def test_repeated_and_missing_names(tmp_path: Path) -> None:
    table = read(tmp_path, "t,a,a,,a_2\n0,1,2,3,4\n1,5,6,7,8\n2,9,9,9,9\n")
    assert {name: values[0] for name, values in table.columns.items()} == {
        "a": 1,
        "a_3": 2,
        "column_4": 3,
        "a_2": 4,
    }
    assert "'a' is repeated" in table.said


def test_comma_inside_header_brackets(tmp_path: Path) -> None:
    table = read(tmp_path, "t,pos(x,y),v\n0,1,2\n1,3,4\n2,5,6\n")
    assert table.columns["pos(x,y)"].tolist() == [1, 3, 5]
    assert table.columns["v"].tolist() == [2, 4, 6]
    assert "brackets" in table.said


ROWS = "".join(f"{k}.0,{k}.5,3,4,{k}.25,1\n" for k in range(12))


@pytest.mark.parametrize(
    "head",
    [
        "Time [s],Speed [km/h],1,2,Accel X [g],Gear",
        '"time","Accelerometer [m/s2]","1","2","lens","temperature"',
        "Time,Speed,1,2,Accel X,Gear\ns,km/h,1,1,g,1",
    ],
)
def test_some_names_may_be_digits(head: str, tmp_path: Path) -> None:
    table = read(tmp_path, f"{head}\n{ROWS}")
    assert {"1", "2"} <= {c.name for c in table.reader.channels}
    assert table.columns["1"].tolist() == [3.0] * 12
    assert "column_" not in table.said


@pytest.mark.parametrize("above", ["0.5,0.5,3,4,on,on", "start,12.5,ok,run,0.5,on", "1,2,3,4,5,x"])
def test_a_row_of_values_is_no_header(above: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="column_1") as raised:
        read(tmp_path, f"{above}\n# rows\n" + ROWS.replace(",", ".5,"))
    assert "and the rows 6" not in str(raised.value)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_line_ends_within_a_header_cell(end: str, tmp_path: Path) -> None:
    header = f'time,"ay{end}[m/s2]","yaw{end}rate [deg/s]"'
    table = read(tmp_path, f"{header}{end}" + "".join(f"{k},{k}.5,3{end}" for k in range(9)))
    assert [(c.name, c.unit) for c in table.reader.channels] == [("ay", "m/s2"), ("yaw rate", "deg/s")]
    assert table.columns["ay"].tolist() == [k + 0.5 for k in range(9)]
    assert not table.log.rejected


def test_a_quote_that_stands_for_inches_opens_no_cell(tmp_path: Path) -> None:
    table = read(tmp_path, 'tyre 18"\ntime,ay\n0,1\n1,2\n2,4\n3,"5"\n')
    assert table.columns["ay"].tolist() == [1, 2, 4, 5]


LVM = (
    "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n"
    "Date\t2024/03/05\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t4\t4\t\nX_Dimension\tTime\tTime\t\n"
    "Delta_X\t0,02\t0,02\t\n***End_of_Header***\t\t\t\nX_Value\tay\tspeed\tComment\n"
    + "".join(f"{k / 50:.6f}\t{k / 10}\t{10 + k / 10}\n" for k in range(40)).replace(".", ",")
)


def test_labview_measurement(tmp_path: Path) -> None:
    table = read(tmp_path, LVM, name="log.lvm")
    assert table.time.tolist() == [k * 20_000_000 for k in range(40)]
    assert table.columns["ay"].tolist() == [k / 10 for k in range(40)]
    assert table.columns["speed"].tolist() == [10 + k / 10 for k in range(40)]


@pytest.mark.parametrize(
    ("right", "wrong"), [("X_Columns\tOne", "X_Columns\tMulti"), ("Time\tTime", "Frequency\tTime")]
)
def test_labview_measurement_of_something_else_is_named(right: str, wrong: str, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"LabVIEW measurement file \(LVM\).*(Multi|Frequency)"):
        read(tmp_path, LVM.replace(right, wrong), name="log.lvm")


def test_latin1_units(tmp_path: Path) -> None:
    table = read(tmp_path, "t;Drehrate [°/s];T [°C]\n0;1,5;20\n0,5;2,5;20\n1;3,5;21\n".encode("latin-1"))
    assert table.info["Drehrate"].unit == "°/s"
    assert table.info["T"].unit == "°C"
    assert table.columns["Drehrate"].tolist() == [1.5, 2.5, 3.5]


def test_canonical_columns_keep_their_name_and_tell_their_unit(tmp_path: Path) -> None:
    table = read(
        tmp_path,
        "time_ns,accel_y_mps2,latitude_deg,satellites\n1400000000000000001,1,50,7\n1400000000010000002,2,50,7\n",
    )
    assert table.info["accel_y_mps2"].unit == "m/s²"
    assert table.info["latitude_deg"].unit == "deg"
    assert table.time.tolist() == [1400000000000000001, 1400000000010000002]
    assert table.reader.absolute


def test_a_separator_that_ends_every_row_makes_no_unknown_column(tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    rows = "".join(f"{k / 100},{k % 7},{0.1 * k},\n" for k in range(200))
    log.write_text("time_s,speed_mps,colour,\n" + rows)
    (said,) = (note for note in load_drive([log]).record.notes if "not recognised" in note)
    assert "colour (1 of" in said


def test_no_header(tmp_path: Path) -> None:
    table = read(
        tmp_path, "0.00,1.5,2\n0.01,1.6,3\n0.02,1.7,4\n", ReadOptions(time_channel="column_1", time_unit="s")
    )
    assert table.columns["column_2"].tolist() == [1.5, 1.6, 1.7]
    assert table.time.tolist() == T[:3]
    assert "no header" in table.said


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("AY [g]", "AY", "g"),
        ("ay (m/s^2)", "ay", "m/s^2"),
        ("speed_kmh", "speed_kmh", "km/h"),
        ("YawRate_deg/s", "YawRate_deg/s", "deg/s"),
        ("Time[s]", "Time", "s"),
        ("accel_y_mps2", "accel_y_mps2", "m/s²"),
        ("Speed, km/h", "Speed", "km/h"),
        ("v / km/h", "v", "km/h"),
        ("pose[3]", "pose[3]", None),
        ("pose[1]", "pose[1]", None),
        ("accelerometer_m_s2[1]", "accelerometer_m_s2[1]", None),
        ("Slip [1]", "Slip", "1"),
        ("accel (lateral)", "accel (lateral)", None),
        ("gears_s", "gears_s", None),
        ("", "", None),
    ],
)
def test_headers(header: str, name: str, unit: str | None) -> None:
    assert split_header(header) == ColumnName(header, name, unit)


@given(st.lists(st.sampled_from(["", "a", "b", "a_2", "a_2_2", "column_1"]), max_size=12))
def test_unique_names_are_unique_and_keep_what_was_unique(names: list[str]) -> None:
    result, repeated = unique_names([ColumnName(name, name) for name in names])
    assert len({column.name for column in result}) == len(names)
    for name, column in zip(names, result, strict=True):
        if name and names.count(name) == 1 and "" not in names:
            assert column.name == name
    assert set(repeated) == {name for name in names if name and names.count(name) > 1}


def test_units_are_told_from_names() -> None:
    assert all(is_unit(text) for text in ("g", "[m/s²]", "km/h", "°C", "%", "rpm", "deg/s"))
    assert not any(is_unit(text) for text in ("", "lateral", "X", "front left"))


@pytest.mark.parametrize(
    "head",
    [
        "timestamp,arbitration_id,extended,remote,error,dlc,data\n1.0,0xa1,0,0,0,2,AAA=\n1.1,0xa1,0,0,0,2,AAA=\n",
        "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2\n1,0000A1,false,Rx,0,2,1,2\n2,0000A1,false,Rx,0,2,1,2\n",
    ],
)
def test_a_table_of_can_frames_is_refused_with_the_way_on(tmp_path: Path, head: str) -> None:
    with pytest.raises(LogError, match=r"raw CAN frames.*logconvert"):
        read(tmp_path, head)


def test_a_row_of_number_types_is_no_header(tmp_path: Path) -> None:
    head = "ETASAsciiItemFile\trecord\n\ntime\tv\\ETKC:1\tr\\ETKC:1\nf8\tf8\ti4\ns\tkm/h\tdeg/s\n"
    rows = "".join(f"{k / 100:.2f}\t{k}.5\t{k}\n" for k in range(9))
    found = read(tmp_path, head + rows)
    assert [(c.name, c.unit) for c in found.reader.channels] == [
        ("v\\ETKC:1", "km/h"),
        ("r\\ETKC:1", "deg/s"),
    ]


@pytest.mark.parametrize(
    ("text", "tool"),
    [
        (
            "***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n" + "8:0:0:0000 Rx 1 0x100 s 2 D0 FF\n" * 5,
            "BUSMASTER",
        ),
        ("# Kvaser Memorator log\nTime,Channel,ID,Flags,DLC,D0,D1\n" + "0.0,1,256,0,2,1,2\n" * 5, "Kvaser"),
        ("Vehicle Spy 3 Log\nLine,Abs Time(Sec),Arb ID,B1,B2\n" + "1,0.0,100,D0,FF\n" * 5, "Vehicle Spy"),
        ("# Logger type: CL2000\nTimestamp;Type;ID;Data\n" + "23T080000000;0;100;d0ff\n" * 5, "CL2000"),
        ("Time;Chn;ID;Event Type;DLC;Data\n" + "0.0;CAN 1;100;CAN Frame;2;D0 FF\n" * 5, "CANoe"),
    ],
)
def test_text_logs_of_can_frames_are_called_what_they_are(tmp_path: Path, text: str, tool: str) -> None:
    with pytest.raises(LogError, match=f"raw CAN frames as text of.*{tool}.*BLF, ASC"):
        read(tmp_path, text)
    path = tmp_path / "x.log"
    path.write_text(text)
    assert find_importer(path).name == "csv"


def test_descriptions_below_the_names(tmp_path: Path) -> None:
    text = "Time,Speed,AccY\nTime since start,Vehicle speed from wheels,Lateral acceleration\n"
    table = read(tmp_path, text + "".join(f"{k / 10},{k},1.5\n" for k in range(20)))
    assert set(table.info) == {"Speed", "AccY"}
    assert "the names are those of the row above it" in table.said
