"""How two columns go together some seconds apart: a recorder that was started by hand, a receiver's link, a second log beside the first.

A weave looks inverted to what is half a wave late. So what goes together better some seconds apart, the other way round, has no sign at hand.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray

FARTHEST = 50
"""Cells of 0.1 s that are looked over either way."""

ALIKE, BETTER = 0.8, 1.05
"""Likeness from which on what is some seconds apart is one motion, and how many times better than at hand it must be."""


def at_far_lags(first: FloatArray, second: FloatArray, *, centred: bool = True) -> FloatArray | None:
    """(2 FARTHEST + 1,) correlations, first taken -FARTHEST … FARTHEST cells later; None where too little is there.

    first, second: (n,), NaN where there is no value: nothing then speaks for or against.
    """
    if len(first) <= 4 * FARTHEST:
        return None
    a, b = (_filled(column, centred=centred) for column in (first, second))
    size = 1 << (len(a) + FARTHEST).bit_length()
    # a damaged log may hold numbers whose squares no float can hold: nothing can be said of those
    with np.errstate(over="ignore", invalid="ignore"):
        norm = float(np.sqrt(np.sum(a * a)) * np.sqrt(np.sum(b * b)))
        if not 0 < norm < np.inf:
            return None
        spectrum = np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size))
        whole = np.fft.irfft(spectrum, size) / norm
    found = np.concatenate([whole[-FARTHEST:], whole[: FARTHEST + 1]])
    return found if np.isfinite(found).all() else None


def better_elsewhere(first: FloatArray, second: FloatArray, sign: int, near: int, *, centred: bool) -> bool:
    """Whether both go together with the other sign, better, further apart than `near` cells."""
    found = at_far_lags(first, second, centred=centred)
    if found is None:
        return False
    close = slice(FARTHEST - near, FARTHEST + near + 1)
    along = float(np.max(sign * found[close]))
    against = float(np.max(-sign * found))
    return against >= ALIKE and against > BETTER * along


def _filled(column: FloatArray, *, centred: bool) -> FloatArray:
    there = np.isfinite(column)
    middle = float(np.mean(column[there])) if centred and there.any() else 0.0
    return np.where(there, column - middle, 0.0)
