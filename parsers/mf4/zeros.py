"""Records of zeros among others: what is left of a lost block of the file. They look like samples of 0 at the clock's zero."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch

REASON = "record of zeros, or beside one"
SAYS = (
    "records of zeros stand among others in the MF4 file, as where a block of it was lost: they and the records beside them, which "
    "may be zeroed in part, were left out"
)


def find_zeros(batch: Batch, time_ns: IntArray, zero_ns: int | None) -> NDArray[np.bool_] | None:
    """Which records (n,) are zero from the first byte to the last though the clock has gone on, with one more to each side.

    zero_ns: the stamp of a record of zeros, None where it could be a true one. None where there is none.
    """
    # the least stamp alone tells it of nearly every batch
    if zero_ns is None or not time_ns.size or time_ns.min() > zero_ns:
        return None
    at = np.flatnonzero(time_ns == zero_ns)
    if not at.size:
        return None
    if batch.first == 0:
        # a log begins at zero, and its first samples may be
        later = np.flatnonzero(time_ns > zero_ns)
        at = at[at > later[0]] if later.size else at[:0]
    at = at[~batch.rows[at].any(axis=1)]
    if not at.size:
        return None
    found = np.zeros(time_ns.size, np.bool_)
    for shift in (-1, 0, 1):
        found[np.clip(at + shift, 0, found.size - 1)] = True
    return found


def left_out(log: ImportLog, count: int) -> None:
    """Say that the file is damaged, and count the records."""
    log.reject(REASON, count)
    if SAYS not in log.notes:
        log.worsen("malformed", SAYS)
