"""A listing's files as recordings: folders that are one recording whole (ROS 2 bags, converted drives), and single files."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from parsers.registry import importer_at
from parsers.ros.bag2_files import METADATA, bag_file, listed_files
from parsers.store_folder import RECORD_FILE
from pipelines.fleet.entries import Entry, Listing, path_of
from pipelines.fleet.heads import Heads
from pipelines.fleet.logs import Log

_ROSBAG2 = "parsers.rosbag2_log:RosBag2Importer"
_PARQUET = "parsers.parquet_log:ParquetImporter"
_BESIDE = (".parquet", ".pq", ".json", ".toml", ".md")


@dataclass
class Recordings:
    """Recordings by the folder below the fleet's that they lie in. joint: lists of those that are one drive for certain.

    left_out: (place, why) of files that are none.
    """

    single: dict[str, list[Log]] = field(default_factory=lambda: defaultdict(list))
    joint: list[tuple[tuple[Log, ...], str]] = field(default_factory=list)
    left_out: list[tuple[str, str]] = field(default_factory=list)

    @property
    def by_name(self) -> dict[str, Log]:
        """All recordings by their names below the fleet's folder."""
        joint = [log for logs, _ in self.joint for log in logs]
        return {log.below: log for log in (*joint, *(log for row in self.single.values() for log in row))}


def recordings(listing: Listing, heads: Heads) -> Recordings:
    """Find all recordings in a listing."""
    out = Recordings()
    by_folder: dict[str, list[Entry]] = defaultdict(list)
    for entry in listing.entries:
        by_folder[entry.folder].append(entry)
    rest = [
        e for folder, row in by_folder.items() for e in _whole_folder(listing.root, folder, row, out, heads)
    ]
    for entry, found in heads.look_at_all(rest):
        if isinstance(found, Log):
            out.single[entry.folder].append(found)
        elif found is not None:
            out.left_out.append((entry.place, found))
    return out


def _whole_folder(
    root: str, folder: str, entries: Sequence[Entry], out: Recordings, heads: Heads
) -> Sequence[Entry]:
    """Take a folder that is a recording; the files that are then still to be looked at."""
    names = {entry.name: entry for entry in entries}
    if METADATA in names and b"rosbag2_bagfile_information" in _begin(names[METADATA]):
        return _bag(root, folder, entries, out)
    tables = [entry for entry in entries if entry.name.lower().endswith((".parquet", ".pq"))]
    if RECORD_FILE in names and tables:
        return _converted(root, folder, entries, tables, out, heads)
    return entries


def _begin(entry: Entry) -> bytes:
    try:
        with entry.path.open("rb") as file:
            return file.read(4096)
    except OSError:
        return b""


def _folder_log(root: str, folder: str, entries: Sequence[Entry], line: str) -> Log:
    importer = importer_at(line)
    return Log(
        place=_place(root, folder, entries),
        below=folder or ".",
        size=sum(entry.size for entry in entries),
        stem=folder.rpartition("/")[2],
        format=importer.name,
        title=importer.title,
        changed=max(entry.changed for entry in entries),
    )


def _place(root: str, folder: str, entries: Sequence[Entry]) -> str:
    """A folder's place, as its files have it."""
    entry = entries[0]
    return entry.place[: len(entry.place) - len(entry.name) - 1] if folder else root


def _bag(root: str, folder: str, entries: Sequence[Entry], out: Recordings) -> Sequence[Entry]:
    """A ROS 2 bag: the storage files that its metadata names are its own, and all where it names none of them."""
    storage = [entry for entry in entries if bag_file(path_of(entry.place)) is not None]
    listed = set(listed_files(path_of(_place(root, folder, entries))))
    own = [entry for entry in storage if entry.name in listed] or storage
    log = _folder_log(root, folder, own or entries, _ROSBAG2)
    out.single[folder.rpartition("/")[0]].append(log)
    return [entry for entry in entries if entry not in own]


def _converted(
    root: str, folder: str, entries: Sequence[Entry], tables: Sequence[Entry], out: Recordings, heads: Heads
) -> Sequence[Entry]:
    """What `cogest convert` wrote: one drive, as a folder where nothing else lies in it."""
    rest = [entry for entry in entries if entry not in tables]
    if all(entry.name.lower().endswith(_BESIDE) or entry.name.startswith("_") for entry in entries):
        out.single[folder.rpartition("/")[0]].append(_folder_log(root, folder, tables, _PARQUET))
        return rest
    logs = tuple(found for entry in tables if isinstance(found := heads.look(entry), Log))
    if logs:
        out.joint.append((logs, "a drive that cogest convert wrote: one file a rate"))
    return rest
