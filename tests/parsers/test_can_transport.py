"""J1939's transport protocol: messages in packets, put together from what many senders sent at once."""

from __future__ import annotations

from pathlib import Path

import cantools
import numpy as np
import pytest
from can_rows import open_rows, read_all, result
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from j1939_packets import EC1, LONG, MINE, announce, answer, ec1, last_byte, lost, packets, timed

from parsers.can.frames import EXTENDED
from parsers.can.transport_kernel import MOST_SESSIONS, TIMEOUT_NS


def test_known_answer_of_a_broadcast(tmp_path: Path) -> None:
    """BAM of EC1 as SAE J1939-21 lays it out: 39 bytes in six packets, the stamp is the last packet's."""
    frames = [
        "20270006FFE3FE00", "01A00F7D50C3407D", "02C8AF64000A0000", "0302030405060708", "04B80B0A11121314",
        "0515161718191A1B", "061C1D1E77FFFFFF",
    ]  # fmt: skip
    rows = [
        (k * 50_000_000, (0x18ECFF00 if k == 0 else 0x18EBFF00) | EXTENDED, 1, bytes.fromhex(text))
        for k, text in enumerate(frames)
    ]
    reader, log = open_rows(tmp_path, rows, LONG)
    got = read_all(reader)
    assert got["EC1.EngSpeedAtIdle"] == ([300_000_000], [500.0])
    assert got["EC1.EngRefTorque"] == ([300_000_000], [float(0x0807)])
    assert got["EC1.Last"] == ([300_000_000], [float(0x77)])
    assert lost(log) == {}
    assert reader.channels[0].tags["pgn"] == "65251"
    assert any("1 message was put together" in note and "EC1 (65251)" in note for note in log.notes)
    assert not any("in no database" in note for note in log.notes)


def test_all_1785_bytes_as_cantools_has_them(tmp_path: Path) -> None:
    payload = np.random.default_rng(3).integers(0, 250, 1785, dtype=np.uint8).tobytes()
    reader, _ = open_rows(tmp_path, timed(packets(payload, MINE)), LONG)
    got = {name: column[1][0] for name, column in read_all(reader).items()}
    database = cantools.database.Database(strict=False)
    database.add_dbc_string(LONG)
    expected = database.get_message_by_name("Mine").decode(payload, decode_choices=False)
    assert got == {f"Mine.{name}": float(value) for name, value in expected.items()}


def test_senders_at_once_and_buses_keep_apart(tmp_path: Path) -> None:
    a, b = packets(ec1(1), sender=0), packets(ec1(100), sender=1)
    other = packets(ec1(50), sender=0)
    rows = [
        (10 * k + part, can_id, bus, data)
        for k in range(7)
        for part, (bus, (can_id, data)) in enumerate([(1, a[k]), (1, b[k]), (2, other[k])])
    ]
    reader, log = open_rows(tmp_path, rows, LONG)
    got = read_all(reader)
    assert got["EC1.Last"] == ([60], [last_byte(1)])
    assert got["EC1.Last@sa1"] == ([61], [last_byte(100)])
    assert got["EC1.Last@bus2"] == ([62], [last_byte(50)])
    assert lost(log) == {}


def test_a_lost_packet_costs_its_message_and_is_said(tmp_path: Path) -> None:
    first, second, third = packets(ec1(1)), packets(ec1(2)), packets(ec1(3))
    del second[3]
    reader, log = open_rows(tmp_path, timed(first, second, third), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(1), last_byte(3)]
    assert lost(log) == {"EC1: J1939 message in packets, packets missing": 1}


def test_a_lost_announcement_mixes_no_messages(tmp_path: Path) -> None:
    first, second, third = packets(ec1(1))[:-1], packets(ec1(2))[1:], packets(ec1(3))
    reader, log = open_rows(tmp_path, timed(first, second, third), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(3)]
    assert lost(log) == {
        "EC1: J1939 message in packets, packets missing": 1,
        "J1939 message in packets without its announcement": 1,
    }


def test_packets_that_stand_twice_count_once(tmp_path: Path) -> None:
    """Recorders write what their own node sends as sent and as received."""
    twice = [frame for frame in [*packets(ec1(1)), *packets(ec1(2))] for _ in range(2)]
    reader, log = open_rows(tmp_path, timed(twice), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(1), last_byte(2)]
    assert lost(log) == {}


def test_the_logs_end_cuts_a_message(tmp_path: Path) -> None:
    reader, log = open_rows(tmp_path, timed(packets(ec1(1)), packets(ec1(2))[:-1]), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(1)]
    assert lost(log) == {"EC1: J1939 message in packets, cut by the log's end": 1}


def test_a_message_to_one_whose_receiver_asks_again(tmp_path: Path) -> None:
    """The receiver missed packet 3 and asks for it alone; all the while another message goes the other way."""
    sent = packets(ec1(9), sender=3, to=40)
    back = packets(ec1(70), sender=40, to=3)
    rows = [
        sent[0], answer(17, 40, 3, 6, 1), back[0], answer(17, 3, 40, 6, 1), sent[1], back[1], sent[2], back[2], sent[4],
        sent[5], sent[6], answer(17, 40, 3, 1, 3), *back[3:], sent[3], answer(19, 40, 3, 39, 0, 6), answer(19, 3, 40, 39, 0, 6),
    ]  # fmt: skip
    reader, log = open_rows(tmp_path, timed(rows), LONG)
    got = read_all(reader)
    assert got["EC1.Last"][1] == [last_byte(9)]
    assert got["EC1.Last@sa40"][1] == [last_byte(70)]
    assert lost(log) == {}


def test_a_message_to_one_that_is_broken_off_or_whose_packets_the_log_lacks(tmp_path: Path) -> None:
    sent = packets(ec1(9), sender=3, to=40)
    broken = [*sent[:4], answer(255, 40, 3, 3)]
    lacking = [*sent[:4], *sent[5:], answer(19, 40, 3, 39, 0, 6)]
    reader, log = open_rows(tmp_path, timed(broken, lacking, sent, sent[:1], sent), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(9)] * 2
    assert lost(log) == {
        "EC1: J1939 message in packets, broken off by sender or receiver": 1,
        "EC1: J1939 message in packets, packets missing": 1,
    }


def test_packets_that_come_too_late_are_of_no_message(tmp_path: Path) -> None:
    frames = packets(ec1(1))
    late = timed(frames[:3]) + timed(frames[3:], start=TIMEOUT_NS + 30_000_000)
    reader, log = open_rows(tmp_path, [*late, *timed(packets(ec1(2)), start=9 * TIMEOUT_NS)], LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(2)]
    assert lost(log) == {"EC1: J1939 message in packets, packets missing": 1}


def test_nothing_is_said_of_groups_that_no_database_has(tmp_path: Path) -> None:
    rows = timed(packets(ec1(1), pgn=65226), packets(ec1(1), pgn=65226)[:3], packets(ec1(4)))
    reader, log = open_rows(tmp_path, rows, LONG)
    assert {name.partition(".")[0] for name in read_all(reader)} == {"EC1"}
    assert lost(log) == {}
    assert any("1 of 2 CAN identifiers (1 of 2 frames) are in no database" in note for note in log.notes)


def test_announcements_that_are_none(tmp_path: Path) -> None:
    """Frames of other protocols with such a number, sizes that do not fit, short frames, and packets of nothing."""
    wrong = [
        (0x1CECFF00 | EXTENDED, bytes([32, 39, 0, 9, 255, 0xE3, 0xFE, 0])),
        (0x1CECFF00 | EXTENDED, bytes([32, 0, 0, 0, 255, 0xE3, 0xFE, 0])),
        (0x1CECFF00 | EXTENDED, bytes([32, 0xFF, 0xFF, 6, 255, 0xE3, 0xFE, 0])),
        (0x1CECFF00 | EXTENDED, bytes([32, 39, 0, 6])),
        (0x1CECFF00 | EXTENDED, bytes([16, 39, 0, 6, 255, 0xE3, 0xFE, 0])),
        (0x1CEC2100 | EXTENDED, bytes([32, 39, 0, 6, 255, 0xE3, 0xFE, 0])),
        (0x1CECFF00 | EXTENDED, bytes([32, 39, 0, 6, 255, 0xE3, 0xFE, 9])),
        (0x1CEBFF00 | EXTENDED, b""),
        (0x1CEBFF00 | EXTENDED, bytes(8)),
    ]
    reader, log = open_rows(tmp_path, timed([frame for one in wrong for frame in [one, *packets(ec1(1))[1:]]]), LONG)  # fmt: skip
    assert reader.channels == ()
    assert lost(log) == {}


def test_more_messages_at_once_than_are_held(tmp_path: Path) -> None:
    many = [announce(39, EC1, 16, k % 200, 201 + k // 200) for k in range(MOST_SESSIONS + 5)]
    reader, log = open_rows(tmp_path, timed(many, packets(ec1(1), sender=250)), LONG)
    assert read_all(reader)["EC1.Last"][1] == [last_byte(1)]
    crowded = f"EC1: J1939 message in packets, more than {MOST_SESSIONS} messages in packets at once"
    assert lost(log) == {crowded: 6, "EC1: J1939 message in packets, cut by the log's end": MOST_SESSIONS - 1}


@pytest.mark.parametrize("limits", [{"keep.ROWS": 3}, {"keep.WORDS": 224}, {"reader.KEPT_BYTES": 0}], ids=str)
def test_batches_change_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: dict[str, int]
) -> None:
    rows = timed(*[packets(ec1(k), sender=k % 3) for k in range(40)], packets(bytes(range(256)) * 5, MINE))
    del rows[20]
    expected = result(*open_rows(tmp_path, rows, LONG))
    for name, value in limits.items():
        monkeypatch.setattr(f"parsers.can.{name}", value)
    assert result(*open_rows(tmp_path, rows, LONG)) == expected


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32), damage=st.sampled_from(["none", "lost", "twice", "cut"]))
def test_what_comes_out_was_sent(tmp_path: Path, seed: int, damage: str) -> None:
    """Six senders' messages, shuffled into each other: without damage all come out, with damage none that was not sent."""
    rng = np.random.default_rng(seed)
    queues = {
        sender: [frame for _ in range(4) for frame in packets(rng.bytes(39), sender=sender)]
        for sender in range(6)
    }
    sent = {sender: [queue[k + 6][1][4] for k in range(0, len(queue), 7)] for sender, queue in queues.items()}
    frames: list[tuple[int, bytes]] = []
    while any(queues.values()):
        sender = int(rng.choice([s for s, queue in queues.items() if queue]))
        frames.append(queues[sender].pop(0))
    if damage == "lost":
        frames = [frame for frame in frames if rng.random() > 0.05]
    elif damage == "twice":
        frames = [frame for frame in frames for _ in range(1 + (rng.random() < 0.3))]
    elif damage == "cut":
        frames = frames[: int(rng.integers(1, len(frames)))]
    reader, log = open_rows(tmp_path, timed(frames, step=1_000_000), LONG)
    read_all(reader)
    total = 0
    for channel in reader.channels:
        if channel.tags["signal"] != "Last":
            continue
        total += channel.count or 0
    again, _ = open_rows(tmp_path, timed(frames, step=1_000_000), LONG)
    got = {int(c.tags["source_address"]): c.name for c in again.channels if c.tags["signal"] == "Last"}
    values = read_all(again)
    for sender, name in got.items():
        column = [v if v == v else None for v in values[name][1]]
        # codes from 251 on are no values
        left = iter([float(v) if v <= 250 else None for v in sent[sender]])
        assert all(any(value == other for other in left) for value in column)
    if damage in ("none", "twice"):
        assert total == 24
        assert lost(log) == {}
