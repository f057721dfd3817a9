"""Time from another group (MDF 4.2, column-oriented files: the master channel has a group of its own)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.clock import find_master, times_ns
from parsers.mf4.model import Channel, Group, Measurement
from parsers.mf4.records import record_size
from parsers.mf4.streams import DataStream, open_stream


@dataclass
class RemoteTime:
    """The time channel of another group, read alongside: record n here has the time of record n there."""

    group: Group
    master: Channel
    stream: DataStream
    log: ImportLog

    def times(self, batch: Batch) -> tuple[Batch, IntArray]:
        """The batch as far as there are times for it, and those times."""
        size = record_size(self.group, self.stream)
        count = min(batch.rows.shape[0], max(0, self.stream.size // max(size, 1) - batch.first))
        try:
            raw = self.stream.read(batch.first * size, (batch.first + count) * size)
        except LogError as error:
            self.log.worsen(
                "malformed", f"the time of channel group {batch.group.number} is damaged: {error.problem}"
            )
            count, raw = 0, np.zeros(0, np.uint8)
        if count < batch.rows.shape[0]:
            self.log.reject("record without a time", batch.rows.shape[0] - count)
        time_ns = times_ns(raw.reshape(count, size), self.master, batch.first)
        return replace(batch, rows=batch.rows[:count]), time_ns


def remote_time(file: BlockFile, measurement: Measurement, group: Group, log: ImportLog) -> RemoteTime | None:
    """The time of a group whose master is elsewhere; None where that cannot be read."""
    for data_group in measurement.data_groups:
        for other in data_group.groups:
            master = find_master(other)
            if (
                other.at == group.master_link
                and master is not None
                and len(data_group.groups) == 1
                and other.size
            ):
                stream = open_stream(file, data_group.data_link, measurement.unfinished, log)
                return RemoteTime(other, master, stream, log)
    return None
