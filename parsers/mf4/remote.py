"""Time from another group (MDF 4.2, column-oriented files: the master channel has a group of its own)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.clock import find_master
from parsers.mf4.model import Group, Measurement
from parsers.mf4.records import record_size
from parsers.mf4.stamps import StampReader, stamp_reader
from parsers.mf4.streams import DataStream, open_stream


@dataclass
class RemoteTime:
    """The time channel of another group, read alongside: record n here has the time of record n there."""

    group: Group
    stamps: StampReader
    stream: DataStream
    log: ImportLog
    id_size: int = 0

    def times(self, batch: Batch) -> tuple[Batch, IntArray, int]:
        """The batch as far as there are times for it, those times, and how many of them are NO_TIME."""
        size = record_size(self.group, self.stream) + self.id_size
        count = min(batch.count, max(0, self.stream.size // max(size, 1) - batch.first))
        try:
            raw = self.stream.read(batch.first * size, (batch.first + count) * size)
        except LogError as error:
            self.log.worsen(
                "malformed", f"the time of channel group {batch.group.number} is damaged: {error.problem}"
            )
            count, raw = 0, np.zeros(0, np.uint8)
        if count < batch.count:
            self.log.reject("record without a time", batch.count - count)
        there = Batch(self.group, batch.first, raw, count, size, self.id_size)
        time_ns, timeless = self.stamps.read(there)
        return batch.part(0, count), time_ns, timeless


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
                stamps = stamp_reader(master, other, measurement.start_ns, measurement.dates)
                return RemoteTime(other, stamps, stream, log, data_group.id_size)
    return None
