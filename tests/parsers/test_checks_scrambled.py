"""A channel that is read with another byte order is left out and named; noise and motion are not."""

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive


def swapped(signal, step):
    """The signal as 16 bits with a sign in steps of `step`, its bytes read the wrong way round."""
    raw = np.round(signal.values / step).astype(np.int16)
    return replace(signal, values=raw.byteswap().astype(float) * step)


@pytest.mark.parametrize(
    ("name", "step"),
    [("accel_y", 0.001), ("yaw_rate", 0.0002), ("roll_rate", 0.0002), ("steering_wheel_angle", 0.0005)],
)
def test_swapped_bytes_are_named_and_nothing_else_is_said(name, step):
    signals = drive()
    fixed, decisions = check(signals | {name: swapped(signals[name], step)})
    assert name not in fixed
    assert [each.signal for each in decisions if each.applied] == [name]
    (said,) = (each for each in decisions if each.signal == name)
    assert "byte order" in said.found


def test_a_noisy_signal_stays():
    rng = np.random.default_rng(1)
    signals = drive()
    for name, std in (("accel_y", 1.5), ("yaw_rate", 0.1)):
        old = signals[name]
        signals[name] = replace(old, values=old.values + std * rng.standard_normal(len(old.values)))
    fixed, decisions = check(signals)
    assert {"accel_y", "yaw_rate"} <= fixed.keys()
    assert not any("byte order" in each.found for each in decisions)
