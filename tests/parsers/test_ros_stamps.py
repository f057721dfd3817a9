"""Header stamp or receive time: which of the two a message gets, and what is said about it."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.importer import ImportLog
from parsers.ros.stamps import StampChooser, choose_stamps

SECOND = 1_000_000_000


def test_stamps_follow_the_header_where_it_can_be_believed() -> None:
    chooser, log = StampChooser(), ImportLog()
    receive = np.arange(10, dtype=np.int64) * SECOND + 1_700_000_000 * SECOND
    header = receive - SECOND // 2
    header[3] = 0
    header[5] -= 100 * SECOND
    expected_ns = header.copy()
    expected_ns[[3, 5]] = receive[[3, 5]]
    np.testing.assert_array_equal(chooser.choose("/imu", header, receive), expected_ns)
    np.testing.assert_array_equal(
        chooser.choose("/sim", receive - 1_700_000_000 * SECOND + 1, receive), receive
    )
    np.testing.assert_array_equal(chooser.choose("/zero", np.zeros(10, dtype=np.int64), receive), receive)
    np.testing.assert_array_equal(chooser.choose("/plain", None, receive), receive)
    chooser.finish(log)
    notes = "\n".join(log.notes)
    assert "/imu: header stamps are 0.50 s before the receive time (median)" in notes
    assert "/imu: 1 messages have no header stamp" in notes
    assert "/imu: 1 header stamps are more than 60 s off" in notes
    assert "/sim: header stamps are on another clock" in notes
    assert "/zero: header stamps are all zero" in notes
    assert "no header, so the receive time is used: /plain" in notes
    assert chooser.clock == "header stamp (receive time for /sim, /zero, /plain)"


def test_clock_is_known_before_reading() -> None:
    chooser = StampChooser()
    chooser.add("/imu", has_header=True)
    assert chooser.clock == "header stamp"
    chooser.add("/speed", has_header=False)
    assert chooser.clock == "header stamp (receive time for /speed)"


@pytest.mark.parametrize("count", [0, 1, 5, 255, 256, 257, 3000])
def test_compiled_choice_equals_the_plain_one(count: int) -> None:
    rng = np.random.default_rng(count)
    receive = rng.integers(0, 2**62, count)
    header = receive - rng.integers(-2 * SECOND, 2 * SECOND, count)
    header[rng.random(count) < 0.2] = 0
    receive[rng.random(count) < 0.1] = -5
    expected, empty, far, near = [], 0, 0, []
    for stamp, other in zip(header.tolist(), receive.tolist(), strict=True):
        good = stamp > 0 and other >= 0 and abs(other - stamp) <= SECOND
        expected.append(stamp if good else other)
        empty += stamp <= 0
        far += stamp > 0 and not good
        near += [float(other - stamp)] if good else []
    chosen, delays = np.zeros(count, dtype=np.int64), np.zeros(min(256, count))
    got = choose_stamps(header, receive, SECOND, chosen, delays)
    assert chosen.tolist() == expected
    assert got[:2] == (empty, far)
    assert (got[2] > 0) == bool(near)
    assert set(delays[: got[2]].tolist()) <= set(near)


def test_result_may_be_written_over_the_header_stamps() -> None:
    receive = np.arange(6, dtype=np.int64) * SECOND + 1_700_000_000 * SECOND
    header = receive - 5
    header[2] = 0
    one = StampChooser().choose("/imu", header.copy(), receive)
    two = StampChooser().choose("/imu", header, receive, in_place=True)
    assert one.tolist() == two.tolist() == [*(receive[:2] - 5), receive[2], *(receive[3:] - 5)]
    assert two is header


@pytest.mark.parametrize(
    ("step_s", "said"),
    [(1.0, "come in steps of 1 s"), (0.2, "come in steps of 0.2 s"), (None, "stand still")],
)
def test_header_stamps_that_do_not_move_with_the_messages_are_not_used(
    step_s: float | None, said: str
) -> None:
    chooser, log = StampChooser(), ImportLog()
    receive = np.arange(400, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    header = (
        np.full(400, receive[0])
        if step_s is None
        else receive // round(step_s * SECOND) * round(step_s * SECOND)
    )
    for part in (slice(0, 200), slice(200, 400)):
        np.testing.assert_array_equal(
            chooser.choose("/imu", header[part].copy(), receive[part]), receive[part]
        )
    chooser.finish(log)
    assert chooser.clock == "receive time"
    assert any(f"/imu: header stamps {said} while messages go on" in note for note in log.notes)


def test_header_stamps_of_bursts_and_pairs_are_used() -> None:
    receive = np.arange(400, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    pairs = np.repeat(receive[::2], 2)
    np.testing.assert_array_equal(StampChooser().choose("/both", pairs.copy(), receive), pairs)
    # ten at one moment, received at one moment: nothing tells them apart
    burst = np.repeat(receive[::10], 10)
    np.testing.assert_array_equal(
        StampChooser().choose("/burst", burst - SECOND // 4, burst), burst - SECOND // 4
    )


def chosen_in_batches(header: np.ndarray, receive: np.ndarray, size: int) -> tuple[np.ndarray, str]:
    chooser, log = StampChooser(), ImportLog()
    parts = [slice(at, at + size) for at in range(0, len(receive), size)]
    times = [chooser.choose("/imu", header[part].copy(), receive[part], in_place=True) for part in parts]
    chooser.finish(log)
    return np.concatenate(times), "\n".join(log.notes)


@pytest.mark.parametrize("size", [1, 40, 333, 6000])
@pytest.mark.parametrize("step_s", [-20, 20, 2])
def test_a_header_clock_that_is_set_does_not_move_the_messages_behind_it(step_s: int, size: int) -> None:
    rng = np.random.default_rng(1)
    true = np.arange(5000, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    receive = true + 30_000_000 + rng.integers(0, 5_000_000, 5000)
    header = true.copy()
    header[3000:] += step_s * SECOND
    times, notes = chosen_in_batches(header, receive, size)
    assert np.array_equal(times[:3000], true[:3000])
    # a step that a batch does not show to last costs these few messages at the most
    few = 15 if size < 40 else 0
    assert np.abs(times[3000 + few :] - true[3000 + few :]).max() < 10_000_000
    assert f"/imu: the clock of the header stamps was set by {step_s:+.1f} s" in notes
    # where the clock is set right again, its stamps are used again
    header[4000:] = true[4000:]
    times, _ = chosen_in_batches(header, receive, size)
    assert np.array_equal(times[4000:], true[4000:])


def test_header_stamps_stay_where_the_network_or_a_second_sender_is_late() -> None:
    true = np.arange(5000, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    late = true + 5_000_000
    # nothing arrives for five seconds, then all of it at once
    stalled = np.maximum(late, np.where(true > true[2000], late[2500], 0))
    # the same, of which the queue lost the middle
    kept = np.r_[0:2100, 2400:5000]
    # every other message is of a sender that takes three seconds
    second = true.copy()
    second[1::2] -= 3 * SECOND
    # one stamp is wrong, the first one as well; the recorder's clock is set; both are set
    wrong = true.copy()
    wrong[[0, 700]] -= 9 * SECOND
    moved = late.copy()
    moved[3000:] += 20 * SECOND
    both = true.copy()
    both[3000:] += 20 * SECOND
    cases = (
        (true, stalled),
        (true[kept], stalled[kept]),
        (second, late),
        (wrong, late),
        (true, moved),
        (both, moved),
    )
    for header, receive in cases:
        times, notes = chosen_in_batches(header, receive, 500)
        assert np.array_equal(times, header)
        assert "clock of the header" not in notes


@pytest.mark.parametrize("size", [1, 5, 40, 5000])
@pytest.mark.parametrize("off_s", [37, -18, 12.345])
def test_a_topic_whose_headers_are_by_another_clock_lies_beside_the_others(off_s: float, size: int) -> None:
    rng = np.random.default_rng(2)
    true = np.arange(1, 3001, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    receive = true + rng.integers(2_000_000, 20_000_000, 3000)
    header = true - round(off_s * SECOND)
    header[50] = 0
    times, notes = chosen_in_batches(header, receive, size)
    exact = 0 if off_s == round(off_s) else 20_000_000
    # until a few stamps are known, the receive time
    assert np.abs(times[8:50] - true[8:50]).max() <= exact
    assert np.abs(times[51:] - true[51:]).max() <= exact
    assert np.abs(times - true).max() <= 20_000_000
    side = "before" if off_s > 0 else "after"
    said = f"{abs(off_s):g} s" if exact == 0 else "12.3"
    assert f"/imu: header stamps are {said}" in notes
    assert f"s {side} the receive time all along" in notes


@pytest.mark.parametrize("off_s", [0.5, 1.5, 3])
def test_a_delay_that_messages_can_have_shifts_nothing(off_s: float) -> None:
    receive = np.arange(1, 501, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    header = receive - round(off_s * SECOND)
    times, notes = chosen_in_batches(header, receive, 40)
    assert np.array_equal(times, header)
    assert f"{off_s:.2f} s before the receive time (median)" in notes
    assert "all along" not in notes


def test_a_delay_that_changes_is_no_clocks_offset() -> None:
    receive = np.arange(1, 501, dtype=np.int64) * SECOND // 100 + 1_700_000_000 * SECOND
    header = receive - np.linspace(4, 20, 500).astype(np.int64) * SECOND
    times, notes = chosen_in_batches(header, receive, 500)
    assert np.array_equal(times, header)
    assert "all along" not in notes


def test_a_first_message_that_waited_tells_no_offset() -> None:
    receive = np.arange(1, 101, dtype=np.int64) * SECOND + 1_700_000_000 * SECOND
    header = receive - SECOND // 100
    header[0] -= 20 * SECOND
    times, notes = chosen_in_batches(header, receive, 1)
    # the median of two is half of it
    assert np.array_equal(times[2:], header[2:])
    assert np.array_equal(times[:2], receive[:2])
    assert "2 messages with header stamps more than 5 s off" in notes
    assert "all along" not in notes
