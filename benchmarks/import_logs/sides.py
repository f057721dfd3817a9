"""One log read by one side, cogest or a peer: from a file to columns in memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.import_logs.cases import Case, database_of

Columns = dict[str, list[np.ndarray]]
"""Channel -> its values in one or more pieces."""


def _wanted(case: Case, names: list[str]) -> frozenset[str]:
    """All channels of CAN and tables, the chosen ones of ROS."""
    from benchmarks.import_logs.ros_logs import WANTED

    return frozenset(WANTED if case.name.startswith("ros") else names)


def ours(case: Case, folder: Path) -> Columns:
    """Read with cogest's importer; what it wrote down must be a whole log with nothing rejected."""
    from parsers.importer import ImportLog, ReadOptions
    from parsers.registry import find_importer

    path, log = folder / case.file, ImportLog()
    reader = find_importer(path).open(path, ReadOptions(dbc=(database_of(case, folder),)), log)
    wanted = _wanted(case, [info.name for info in reader.channels if info.kind == "number"])
    columns: Columns = {}
    for chunk in reader.read(wanted):
        for name, values in chunk.columns.items():
            columns.setdefault(name, []).append(values)
    if log.status != "complete" or log.rejected:
        raise RuntimeError(f"{case.name}: {log.status}, rejected {dict(log.rejected)}: {log.notes}")
    return columns


def theirs(peer: str, case: Case, folder: Path) -> Columns:
    """Read with a peer."""
    from benchmarks.import_logs import peers
    from benchmarks.import_logs.ros_logs import FIELDS, WANTED

    second: dict[str, tuple[object, ...]] = {
        "python_can": (database_of(case, folder),),
        "asammdf": (database_of(case, folder),),
        "rosbags": (WANTED,),
        "mcap_json": (FIELDS,),
        "mcap_protobuf": (FIELDS,),
    }
    columns = getattr(peers, peer)(folder / case.file, *second.get(peer, ()))
    return {name: [values] for name, values in columns.items()}


def differences(ours: Columns, theirs: Columns) -> list[str]:
    """In words, where two sides differ: channels and values. Numbers must be equal to the last bit, or but for it.

    Channels that only one side counts as such (the peer's time column) are passed over, if no more than two.
    """
    common = ours.keys() & theirs.keys()
    problems = (
        [] if len(theirs) - len(common) <= 2 and common else [f"channels {sorted(theirs)} / {sorted(ours)}"]
    )
    for name in sorted(common):
        a = np.concatenate(ours[name])
        b = np.concatenate(theirs[name]).astype(np.float64)
        if a.shape != b.shape:
            problems.append(f"{name}: {a.size} / {b.size} values")
        elif not bool((np.abs(a - b) <= np.spacing(np.abs(b))).all()):
            problems.append(f"{name}: values differ by up to {np.nanmax(np.abs(a - b)):g}")
    return problems
