"""What grouping asks of recordings, looked up in their files once each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from parsers.errors import CogestError
from parsers.importer import ReadOptions
from pipelines.fleet.belongings import MAP, Belongings
from pipelines.fleet.clocks import MOST_BYTES, Clock, clock_of
from pipelines.fleet.entries import path_of
from pipelines.fleet.logs import Log
from pipelines.fleet.together import Moments


@dataclass
class LookedUp:
    """Clocks and contents of recordings; see `pipelines.fleet.group.Facts`."""

    belongings: Belongings
    _clocks: dict[str, Clock | None] = field(default_factory=dict)
    _contents: dict[str, Mapping[str, Moments] | None] = field(default_factory=dict)

    def clock(self, log: Log) -> Clock | None:
        """When a recording begins and ends; None where that is not quickly told."""
        if log.place not in self._clocks:
            self._clocks[log.place] = clock_of(log, self._options(log))
        return self._clocks[log.place]

    def content(self, log: Log) -> Mapping[str, Moments] | None:
        """A recording's signals; None where it is large, or cannot be read."""
        if log.place not in self._contents:
            self._contents[log.place] = (
                self._read(log) if log.size <= MOST_BYTES and not log.trouble else None
            )
        return self._contents[log.place]

    def _options(self, log: Log) -> ReadOptions:
        return self.belongings.read_options(log)

    def _read(self, log: Log) -> Mapping[str, Moments] | None:
        from parsers.load import LoadOptions, load_drive
        from parsers.mapping import read_map

        try:
            place = self.belongings.nearest(MAP, log.folder, [(log.folder, log.name)])
            mapping = read_map(path_of(place), strict=False) if place else None
            dbc = tuple(path_of(each) for each in self.belongings.databases(log.folder))
            # damaged values may be beyond what can be squared: such a signal is like no other
            with np.errstate(all="ignore"):
                drive = load_drive([log.path], LoadOptions(map=mapping, dbc=dbc, dbc_given=False, fix=False))
                return {
                    name: Moments(float(np.mean(signal.values)), float(np.std(signal.values)))
                    for name, signal in drive.signals.items()
                }
        except (CogestError, OSError, ValueError, MemoryError):
            return None
