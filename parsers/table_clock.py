"""Turn the time cells of a block into nanoseconds, by a `TimePlan`."""

from __future__ import annotations

import numpy as np

from parsers.channels import IntArray
from parsers.table_rows import RowBlock, RowRules
from parsers.table_stamps import BoolArray, calendar_ns, decimal_ns, has_zone, unwrap_days
from parsers.table_time import TimePlan

_MINUTE_NS = 60_000_000_000


class TableClock:
    """Reads the time of block after block; remembers the last time of day, for midnights."""

    def __init__(self, plan: TimePlan, rules: RowRules) -> None:
        self._plan = plan
        self._rules = rules
        self._last: int | None = None

    def read(self, block: RowBlock) -> tuple[IntArray, BoolArray]:
        """time_ns and whether it is valid, each of shape (rows,). The block's spans begin with the plan's columns."""
        if self._plan.kind == "calendar":
            return self._calendar(block)
        units = (self._plan.unit_ns,) if self._plan.kind == "decimal" else (1_000_000_000, 1)
        total = np.zeros(block.rows, dtype=np.int64)
        all_valid = np.ones(block.rows, dtype=np.bool_)
        for k, unit_ns in enumerate(units):
            part = np.empty(block.rows, dtype=np.int64)
            valid = np.empty(block.rows, dtype=np.bool_)
            decimal_ns(
                block.data, block.spans[k], self._rules.decimal, self._rules.thousands, unit_ns, part, valid
            )
            total += part
            all_valid &= valid
        return total, all_valid

    def _calendar(self, block: RowBlock) -> tuple[IntArray, BoolArray]:
        day = np.zeros(block.rows, dtype=np.int64)
        clock = np.zeros(block.rows, dtype=np.int64)
        shift = np.zeros(block.rows, dtype=np.int64)
        all_valid = np.ones(block.rows, dtype=np.bool_)
        for k in range(len(self._plan.columns)):
            days, clocks, zones = (np.empty(block.rows, dtype=np.int64) for _ in range(3))
            valid = np.empty(block.rows, dtype=np.bool_)
            calendar_ns(block.data, block.spans[k], self._plan.order, days, clocks, zones, valid)
            day += days
            clock += clocks
            shift += np.where(has_zone(zones), zones, 0)
            all_valid &= valid
        time_ns = day + clock - shift * _MINUTE_NS
        if self._plan.absolute:
            return time_ns, all_valid & (day != 0)
        kept = unwrap_days(time_ns[all_valid], self._last)
        if len(kept):
            self._last = int(kept[-1])
        time_ns[all_valid] = kept
        return time_ns, all_valid
