"""Where the rows of logs go while they are read: kept in memory up to a budget, beyond it all of them on disk."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from parsers.adjacent import joined
from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.sparse_column import Kept, Packed, SparseColumns, joined_pieces, packed, whole
from parsers.timebase import Ordered, order

if TYPE_CHECKING:
    # loaded where a log is too long for memory
    from parsers.spool import GroupRows, GroupWriter, Spool

_ITEM = 8


@dataclass(frozen=True)
class Budget:
    """How much memory may be taken, in bytes, and where there is room for more.

    folder: where the file for what does not fit is made; a folder that is missing is made. rows: of logs that are kept
    whole. pending: of rows that wait for the disk. window: of rows that are looked at together. evidence: of samples on
    which units and signs are judged where a log is not kept whole, with evidence_s seconds at the most.
    """

    folder: Path
    rows: int = 48 << 20
    pending: int = 16 << 20
    window: int = 4 << 20
    evidence: int = 16 << 20
    evidence_s: float = 7200.0


@dataclass(frozen=True)
class Group:
    """All rows of one group, in order: time_ns (n,), columns name -> (n,), and how they were put in order.

    own: columns whose memory nobody else holds, so that they may be written over.
    """

    columns: Mapping[str, FloatArray]
    ordered: Ordered
    own: frozenset[str]

    @property
    def time_ns(self) -> IntArray:
        """The stamps, strictly increasing."""
        return self.ordered.time_ns


class LogRows:
    """The rows of one log. Made by `Intake.begin`."""

    def __init__(self, intake: Intake, columns: Mapping[str, tuple[str, ...]]) -> None:
        self._intake, self._names = intake, columns
        self._times: dict[str, list[IntArray]] = {}
        self._columns: dict[str, dict[str, list[Kept]]] = {}
        self._shared: set[str] = set()
        self.writers: dict[str, GroupWriter] = {}

    def add(
        self, group: str, time_ns: IntArray, columns: Mapping[str, FloatArray], *, own: bool = False
    ) -> None:
        """Take some rows of a group, (n,) each, in the log's order. own: see `Chunk`."""
        if self._intake.spool is not None:
            self._writer(group, self._intake.spool).add(time_ns, columns)
        else:
            self._times.setdefault(group, []).append(time_ns)
            held = self._columns.setdefault(group, {})
            if not own:
                self._shared.add(group)
            for name, values in packed(columns).items():
                held.setdefault(name, []).append(values)
        self._intake.took(len(time_ns) * (1 + len(columns)) * _ITEM)

    def _writer(self, group: str, spool: Spool) -> GroupWriter:
        from parsers.spool import GroupWriter

        if group not in self.writers:
            self.writers[group] = GroupWriter(spool, self._names.get(group, ()))
        return self.writers[group]

    def spill(self, spool: Spool) -> None:
        """Bring to the disk what was kept so far."""
        for group in list(self._times):
            times, columns = self._times.pop(group), self._columns.pop(group)
            writer = self._writer(group, spool)
            for number, time_ns in enumerate(times):
                writer.add(time_ns, {name: whole(parts[number]) for name, parts in columns.items()})
                if writer.pending_bytes > self._intake.budget_pending:
                    writer.flush()

    def groups(self) -> dict[str, Group]:
        """All rows that were kept in memory, by group; to be called once."""
        groups: dict[str, Group] = {}
        for name in list(self._times):
            ordered = order(joined(self._times.pop(name)))
            held = self._columns.pop(name)
            columns: dict[str, FloatArray] = {}
            sparse: dict[str, list[Kept]] = {}
            own: set[str] = set()
            for column in list(held):
                parts = held.pop(column)
                if any(isinstance(part, Packed) for part in parts):
                    # made when it is asked for, and then nobody else's
                    sparse[column] = parts
                    own.add(column)
                    continue
                values = joined_pieces(parts)
                columns[column] = values if ordered.untouched else values[ordered.rows]
                # what a reader gave may be several columns at once; a copy is nobody else's
                if name not in self._shared or (
                    columns[column].base is None and columns[column] is not parts[0]
                ):
                    own.add(column)
            rows = None if ordered.untouched else ordered.rows
            groups[name] = Group(
                SparseColumns(columns, sparse, rows) if sparse else columns, ordered, frozenset(own)
            )
        return groups

    def spooled(self) -> dict[str, GroupRows]:
        """All rows that went to the disk, by group; to be called once."""
        found = {name: self.writers.pop(name).finish() for name in list(self.writers)}
        return {name: rows for name, rows in found.items() if len(rows.index.rows)}


class Intake:
    """Takes the rows of all logs of a drive. spool: where they went; None as long as they fit into the budget."""

    def __init__(self, budget: Budget | None = None) -> None:
        """budget: without one all is kept in memory."""
        self.spool: Spool | None = None
        self._budget = budget
        self._logs: list[LogRows] = []
        self._taken = 0

    @property
    def budget_pending(self) -> int:
        """Bytes that may wait for the disk."""
        return self._budget.pending if self._budget else 0

    def begin(self, channels: Iterable[ChannelInfo], wanted: frozenset[str]) -> LogRows:
        """A new log, of which the wanted channels are read."""
        columns: dict[str, list[str]] = {}
        for info in channels:
            if info.name in wanted:
                columns.setdefault(info.group, []).append(info.name)
        rows = LogRows(self, {group: tuple(names) for group, names in columns.items()})
        self._logs.append(rows)
        return rows

    def took(self, size: int) -> None:
        """Count what was taken, and make room where it is too much."""
        self._taken += size
        if self._budget is None:
            return
        if self.spool is None:
            if self._taken > self._budget.rows:
                from parsers.spool import Spool

                self._budget.folder.mkdir(parents=True, exist_ok=True)
                self.spool = Spool(self._budget.folder)
                for log in self._logs:
                    log.spill(self.spool)
            return
        writers = [writer for log in self._logs for writer in log.writers.values()]
        pending = sum(writer.pending_bytes for writer in writers)
        if pending > self._budget.pending:
            # the largest first, so that a slow group's rows gather until they are worth a block
            for writer in sorted(writers, key=lambda each: -each.pending_bytes):
                if pending <= self._budget.pending // 2:
                    break
                pending -= writer.pending_bytes
                writer.flush()

    def close(self) -> None:
        """Give the disk's space back."""
        if self.spool is not None:
            self.spool.close()
