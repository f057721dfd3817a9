"""Preparation: one clock, no bridged gaps, zero delay, offsets at rest."""

from __future__ import annotations

import numpy as np
import plant_roll as plant
import pytest
from numpy.typing import NDArray

from parsers.drive import Drive, Signal
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.signals import prepare_signals
from pipelines.prepare.spans import gap_free_rows
from pipelines.prepare.spikes import without_spikes
from pipelines.prepare.standstill import first_rest

Array = NDArray[np.float64]


def signal(name: str, t: Array, values: Array) -> Signal:
    return Signal(name, np.round(t * 1e9).astype(np.int64), values, name)


def drive_of(*signals: Signal) -> Drive:
    return Drive({s.name: s for s in signals}, plant.bare_record(100.0))


def wave(t: Array, hz: float = 1.0) -> Array:
    return np.sin(2 * np.pi * hz * t)


def test_lowpass_has_no_delay_and_half_amplitude_at_the_cutoff() -> None:
    t = np.arange(0, 40, 0.01)
    core = slice(500, -500)
    np.testing.assert_allclose(lowpass(wave(t, 0.5), 100.0, 8.0)[core], wave(t, 0.5)[core], atol=1e-6)
    np.testing.assert_allclose(lowpass(wave(t, 8.0), 100.0, 8.0)[core], 0.5 * wave(t, 8.0)[core], atol=2e-3)
    ramp = lowpass(3 + 0.2 * t, 100.0, 2.0)
    np.testing.assert_allclose(ramp, 3 + 0.2 * t, atol=1e-6)


def test_different_rates_and_phases_meet_on_one_clock() -> None:
    fast, slow = np.arange(0, 30, 0.01) + 0.0031, np.arange(0.5, 29, 0.05)
    drive = drive_of(signal("accel_y", fast, wave(fast)), signal("roll", slow, wave(slow)))
    prepared = prepare_signals(drive, ["accel_y", "roll"], rate_hz=16.0, cutoff_hz=8.0)
    (segment,) = prepared.segments
    rows = slice(segment.start + 16, segment.stop - 16)
    t = prepared.time_s[rows]
    np.testing.assert_allclose(prepared.columns["accel_y"][rows], wave(t), atol=2e-4)
    np.testing.assert_allclose(prepared.columns["roll"][rows], wave(t), atol=2e-4)
    assert prepared.raw_rate_hz == {"accel_y": pytest.approx(100), "roll": pytest.approx(20)}


def test_fast_noise_does_not_fold_back() -> None:
    """A 37 Hz vibration at 2 kHz must not show up as a slow one at 16 Hz."""
    t = np.arange(0, 20, 0.0005)
    drive = drive_of(signal("accel_y", t, wave(t, 37.0)))
    prepared = prepare_signals(drive, ["accel_y"], rate_hz=16.0, cutoff_hz=8.0)
    assert np.nanmax(np.abs(prepared.columns["accel_y"][8:-8])) < 1e-3


def test_never_bridges_a_gap_and_never_extrapolates() -> None:
    t = np.arange(0, 40, 0.01)
    awake = np.arange(5.0, 38.0, 0.1)
    holed = t[(t < 12) | (t > 14.5)]
    drive = drive_of(signal("accel_y", holed, wave(holed)), signal("speed", awake, np.full(len(awake), 9.0)))
    prepared = prepare_signals(drive, ["accel_y", "speed"], rate_hz=20.0, cutoff_hz=4.0)
    spans = [(prepared.time_s[s.start], prepared.time_s[s.stop - 1]) for s in prepared.segments]
    assert spans == [(pytest.approx(5.0, abs=0.06), pytest.approx(12, abs=0.06)),
                     (pytest.approx(14.5, abs=0.06), pytest.approx(37.9, abs=0.06))]  # fmt: skip
    hole = (prepared.time_s > 12.05) & (prepared.time_s < 14.45)
    assert np.isnan(prepared.columns["accel_y"][hole]).all()


def test_a_slow_signal_is_not_a_gap_and_an_optional_one_cuts_nothing() -> None:
    t, slow = np.arange(0, 20, 0.01), np.arange(0, 20, 0.2)
    late = np.arange(8, 12, 0.01)
    drive = drive_of(
        signal("accel_y", t, wave(t)), signal("speed", slow, slow), signal("yaw_rate", late, wave(late))
    )  # fmt: skip
    prepared = prepare_signals(
        drive,
        ["accel_y", "speed"],
        rate_hz=None,
        cutoff_hz=8.0,
        max_gap_s=0.05,
        optional=["yaw_rate", "roll"],
    )
    assert len(prepared.segments) == 1
    assert prepared.cutoff_hz == pytest.approx(2.0)
    assert any("speed comes at 5 Hz" in note for note in prepared.notes)
    assert np.isnan(prepared.columns["yaw_rate"][: round(7 * prepared.rate_hz)]).all()
    assert "roll" not in prepared.columns


def test_what_is_missing_or_never_overlaps_is_said() -> None:
    t = np.arange(0, 10, 0.01)
    drive = drive_of(signal("accel_y", t, wave(t)), signal("roll", t + 50, wave(t)))
    assert (
        "never there at the same time"
        in prepare_signals(drive, ["accel_y", "roll"], rate_hz=20, cutoff_hz=4).notes[0]
    )
    lacking = prepare_signals(drive, ["accel_y", "yaw_rate"], rate_hz=20, cutoff_hz=4)
    assert lacking.segments == ()
    assert lacking.notes == ("not in the log: yaw_rate",)


def test_jittered_and_doubled_stamps_do_not_ring() -> None:
    rng = np.random.default_rng(6)
    t = np.sort(np.arange(0, 20, 0.01) + rng.uniform(0, 0.004, 2000))
    t[1000] = t[999] + 1e-6
    values = wave(t)
    values[1000] += 0.05
    prepared = prepare_signals(drive_of(signal("accel_y", t, values)), ["accel_y"], rate_hz=16, cutoff_hz=8)
    assert np.nanmax(np.abs(prepared.columns["accel_y"] - wave(prepared.time_s))[4:-4]) < 0.06


def test_wild_samples_go_and_real_motion_stays() -> None:
    rng = np.random.default_rng(7)
    t = np.arange(0, 30, 0.01)
    clean = 3 * wave(t, 0.5) + 0.05 * rng.standard_normal(len(t))
    dirty = clean.copy()
    dirty[[100, 1500]] += [400.0, -90.0]
    kept, dropped = without_spikes(signal("roll", t, dirty))
    assert dropped == 2
    np.testing.assert_array_equal(kept.values, np.delete(clean, [100, 1500]))
    assert without_spikes(signal("roll", t, clean))[1] == 0
    step = np.where(t > 15, 5.0, 0.0) + 0.01 * rng.standard_normal(len(t))
    assert without_spikes(signal("roll", t, step))[1] == 0


def test_a_hundredth_of_wild_samples_goes_and_a_tenth_is_how_a_signal_moves() -> None:
    rng = np.random.default_rng(7)
    t = np.arange(0, 60, 0.01)
    clean = 3 * wave(t, 0.5) + 0.05 * rng.standard_normal(len(t))
    places = np.arange(50, len(t) - 50, 83)
    dirty = clean.copy()
    dirty[places] += 20.0 * rng.choice([-1, 1], len(places))
    kept, dropped = without_spikes(signal("accel_y", t, dirty))
    assert dropped == len(places)
    np.testing.assert_array_equal(kept.values, np.delete(clean, places))
    shaken = clean.copy()
    shaken[::10] += 20.0
    assert without_spikes(signal("accel_y", t, shaken))[1] == 0


def test_the_first_bite_of_the_brakes_in_a_quiet_log_is_no_wild_sample() -> None:
    """Simulated logs have no noise: what jolts ten times in an hour is far beyond the usual there."""
    t = np.arange(0, 120, 0.01)
    torque, accel = np.zeros(len(t)), np.zeros(len(t))
    for at in range(1000, 11000, 2000):
        since = t[at : at + 300] - t[at]
        torque[at : at + 300] = 900 * since + 500 * np.exp(-since / 0.012)
        accel[at : at + 300] = -6 * (1 - np.exp(-since / 0.1) * np.cos(40 * since)) - 2 * np.exp(
            -since / 0.01
        )
    for name, values in (("brake_torque", torque), ("accel_x", accel)):
        assert without_spikes(signal(name, t, values))[1] == 0
        wild = values.copy()
        wild[[500, 1100, 1101, 8000]] += 5000.0
        kept, dropped = without_spikes(signal(name, t, wild))
        assert dropped == 4
        np.testing.assert_array_equal(kept.values, np.delete(values, [500, 1100, 1101, 8000]))


def test_offsets_come_from_the_rest_before_motion() -> None:
    rng = np.random.default_rng(8)
    t = np.arange(0, 40, 0.01)
    moving = (t > 5) & (t < 20)
    rocking = (t >= 20) * np.exp(-(t - 20).clip(0)) * np.sin(12 * (t - 20))
    rate = 0.0063 + 0.3 * rocking + np.where(moving, wave(t), 0.0) + 0.005 * rng.standard_normal(len(t))
    slow = np.arange(0, 40, 0.1)
    speed = np.where((slow > 5) & (slow < 20), 10.0, 0.0)
    drive = drive_of(signal("roll_rate", t, rate), signal("speed", slow, speed))
    prepared = prepare_signals(drive, ["roll_rate"], rate_hz=16, cutoff_hz=8)
    offset, error = prepared.standstill_offset["roll_rate"]
    assert abs(offset - 0.0063) < 4 * error
    assert 1e-4 < error < 1e-3
    assert prepared.standstill[: 4 * 16].all()
    assert not prepared.standstill[6 * 16 : 19 * 16].any()


def test_rest_after_a_stop_leaves_out_the_rocking_body() -> None:
    still = np.zeros(400, dtype=bool)
    still[200:300] = True
    assert first_rest(still, 10.0) == (230, 297)
    still[200:300] = False
    still[200:235] = True
    assert first_rest(still, 10.0) is None


def test_without_speed_quiet_sensors_tell_standstill() -> None:
    rng = np.random.default_rng(9)
    t = np.arange(0, 30, 0.01)
    moving = t > 10
    noise = np.where(moving, 0.4, 0.02)
    drive = drive_of(
        signal("accel_y", t, noise * rng.standard_normal(len(t))),
        signal("roll_rate", t, 0.004 + 0.1 * noise * rng.standard_normal(len(t))),
    )
    prepared = prepare_signals(drive, ["accel_y", "roll_rate"], rate_hz=16, cutoff_hz=8)
    assert prepared.standstill[16 : 9 * 16].all()
    assert not prepared.standstill[11 * 16 :].any()
    assert prepared.standstill_offset["roll_rate"][0] == pytest.approx(0.004, abs=5e-4)


def test_gap_free_rows() -> None:
    time_ns = (np.array([0, 10, 20, 70, 80, 200, 210, 220]) * 1_000_000).astype(np.int64)
    assert gap_free_rows(time_ns) == [(0, 3), (3, 5), (5, 8)]
    assert gap_free_rows(time_ns, 0.06) == [(0, 5), (5, 8)]
    assert gap_free_rows(time_ns[:1]) == []
