"""Bus logging without a BusChannel: groups of different acquisition sources are different buses."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from mf4_files import Builder, frames_of, opened
from mf4_logs import opened as opened_log
from mf4_logs import read_all

DBC = """VERSION ""

BU_: X

BO_ 256 A: 8 X
 SG_ a : 0|16@1- (1,0) [0|0] "m/s2" X
"""


def buses(*sources: tuple[str, str] | None, named: tuple[int, ...] = ()) -> Builder:
    """One group of ten frames for each source (name, path; None for no source). named: groups that have a BusChannel, 7."""
    b = Builder()
    for number, source in enumerate(sources):
        follower = f"dg{number + 1}" if number + 1 < len(sources) else ""
        b.data_group(f"dg{number}", f"cg{number}", f"dt{number}", after=follower)
        b.group(f"cg{number}", f"t{number}", 22, cycles=10, flags=6)
        if source is not None:
            texts = [b.text(words) for words in source]
            b.add(f"si{number}", "SI", [*texts, ""], struct.pack("<BBB5x", 2, 2, 0))
            kind, links, data = b.blocks[f"cg{number}"]
            b.blocks[f"cg{number}"] = (kind, [*links[:3], f"si{number}", *links[4:]], data)
        b.channel(
            "t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), key=f"t{number}", after=f"f{number}"
        )
        b.channel("CAN_DataFrame", 8, 112, data_type=10, parts=f"i{number}", key=f"f{number}", flags=0x400)
        b.channel("CAN_DataFrame.ID", 8, 29, key=f"i{number}", after=f"l{number}")
        b.channel("CAN_DataFrame.DataLength", 12, 8, key=f"l{number}", after=f"d{number}")
        last = f"b{number}" if number in named else ""
        b.channel("CAN_DataFrame.DataBytes", 14, 64, data_type=10, key=f"d{number}", after=last)
        b.channel("CAN_DataFrame.BusChannel", 13, 8, key=f"b{number}")
        rows = [struct.pack("<QIBBhhI", k, 0x100, 8, 7, number * 100 + k, 0, 0) for k in range(10)]
        b.add(f"dt{number}", "DT", [], b"".join(rows))
    b.header("dg0")
    return b


@pytest.mark.parametrize(
    ("sources", "expected"),
    [
        ([("CAN1", "CAN1"), ("CAN2", "CAN2")], [1, 2]),
        ([("CAN2", ""), ("CAN4", "")], [2, 4]),
        ([("CAN", "Bus/CAN3"), ("CAN", "Bus/CAN5")], [3, 5]),
        ([("Chassis", "x"), ("Body", "x")], [1, 2]),
        ([("Unit1", "CAN8"), ("Unit1", "CAN9")], [8, 9]),
        # the same number twice: their order
        ([("CAN1 left", ""), ("CAN1 right", "")], [1, 2]),
        # groups of one source are one bus
        ([("CAN1", "a"), ("CAN2", "a"), ("CAN1", "a")], [1, 2, 1]),
        ([("CAN2", ""), ("CAN2", "")], [1, 1]),
        ([("CAN1", ""), None], [1, 2]),
        ([None, None], [1, 1]),
    ],
)
def test_the_bus_of_each_source(
    tmp_path: Path, sources: list[tuple[str, str] | None], expected: list[int]
) -> None:
    reader, log = opened(tmp_path / "a.mf4", buses(*sources).build())
    got = frames_of(reader)
    assert [bus for _, _, bus, _ in got[::10]] == expected
    assert any("acquisition source" in note for note in log.notes) == (len(set(expected)) > 1)


def test_a_bus_that_the_frames_name_stays(tmp_path: Path) -> None:
    reader, _ = opened(tmp_path / "a.mf4", buses(("CAN1", ""), ("CAN2", ""), named=(0,)).build())
    assert [bus for _, _, bus, _ in frames_of(reader)[::10]] == [7, 2]


def test_signals_of_two_buses_are_two_channels(tmp_path: Path) -> None:

    path, dbc = tmp_path / "a.mf4", tmp_path / "a.dbc"
    path.write_bytes(buses(("CAN1", "CAN1"), ("CAN2", "CAN2")).build())
    dbc.write_text(DBC, encoding="ascii")
    reader, _ = opened_log(path, dbc)
    got = read_all(reader)
    assert {name: values.tolist() for name, (_, values) in got.items()} == {
        "A.a": [float(k) for k in range(10)],
        "A.a@bus2": [100.0 + k for k in range(10)],
    }
