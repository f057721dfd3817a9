"""CAN frames as rows for the tests, and what the shared reader makes of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from parsers.can.frames import CanFrames
from parsers.can.reader import CanReader
from parsers.importer import ImportLog, ReadOptions

CAR = """VERSION ""

BU_: A

BO_ 291 Motion: 8 A
 SG_ YawRate : 0|16@1- (0.01,0) [0|0] "deg/s" A
 SG_ Speed : 23|16@0+ (0.01,0) [0|0] "km/h" A

BO_ 512 Muxed: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ Always : 8|8@1+ (1,0) [0|0] "" A
 SG_ Left m0 : 16|8@1+ (1,0) [0|0] "" A
 SG_ LeftToo m0 : 24|8@1- (1,0) [0|0] "" A
 SG_ Right m1 : 16|8@1+ (1,0) [0|0] "bar" A

BO_ 768 Absent: 8 A
 SG_ Nothing : 0|8@1+ (1,0) [0|0] "" A
"""


class Listed:
    """A FrameSource over rows (time_ns, can_id, bus, payload), `batch` rows at a time."""

    clock = "test clock"
    absolute = False
    start_utc_ns = None

    def __init__(self, rows: list[tuple[int, int, int, bytes]], log: ImportLog, batch: int = 3) -> None:
        self.rows, self.log, self.batch = rows, log, batch

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        for begin in range(0, len(self.rows), self.batch):
            rows = self.rows[begin : begin + self.batch]
            sizes = np.array([len(row[3]) for row in rows], dtype=np.int64)
            if counting:
                self.log.messages += len(rows)
            yield CanFrames(
                np.array([row[0] for row in rows], dtype=np.int64),
                np.array([row[1] for row in rows], dtype=np.uint32),
                np.array([row[2] for row in rows], dtype=np.int16),
                sizes.astype(np.uint8),
                np.cumsum(sizes) - sizes,
                np.frombuffer(b"".join(row[3] for row in rows), dtype=np.uint8),
            )


def open_rows(
    tmp_path: Path,
    rows: list[tuple[int, int, int, bytes]],
    *dbcs: str,
    buses: Mapping[str, tuple[int, ...]] | None = None,
) -> tuple[CanReader, ImportLog]:
    paths = []
    for index, text in enumerate(dbcs):
        path = tmp_path / f"db{index}.dbc"
        path.write_text(text, encoding="cp1252")
        paths.append(path)
    log = ImportLog()
    options = ReadOptions(dbc=tuple(paths), buses=buses or {})
    return CanReader(Listed(rows, log), options, log, tmp_path / "log"), log


def read_all(reader: CanReader, wanted: set[str] | None = None) -> dict[str, tuple[list[int], list[float]]]:
    """Channel -> (times, values), chunks joined."""
    names = frozenset(wanted if wanted is not None else (c.name for c in reader.channels))
    result: dict[str, tuple[list[int], list[float]]] = {}
    for chunk in reader.read(names):
        for name, values in chunk.columns.items():
            times, column = result.setdefault(name, ([], []))
            times += chunk.time_ns.tolist()
            column += values.tolist()
    return result


def result(reader: CanReader, log: ImportLog) -> tuple[object, ...]:
    """All that a reader gives, NaN made comparable."""
    got = read_all(reader)
    values = {name: (times, [None if v != v else v for v in column]) for name, (times, column) in got.items()}
    return values, log.messages, dict(log.rejected), log.notes
