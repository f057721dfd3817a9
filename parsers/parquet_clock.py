"""The clocks of a Parquet log's tables: times of day run on over midnight, counters over their end, from part to part."""

from __future__ import annotations

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.table_stamps import unwrap_days
from parsers.table_time_plan import TimePlan
from parsers.table_wraps import Counter, turns_of


class ParquetClock:
    """Follows the stamps of each table's chunks, in their order."""

    def __init__(self, log: ImportLog) -> None:
        self._log = log
        self._of_day: dict[int, int] = {}
        self._counters: dict[int, Counter] = {}

    def follow(self, table: int, plan: TimePlan, time_ns: IntArray) -> IntArray:
        """Stamps that run on, (n,), of those of the table's next chunk; n is at least 1."""
        if plan.absolute:
            return time_ns
        if plan.kind == "calendar":
            time_ns = unwrap_days(time_ns.copy(), self._of_day.get(table))
            self._of_day[table] = int(time_ns[-1])
        elif plan.kind == "decimal":
            counter = self._counters.setdefault(table, Counter(turns_of(plan.unit_ns), self._log))
            time_ns = counter.follow(time_ns)
        return time_ns
