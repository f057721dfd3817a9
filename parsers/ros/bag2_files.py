"""Which files make up a ROS 2 bag: a folder with or without metadata.yaml, split and compressed recordings."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING
from weakref import finalize

from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.places import remote

if TYPE_CHECKING:
    from parsers.places_path import RemotePath

METADATA = "metadata.yaml"
_NAME = re.compile(r"^(?P<stem>.+?)(?:_(?P<number>\d+))?\.(?P<kind>db3|mcap)(?:\.zstd)?$", re.IGNORECASE)
_LISTED = re.compile(r"^\s*relative_file_paths:\s*\n((?:\s*-[^\n]*\n?)*)", re.MULTILINE)
_BLOCK = 1 << 20
_SPARE_DISK = 1 << 28


@dataclass(frozen=True)
class BagFile:
    """One storage file. path: as the user has it. kind: "db3" or "mcap"."""

    path: Path
    kind: str
    compressed: bool


@dataclass
class Scratch:
    """A folder for copies and unpacked files; made when first asked for, removed with this object."""

    folder: Path | None = None
    _finalizer: object = field(default=None, repr=False)

    def place(self, name: str, size: int) -> Path:
        """A path in the folder for a file of `size` bytes. Raises LogError where the disk has no room for it."""
        if self.folder is None:
            self.folder = Path(mkdtemp(prefix="cogest-"))
            self._finalizer = finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        if size + _SPARE_DISK > shutil.disk_usage(self.folder).free:
            raise LogError(
                f"{size / 1e9:.1f} GB would be needed in {self.folder.parent} to open {name}",
                hint="free some space, or set TMPDIR to a larger disk",
            )
        return self.folder / name


def bag_file(path: Path) -> BagFile | None:
    """A path as a storage file, None where its name is not that of one."""
    match = _NAME.match(path.name)
    if match is None:
        return None
    return BagFile(path, match["kind"].lower(), path.name.lower().endswith(".zstd"))


def _natural(path: Path) -> tuple[str, int, str]:
    match = _NAME.match(path.name)
    if match is None:
        return path.name, -1, ""
    return match["stem"], int(match["number"] or -1), path.name


def present_files(folder: Path) -> list[Path]:
    """Storage files in a folder, in the order of their numbers."""
    return sorted((p for p in folder.iterdir() if p.is_file() and _NAME.match(p.name)), key=_natural)


def is_bag_folder(folder: Path) -> bool:
    """Whether a folder looks like a bag: it holds storage files, or a bag's metadata.yaml."""
    if present_files(folder):
        return True
    metadata = folder / METADATA
    if not metadata.is_file():
        return False
    with metadata.open("rb") as stream:
        return b"rosbag2_bagfile_information" in stream.read(_BLOCK)


def listed_files(folder: Path) -> list[str]:
    """File names that metadata.yaml lists, in its order; empty where there is no metadata that says so."""
    try:
        with (folder / METADATA).open("r", encoding="utf-8", errors="replace") as stream:
            text = stream.read(_BLOCK * 16)
    except OSError:
        return []
    found = _LISTED.search(text)
    if found is None:
        return []
    names = [line.strip().lstrip("-").strip().strip("'\"") for line in found.group(1).splitlines()]
    # old versions wrote the folder's name too; nothing outside the folder is ever opened
    return [name.replace("\\", "/").rsplit("/", 1)[-1] for name in names if name]


def bag_files(folder: Path, log: ImportLog) -> list[BagFile]:
    """The files of the bag in a folder. Raises LogError where there are none, or those of several recordings."""
    present = {path.name: path for path in present_files(folder)}
    listed = listed_files(folder)
    missing = [name for name in listed if name not in present]
    named = [present[name] for name in listed if name in present]
    if not present:
        what = (
            f"{METADATA} names {missing[0]}, which is not there"
            if missing
            else "no .db3 or .mcap file in this folder"
        )
        raise LogError(what, path=folder, hint="check that the whole bag folder was copied")
    if missing:
        log.worsen("truncated", f"{METADATA} names {', '.join(missing[:4])}, which is not in the folder")
    if not named:
        stems = sorted({_natural(path)[0] for path in present.values()})
        if len(stems) > 1:
            raise LogError(
                f"the folder holds {len(stems)} different recordings ({', '.join(stems[:4])})",
                path=folder,
                hint="name one file, or `cogest batch` for all of them",
            )
        named = list(present.values())
    extra = [name for name, path in present.items() if path not in named]
    if extra:
        log.note(f"not named by {METADATA}, so left out: {', '.join(extra[:4])}")
    return [file for file in map(bag_file, named) if file is not None]


def _downloaded(far: RemotePath, scratch: Scratch, log: ImportLog) -> Path:
    """An SQLite file of a store as a file of this disk, for its library reads no other, with what lies beside it."""
    files = [far, *(each for each in map(far.with_name, unfinished(far.name)) if each.is_file())]
    total = sum(each.facts().size for each in files)
    for each in files:
        target = scratch.place(each.name, each.facts().size)
        if not target.exists():
            each.copy_to(target)
    log.note(
        f"{far.name} was downloaded whole ({total} bytes) to a temporary file: SQLite reads files of a disk only"
    )
    return scratch.place(far.name, 0)


def unfinished(name: str) -> tuple[str, str]:
    """Files that a recorder leaves beside a database which it did not close."""
    return f"{name}-wal", f"{name}-journal"


def unpack(file: BagFile, scratch: Scratch, log: ImportLog) -> Path:
    """The path of a storage file that can be opened: unpacked into `scratch` where it is compressed as a whole.

    A compressed file that breaks off gives what could be unpacked, and the log book says so. Raises LogError.
    """
    if not file.compressed:
        far = remote(file.path)
        return file.path if far is None or file.kind == "mcap" else _downloaded(far, scratch, log)
    import zstandard

    target = scratch.place(file.path.name[: -len(".zstd")], file.path.stat().st_size)
    done = 0
    try:
        with file.path.open("rb") as source, target.open("wb") as sink:
            unpacker = zstandard.ZstdDecompressor(max_window_size=1 << 27).decompressobj()
            while block := source.read(_BLOCK):
                for start in range(0, len(block), _BLOCK // 64):
                    done += sink.write(unpacker.decompress(block[start : start + _BLOCK // 64]))
                scratch.place(target.name, 0)  # the disk still has room
            if not unpacker.eof:
                log.worsen(
                    "truncated", f"{file.path.name} breaks off inside its compressed data, after {done} bytes"
                )
    except zstandard.ZstdError as error:
        if not done:
            raise LogError(f"its zstd data are damaged ({error})", path=file.path) from error
        log.worsen("malformed", f"{file.path.name}: its zstd data are damaged after {done} bytes ({error})")
    return target
