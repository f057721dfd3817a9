"""J1939 in the shared CAN reader: matched by group number, with and without a database."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from can_rows import Listed, open_rows, read_all

from parsers.can.frames import EXTENDED
from parsers.can.reader import CanReader
from parsers.importer import ImportLog, ReadOptions
from parsers.mapping import propose

REAL = Path(__file__).resolve().parents[3] / "shared" / "real_logs"


def j1939_rows(can_id: int, values: list[int], start: int = 0) -> list[tuple[int, int, int, bytes]]:
    """CCVS1-like frames: 16 bits in bytes 2-3."""
    return [
        (start + i, can_id | EXTENDED, 1, b"\xff" + v.to_bytes(2, "little") + b"\xff" * 5)
        for i, v in enumerate(values)
    ]


def test_j1939_by_group_number_whatever_priority_and_sender(tmp_path: Path) -> None:
    dbc = (REAL / "truck_j1939.dbc") if (REAL / "truck_j1939.dbc").exists() else None
    if dbc is None:
        pytest.skip("shared/real_logs is not beside the repository")
    rows = j1939_rows(0x0CFEF100, [256, 512]) + j1939_rows(0x18FEF121, [256 * 9, 0xFFFF, 0xFE12, 0], 10)
    log = ImportLog()
    reader = CanReader(Listed(rows, log), ReadOptions(dbc=(dbc,)), log, tmp_path)
    plain, other = reader.channels
    assert (plain.name, plain.tags["source_address"], plain.count) == (
        "CCVS1.WheelBasedVehicleSpeed",
        "33",
        4,
    )
    assert (other.name, other.tags["source_address"]) == ("CCVS1.WheelBasedVehicleSpeed@sa0", "0")
    assert {key: plain.tags[key] for key in ("pgn", "spn", "extended", "id")} == {
        "pgn": "65265", "spn": "84", "extended": "1", "id": str(0x18FEF121),
    }  # fmt: skip
    got = read_all(reader)
    assert got["CCVS1.WheelBasedVehicleSpeed@sa0"] == ([0, 1], [1.0, 2.0])
    assert np.array_equal(got["CCVS1.WheelBasedVehicleSpeed"][1], [9.0, np.nan, np.nan, 0.0], equal_nan=True)
    assert dict(log.rejected) == {
        "CCVS1.WheelBasedVehicleSpeed: not available": 1,
        "CCVS1.WheelBasedVehicleSpeed: error indicator": 1,
    }
    assert any("source address 33 (4 frames)" in note for note in log.notes)


def test_builtin_j1939_without_a_database(tmp_path: Path) -> None:
    payload = (32125).to_bytes(2, "little") + b"\x20" + (32113).to_bytes(2, "little")
    payload += (32127).to_bytes(2, "little") + b"\x7d"
    reader, log = open_rows(tmp_path, [(5, 0x18F0090B | EXTENDED, 1, payload)])
    got = {name: values[1][0] for name, values in read_all(reader).items()}
    assert got["VDC2.SteeringWheelAngle"] == pytest.approx(32125 / 1024 - 31.374, abs=1e-12)
    assert got["VDC2.YawRate"] == pytest.approx(32113 / 8192 - 3.92, abs=1e-12)
    assert got["VDC2.LateralAcceleration"] == pytest.approx(32127 / 2048 - 15.687, abs=1e-12)
    assert got["VDC2.LongitudinalAcceleration"] == pytest.approx(0.0, abs=1e-12)
    assert any("own J1939 definitions" in note and "VDC2" in note for note in log.notes)


def test_pdu1_ignores_the_destination(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x8C0000FE} TSC1: 8 X\n SG_ S : 8|8@1+ (1,0) [0|0] "" X\n'
    rows = [(0, 0x0C000003 | EXTENDED, 1, bytes([0, 7])), (1, 0x0C00FF03 | EXTENDED, 1, bytes([0, 8]))]
    reader, _ = open_rows(tmp_path, rows, dbc)
    assert read_all(reader) == {"TSC1.S": ([0, 1], [7, 8])}
    assert reader.channels[0].tags["pgn"] == "0"


def test_plain_29_bit_ids_are_not_taken_for_j1939(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x92DD54D2} Own: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n'
    rows = [(0, 0x12DD54D2 | EXTENDED, 1, b"\xff"), (1, 0x12DD54D3 | EXTENDED, 1, b"\x01")]
    reader, log = open_rows(tmp_path, rows, dbc)
    assert read_all(reader) == {"Own.S": ([0], [255])}
    assert "pgn" not in reader.channels[0].tags
    assert any("1 of 2 CAN identifiers" in note for note in log.notes)


def test_known_group_in_a_database_without_attributes_is_j1939(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x98FEF100} C: 8 X\n SG_ V : 8|16@1+ (1,0) [0|0] "" X\n'
    reader, _ = open_rows(tmp_path, j1939_rows(0x18FEF100, [5, 0xFFFF]), dbc)
    assert np.array_equal(read_all(reader)["C.V"][1], [5, np.nan], equal_nan=True)
    assert reader.channels[0].tags["pgn"] == "65265"
    # the same group from another sender than the database's
    reader, log = open_rows(tmp_path, j1939_rows(0x18FEF121, [5, 0xFFFF]), dbc)
    assert reader.channels[0].tags["source_address"] == "33"
    assert any("matched by J1939 parameter group" in note for note in log.notes)


def test_an_id_ending_in_fe_that_is_called_plain_is_one_where_the_log_holds_it(tmp_path: Path) -> None:
    dbc = (
        f'VERSION ""\n\nBU_:\n\nBO_ {0x98DD54FE} Own: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n\n'
        'BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","J1939PG";\n'
        f'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";\nBA_ "VFrameFormat" BO_ {0x98DD54FE} 1;\n'
    )
    rows = [(0, 0x18DD54FE | EXTENDED, 1, b"\xff"), (1, 0x18DD54D3 | EXTENDED, 1, b"\x01")]
    reader, _ = open_rows(tmp_path, rows, dbc)
    assert read_all(reader) == {"Own.S": ([0], [255])}
    # a database that means a group and calls its frames extended all the same
    reader, _ = open_rows(tmp_path, rows[1:], dbc)
    assert read_all(reader) == {"Own.S": ([1], [1])}


def test_a_given_database_comes_before_the_built_in_definitions(tmp_path: Path) -> None:
    dbc = 'VERSION ""\n\nBU_:\n\nBO_ 256 Brake: 8 X\n SG_ VehSpd : 8|16@1+ (0.01,0) [0|0] "km/h" X\n'
    own, builtin = "Brake.VehSpd", "CCVS1.WheelBasedVehicleSpeed"
    rows = [(i, 256, 1, bytes(8)) for i in range(20)] + j1939_rows(0x18FEF100, [256] * 5, 20)
    reader, _ = open_rows(tmp_path, rows, dbc)
    assert [each.channels[0] for each in propose(reader.channels, None)["speed"]] == [own, builtin]
    # and a signal that only these define stays theirs
    unused = dbc.replace("VehSpd", "Other")
    reader, _ = open_rows(tmp_path, rows, unused)
    assert [each.channels[0] for each in propose(reader.channels, None)["speed"]] == [builtin]
    # the same group in the user's own database is the user's
    known = f'BO_ {0x98FEF1FE} CCVS1: 8 X\n SG_ WheelBasedVehicleSpeed : 8|16@1+ (1,0) [0|0] "km/h" X\n'
    reader, _ = open_rows(tmp_path, rows, f"{dbc}\n{known}")
    assert [each.channels[0] for each in propose(reader.channels, None)["speed"]] == [builtin, own]


@pytest.mark.parametrize(
    ("message", "signal"),
    [
        ("MyCCVS", "WheelBasedVehicleSpeed"),
        ("Cruise_Control_Vehicle_Speed_1", "wheel_based_vehicle_speed"),
        ("Cruise_Control_Vehicle_Speed_1", "VehSpd"),
    ],
)
def test_a_group_is_known_whatever_a_database_calls_it(tmp_path: Path, message: str, signal: str) -> None:
    dbc = (
        f'VERSION ""\n\nBU_:\n\nBO_ {0x98FEF1FE} {message}: 8 X\n'
        f' SG_ {signal} : 8|16@1+ (0.003906,0) [0|251] "km/h" X\n'
    )
    reader, _ = open_rows(tmp_path, j1939_rows(0x18FEF100, [256 * 36, 512]), dbc)
    name = f"{message}.{signal}"
    assert [channel.name for channel in reader.channels] == [name]
    assert propose(reader.channels, None)["speed"][0].channels == (name,)


def test_bits_of_another_scale_are_not_the_groups_signal(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x98FEF1FE} Own: 8 X\n SG_ Level : 8|16@1+ (0.5,0) [0|1] "km/h" X\n'
    reader, _ = open_rows(tmp_path, j1939_rows(0x18FEF100, [256, 512]), dbc)
    assert "speed" not in propose(reader.channels, None)


def test_a_number_by_chance_makes_no_group_of_a_plain_message(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x98FEF112} KINEMATICS: 8 X\n SG_ YAW_RATE : 0|12@1+ (0.25,0) [0|1] "deg/s" X\n'
    reader, _ = open_rows(tmp_path, j1939_rows(0x18FEF112, [256, 512]), dbc)
    assert reader.channels[0].tags["message"] == "KINEMATICS"
    assert "yaw_rate" in propose(reader.channels, None)
