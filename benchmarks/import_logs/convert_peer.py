"""The conversion of a CAN log to Parquet as a script of today does it: python-can, cantools, polars.

python benchmarks/import_logs/convert_peer.py LOG DBC OUT
"""

from __future__ import annotations

import sys
from pathlib import Path

import can
import cantools
import polars as pl


def main() -> None:
    """Decode frame by frame, then write one file a message."""
    log, dbc, out = sys.argv[1:]
    database = cantools.database.load_file(dbc)
    known = {message.frame_id: message for message in database.messages}
    tables: dict[str, dict[str, list[float]]] = {
        message.name: {"time_s": []} | {signal.name: [] for signal in message.signals}
        for message in database.messages
    }
    with can.LogReader(log) as reader:
        for frame in reader:
            message = known.get(frame.arbitration_id)
            if message is not None:
                table = tables[message.name]
                table["time_s"].append(frame.timestamp)
                for name, value in message.decode(frame.data).items():
                    table[name].append(value)
    Path(out).mkdir(exist_ok=True)
    for name, table in tables.items():
        pl.DataFrame(table).write_parquet(Path(out) / f"{name}.parquet", compression="zstd")


if __name__ == "__main__":
    main()
