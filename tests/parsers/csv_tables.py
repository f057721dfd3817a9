"""Text tables for the tests, read whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.csv_log import CsvImporter, CsvReader
from parsers.importer import ImportLog, ReadOptions

T = [0, 10_000_000, 20_000_000, 30_000_000]


class Read:
    """A table read whole."""

    def __init__(self, path: Path, options: ReadOptions | None = None) -> None:
        self.log = ImportLog()
        head = path.read_bytes()[:4096]
        assert CsvImporter().claims(path, head)
        self.reader: CsvReader = CsvImporter().open(path, options or ReadOptions(), self.log)
        self.info = {channel.name: channel for channel in self.reader.channels}
        numbers = frozenset(name for name, channel in self.info.items() if channel.kind == "number")
        chunks = list(self.reader.read(numbers))
        self.time: IntArray = np.concatenate([chunk.time_ns for chunk in chunks])
        self.columns: dict[str, FloatArray] = {
            name: np.concatenate([chunk.columns[name] for chunk in chunks]) for name in numbers
        }

    @property
    def said(self) -> str:
        return "\n".join(self.log.notes)


def read(
    tmp_path: Path, text: str | bytes, options: ReadOptions | None = None, name: str = "log.csv"
) -> Read:
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return Read(path, options)


PLAIN = "t [s],AX [g],AY [m/s^2]\n0,0.5,9.81\n0.01,-1.25,0\n0.02,3,-2.5\n0.03,1e-3,7.0\n"
