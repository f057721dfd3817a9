"""The columnar store of a drive: Parquet, one file a rate group, with `time_ns` and the signals' columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from parsers.drive import Drive, Signal
from parsers.parquet_write import Column, PackedAhead, Table, write_tables
from parsers.quantiles import distinct
from parsers.signals import SIGNALS
from parsers.store_folder import Replacement, write_errors
from parsers.timebase import usual_period_s


def rate_groups(signals: Sequence[Signal]) -> list[list[Signal]]:
    """Signals of one table, topic or message of the log together, in the log's order."""
    groups: dict[str, list[Signal]] = {}
    for signal in signals:
        groups.setdefault(signal.group, []).append(signal)
    return list(groups.values())


def group_table(signals: Sequence[Signal]) -> Table:
    """One table: time_ns (every stamp of any of the signals) and a column a signal, NaN where it has no sample."""
    first = signals[0].time_ns
    if all(s.time_ns is first or np.array_equal(s.time_ns, first) for s in signals):
        return {"time_ns": first, **{SIGNALS[s.name].column: s.values for s in signals}}
    time_ns = distinct(np.concatenate([s.time_ns for s in signals]))
    columns: dict[str, Column] = {"time_ns": time_ns}
    for signal in signals:
        values = np.full(len(time_ns), np.nan)
        values[np.searchsorted(time_ns, signal.time_ns)] = signal.values
        columns[SIGNALS[signal.name].column] = values
    return columns


class PackAhead(PackedAhead):
    """Packs what `write_drive` will most likely write, while other signals are made and the checks look at it."""

    def signal(self, signal: Signal) -> None:
        """Begin with a signal and its stamps."""
        self.begin(signal.time_ns)
        self.begin(signal.values)


def write_drive(drive: Drive, folder: Path, ahead: PackedAhead | None = None) -> list[Path]:
    """Write a drive as Parquet files and its import record; the files written. ahead: see `PackAhead`.

    The files take the place of those that an earlier run wrote into the folder; until all are made, nothing there
    changes. Raises LogError where they cannot be written, or where the folder holds tables of others.
    """
    with write_errors(folder), Replacement(folder) as tables:
        groups = rate_groups(list(drive.signals.values()))
        parts = [tables.part() for _ in groups]
        write_tables(
            [(part, group_table(signals)) for signals, part in zip(groups, parts, strict=True)], ahead
        )
        for signals, part in zip(groups, parts, strict=True):
            longest = max((s.time_ns for s in signals), key=len)
            tables.name(part, signals[0].group, usual_period_s(longest))
        return tables.commit(drive.record)
