"""MF4 logs for the tests, read whole."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from parsers.channels import Chunk
from parsers.importer import ImportLog, ReadOptions
from parsers.mf4.reader import Mf4Reader, open_mf4

START = datetime(2024, 5, 6, 7, 8, 9, 250_000, tzinfo=UTC)


def opened(path: Path, *dbc: Path) -> tuple[Mf4Reader, ImportLog]:
    log = ImportLog()
    return open_mf4(path, ReadOptions(dbc=dbc), log), log


def read_all(reader: Mf4Reader) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Channel -> (time_ns, values) over all chunks."""
    return gathered(list(reader.read(frozenset(c.name for c in reader.channels))))


def gathered(chunks: list[Chunk]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for chunk in chunks:
        for name, values in chunk.columns.items():
            assert values.dtype == np.float64
            parts.setdefault(name, []).append((chunk.time_ns, values))
    return {
        name: (np.concatenate([p[0] for p in some]), np.concatenate([p[1] for p in some]))
        for name, some in parts.items()
    }
