"""J1939 on CAN FD (J1939-22): frames of several parameter groups, and messages in packets of 60 bytes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from can_rows import open_rows, read_all, result
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from j1939_packets import EC1, LONG, MINE, Row, ec1, last_byte, lost, packets, timed

from parsers.can.contained_kernel import MOST_GROUPS
from parsers.can.frames import EXTENDED

EEC, DIRECTED = 0xF100, 0xEF00
SHORT = f"""VERSION ""

BU_: X

BO_ {0x98F100FE} Four: 4 X
 SG_ Speed : 0|16@1+ (0.1,0) [0|0] "" X
 SG_ Last : 24|8@1+ (1,0) [0|0] "" X

BO_ {0x98F200FE} Three: 3 X
 SG_ Yaw : 0|16@1- (0.01,0) [0|0] "" X

BO_ {0x98EF00FE} Mine: 40 X
 SG_ Far : 304|16@1+ (1,0) [0|0] "" X

"""
LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def group(pgn: int, payload: bytes, service: int = 2, trailer: int = 0) -> bytes:
    return (
        bytes([service << 5 | trailer << 2 | pgn >> 16, pgn >> 8 & 0xFF, pgn & 0xFF, len(payload)]) + payload
    )


def padded(data: bytes) -> bytes:
    """To the next length of an FD frame: a header of nothing, then AA."""
    room = next(n for n in LENGTHS if n >= len(data))
    return (data + b"\0\0\0").ljust(room, b"\xaa")[:room]


def frame(*groups: bytes, sender: int = 0x31, to: int = 255, priority: int = 3) -> tuple[int, bytes]:
    return priority << 26 | 0x250000 | to << 8 | sender | EXTENDED, padded(b"".join(groups))


def announce(size: int, pgn: int, session: int, control: int, sender: int, to: int) -> tuple[int, bytes]:
    head = (
        bytes([session << 4 | control]) + size.to_bytes(3, "little") + (-(-size // 60)).to_bytes(3, "little")
    )
    return 0x1C4D0000 | to << 8 | sender | EXTENDED, padded(head + b"\xff\0" + pgn.to_bytes(3, "little"))


def fd_packets(
    payload: bytes, pgn: int = MINE, session: int = 0, sender: int = 0, to: int = 255
) -> list[tuple[int, bytes]]:
    """Announcement, packets and the sender's last word; to all (BAM), or to one (RTS, without its answers)."""
    rows = [announce(len(payload), pgn, session, 4 if to == 255 else 0, sender, to)]
    for k in range(-(-len(payload) // 60)):
        part = bytes([session << 4]) + (k + 1).to_bytes(3, "little") + payload[60 * k : 60 * k + 60]
        rows.append((0x1C4E0000 | to << 8 | sender | EXTENDED, padded(part)))
    return [*rows, announce(len(payload), pgn, session, 2, sender, to)]


def test_known_answer_of_two_groups_in_a_frame(tmp_path: Path) -> None:
    """Headers 40 F1 00 04 and 40 F2 00 03 to all, from 0x31: 15 bytes, padded to 16."""
    text = "40F1000410270005" + "40F2000338FF00" + "00"
    rows: list[Row] = [(7, 0x0C25FF31 | EXTENDED, 1, bytes.fromhex(text))]
    assert (
        frame(group(EEC, bytes.fromhex("10270005")), group(0xF200, bytes.fromhex("38FF00"))) == rows[0][1::2]
    )
    reader, log = open_rows(tmp_path, rows, SHORT)
    got = read_all(reader)
    assert got["Four.Speed"] == ([7], [1000.0])
    assert got["Four.Last"] == ([7], [5.0])
    assert got["Three.Yaw"] == ([7], [-2.0])
    assert "J1939-22: 1 CAN FD frames were taken apart to 2 parameter groups" in log.notes
    assert not any("in no database" in note for note in log.notes)
    assert reader.channels[0].tags["pgn"] == "61696"


def test_the_builtin_messages_are_known_in_them(tmp_path: Path) -> None:
    """EBC2's front axle speed of 1/256 km/h, beside a group that nobody knows."""
    rows = timed([frame(group(0xFEBF, bytes([0, 40, *[125] * 6])), group(0xFE00, bytes(12)))] * 3)
    reader, _ = open_rows(tmp_path, rows)
    got = read_all(reader)
    (name,) = [each for each in got if "FrontAxleSpeed" in each.replace("_", "")]
    assert got[name][1] == [40.0] * 3


def test_groups_to_one_address_and_a_long_one(tmp_path: Path) -> None:
    payload = bytes(38) + (1234).to_bytes(2, "little")
    rows = timed(
        [frame(group(DIRECTED, payload), sender=3, to=40), frame(group(DIRECTED, payload), sender=4, to=41)]
    )
    reader, _ = open_rows(tmp_path, rows, SHORT)
    assert {name: column[1] for name, column in read_all(reader).items()} == {
        "Mine.Far": [1234.0],
        "Mine.Far@sa4": [1234.0],
    }


def test_frames_of_many_groups(tmp_path: Path) -> None:
    empty = frame(*[group(0xF300, b"")] * MOST_GROUPS)
    most = frame(*[group(EEC, bytes([k, 0, 0, k])) for k in range(8)])
    reader, log = open_rows(tmp_path, timed([empty, most, empty]), SHORT)
    assert read_all(reader)["Four.Last"][1] == [float(k) for k in range(8)]
    assert "J1939-22: 3 CAN FD frames were taken apart to 40 parameter groups" in log.notes


def test_assurance_data_and_other_services_end_a_frame_and_are_counted(tmp_path: Path) -> None:
    good = group(EEC, bytes(4))
    rows = timed([frame(good, group(EEC, bytes(4), trailer=1), good), frame(good, group(EEC, bytes(4), service=1)), frame(good)])  # fmt: skip
    reader, log = open_rows(tmp_path, rows, SHORT)
    assert len(read_all(reader)["Four.Last"][1]) == 3
    assert (
        log.rejected[
            "J1939-22 frame with assurance data or another service than J1939's, not read from there on"
        ]
        == 2
    )


def test_frames_that_are_not_laid_out_so_give_nothing(tmp_path: Path) -> None:
    good = group(EEC, bytes(4))
    beyond = (0x0C25FF31 | EXTENDED, (good + bytes([0x40, 0xF1, 0, 60])).ljust(16, b"\1"))
    addressed = frame(good, group(0xEF01, bytes(4)))
    reader, log = open_rows(tmp_path, timed([beyond, addressed, frame(good)]), SHORT)
    assert len(read_all(reader)["Four.Last"][1]) == 1
    assert log.rejected["J1939-22 frame whose parameter groups do not fill it"] == 2
    # of another protocol nothing is said
    classic = [(0x0C25FF31 | EXTENDED, bytes([first] * 8)) for first in range(256)]
    _, log = open_rows(tmp_path, timed([beyond, (0x0C25FF31 | EXTENDED, b"\x60"), *classic]), SHORT)
    assert not any("J1939-22" in each for each in (*log.notes, *log.rejected))


def test_a_broadcast_in_fd_packets(tmp_path: Path) -> None:
    payload = np.random.default_rng(3).integers(0, 250, 1785, dtype=np.uint8).tobytes()
    reader, log = open_rows(tmp_path, timed(fd_packets(payload)), LONG)
    got = read_all(reader)
    assert got["Mine.Far"][1] == [float(payload[14272 // 8])]
    # with the last packet's stamp, and not with that of the sender's last word
    assert got["Mine.Far"][0] == [30 * 10_000_000]
    assert lost(log) == {}
    assert any("1 message was put together" in note for note in log.notes)


def test_sessions_of_one_sender_and_classic_packets_keep_apart(tmp_path: Path) -> None:
    many = [fd_packets(ec1(k), EC1, session=k) for k in range(4)] + [packets(ec1(100))]
    rows = [each[k] for k in range(7) for each in many if k < len(each)]
    reader, log = open_rows(tmp_path, timed(rows), LONG)
    assert sorted(read_all(reader)["EC1.Last"][1]) == sorted(last_byte(k) for k in (0, 1, 2, 3, 100))
    assert lost(log) == {}


def test_a_message_to_one_whose_receiver_asks_again_and_breaks_off(tmp_path: Path) -> None:
    payload = bytes(range(250)) + bytes(1535)
    sent = fd_packets(payload, sender=3, to=40, session=5)
    asked = announce(1785, MINE, 5, 1, 40, 3)
    # the receiver lacks packet 3, and asks for it after the sender's last word
    rows = [*sent[:3], *sent[4:], asked, sent[3], announce(1785, MINE, 5, 3, 40, 3)]
    broken = [*sent[:9], announce(1785, MINE, 5, 15, 40, 3)]
    reader, log = open_rows(tmp_path, timed(rows, broken), LONG)
    assert len(read_all(reader)["Mine.Far"][1]) == 1
    assert lost(log) == {"Mine: J1939 message in packets, broken off by sender or receiver": 1}


@pytest.mark.parametrize("drop", [0, 3])
def test_a_lost_packet_and_a_lost_announcement(tmp_path: Path, drop: int) -> None:
    whole, torn = fd_packets(bytes(300)), fd_packets(bytes(300))
    del torn[drop]
    reader, log = open_rows(tmp_path, timed(whole, torn, whole), LONG.replace("1785", "300"))
    assert len(read_all(reader)["Mine.First"][1]) == 2
    reason = "without its announcement" if drop == 0 else ", packets missing"
    assert [(reason in each, count) for each, count in lost(log).items()] == [(True, 1)]


def test_what_is_longer_than_any_message_is_counted(tmp_path: Path) -> None:
    reader, log = open_rows(tmp_path, timed(fd_packets(bytes(5000)), fd_packets(bytes(1785))), LONG)
    assert len(read_all(reader)["Mine.First"][1]) == 1
    # its packets are of no announcement that is held
    assert lost(log)["Mine: J1939 message in packets, longer than 1785 bytes"] == 1


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32))
def test_damaged_frames_give_what_was_sent_and_the_same_twice(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    queues = [[frame(group(EEC, rng.bytes(4))) for _ in range(9)] for _ in range(2)]
    queues += [
        fd_packets(bytes(rng.integers(0, 250, 39, dtype=np.uint8)), EC1, session=k, sender=k)
        for k in range(4)
    ]
    rows = []
    while any(queues):
        rows.append(queues[int(rng.choice([k for k, each in enumerate(queues) if each]))].pop(0))
    rows = [(can_id, data[: int(rng.integers(0, 65))] if rng.random() < 0.1 else data) for can_id, data in rows if rng.random() > 0.03]  # fmt: skip
    first = result(*open_rows(tmp_path, timed(rows, step=1_000_000), SHORT, LONG.replace("Mine", "Far")))
    assert first == result(
        *open_rows(tmp_path, timed(rows, step=1_000_000), SHORT, LONG.replace("Mine", "Far"))
    )
