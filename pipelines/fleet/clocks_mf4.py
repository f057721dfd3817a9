"""First and last stamp of an MF4 file from the first and last record of each group, without reading what lies between."""

from __future__ import annotations

from pathlib import Path

from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.clock import NO_TIME, find_master
from parsers.mf4.model import DataGroup
from parsers.mf4.records import record_size
from parsers.mf4.stamps import stamp_reader
from parsers.mf4.streams import open_stream
from parsers.mf4.tree import read_measurement


def mf4_ends(path: Path) -> tuple[int, int, bool] | None:
    """(first, last, whether they count from 1970) in ns; None where groups share a stream, so that all must be read.

    Raises LogError where the file's descriptions cannot be read.
    """
    log = ImportLog()
    ends: list[int] = []
    with BlockFile(path) as file:
        measurement = read_measurement(file, log)
        for data_group in measurement.data_groups:
            found = _ends(file, data_group, measurement.start_ns, measurement.unfinished, log)
            if found is None:
                return None
            ends += found
    return (min(ends), max(ends), measurement.start_ns > 0) if ends else None


def _ends(
    file: BlockFile, data_group: DataGroup, start_ns: int, unfinished: int, log: ImportLog
) -> list[int] | None:
    """First and last stamp of a data group, [] where it has no time or no record; None where it is not sorted."""
    if len(data_group.groups) != 1:
        return None if data_group.groups else []
    group = data_group.groups[0]
    master = find_master(group)
    if master is None:
        return []
    stream = open_stream(file, data_group.data_link, unfinished, log)
    size = record_size(group, stream) + data_group.id_size
    records = stream.size // size if size else 0
    if not records:
        return []
    reader = stamp_reader(master, group, start_ns, compiled=False)
    ends = []
    for k in {0, records - 1}:
        batch = Batch(group, k, stream.read(k * size, (k + 1) * size), 1, size, data_group.id_size)
        ends += [stamp for stamp in reader.read(batch)[0].tolist() if stamp != NO_TIME]
    return ends
