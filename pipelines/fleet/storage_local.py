"""A store on a disk or a network folder: files and folders appear under their names by a rename, whole or not at all."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import sys
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from parsers.errors import StoreError
from pipelines.fleet.owner import alive, owner_from, this_process
from pipelines.fleet.storage import checked

PARTIAL = ".partial"
"""The folder in which files are written before they are renamed, each named after the process that writes it."""
OLD = ".old"
"""What a folder is called while its successor takes its place, where the system cannot exchange the two at once."""
FOREIGN_AGE_S = 24 * 3600.0
"""What another machine's process has not touched for so long is taken for left behind."""
_ATTEMPTS = 50


@cache
def _exchanger() -> ctypes._NamedFuncPointer | None:
    """Linux's renameat2, which can exchange two names in one step."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        return ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return None


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; False where the system or the file system cannot."""
    renameat2 = _exchanger()
    if renameat2 is None:
        return False
    here, exchange = -100, 2  # AT_FDCWD, RENAME_EXCHANGE
    return bool(renameat2(here, os.fsencode(one), here, os.fsencode(other), exchange) == 0)


def _sync_folder(folder: Path) -> None:
    """Bring a folder's names to the disk, where the system lets one."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _write_synced(path: Path, content: bytes) -> None:
    with path.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _take_away(path: Path) -> None:
    """Remove a file or a folder; someone else may be doing so too."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
        return
    path.unlink(missing_ok=True)


class LocalStorage:
    """A folder as a store's place. Nothing is made before the first write."""

    parallel = 1

    def __init__(self, place: str | Path) -> None:
        """place: the folder; it need not be there yet."""
        self.place = str(place)
        self._root = Path(place)

    def at(self, name: str) -> str:
        """The file's path."""
        return str(self._root / checked(name)) if name else self.place

    @contextmanager
    def _errors(self, name: str, doing: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            where = self._root / name if name else self._root
            raise StoreError(f"cannot be {doing} ({error.strerror or error})", path=where) from error

    def read(self, name: str) -> bytes | None:
        """See `Storage`."""
        with self._errors(name, "read"):
            try:
                return (self._root / checked(name)).read_bytes()
            except (FileNotFoundError, NotADirectoryError):
                return None

    def names(self, folder: str) -> Sequence[str]:
        """See `Storage`."""
        with self._errors(folder, "listed"):
            try:
                return sorted(n for n in os.listdir(self._root / folder) if n != PARTIAL)
            except FileNotFoundError:
                return ()

    def tree(self, folder: str) -> Mapping[str, int]:
        """See `Storage`."""
        found: dict[str, int] = {}
        with self._errors(folder, "listed"):
            self._walk(folder, found)
        return found

    def _walk(self, folder: str, found: dict[str, int]) -> None:
        try:
            entries = sorted(os.scandir(self._root / folder), key=lambda e: e.name)
        except (FileNotFoundError, NotADirectoryError):
            return
        for entry in entries:
            name = f"{folder}/{entry.name}" if folder else entry.name
            if entry.name.startswith("."):
                continue
            with contextlib.suppress(FileNotFoundError):
                if entry.is_dir(follow_symlinks=False):
                    self._walk(name, found)
                else:
                    found[name] = entry.stat().st_size

    def _partial(self) -> Path:
        """A name in the folder of what is half written that no one else has."""
        folder = self._root / PARTIAL
        folder.mkdir(parents=True, exist_ok=True)
        return folder / f"{this_process().text}~{uuid.uuid4().hex[:12]}"

    def write(self, name: str, content: bytes) -> None:
        """See `Storage`."""
        target = self._root / checked(name)
        with self._errors(name, "written"):
            partial = self._partial()
            try:
                _write_synced(partial, content)
                target.parent.mkdir(parents=True, exist_ok=True)
                os.replace(partial, target)
                _sync_folder(target.parent)
            finally:
                partial.unlink(missing_ok=True)

    def create(self, name: str, content: bytes) -> bool:
        """See `Storage`."""
        target = self._root / checked(name)
        with self._errors(name, "written"):
            partial = self._partial()
            try:
                _write_synced(partial, content)
                target.parent.mkdir(parents=True, exist_ok=True)
                try:
                    os.link(partial, target)
                except FileExistsError:
                    return False
                except OSError:
                    # a file system without hard links: the name is taken first, the content follows
                    return self._create_plainly(target, content)
                return True
            finally:
                partial.unlink(missing_ok=True)

    @staticmethod
    def _create_plainly(target: Path, content: bytes) -> bool:
        try:
            _write_synced(target, content)
        except FileExistsError:
            return False
        return True

    def publish(self, folder: str, files: Mapping[str, bytes]) -> None:
        """See `Storage`."""
        target = self._root / checked(folder)
        with self._errors(folder, "written"):
            partial = self._partial()
            try:
                partial.mkdir()
                for name, content in files.items():
                    _write_synced(partial / checked(name), content)
                _sync_folder(partial)
                target.parent.mkdir(parents=True, exist_ok=True)
                self._place(partial, target)
                _sync_folder(target.parent)
            finally:
                _take_away(partial)

    def _place(self, new: Path, target: Path) -> None:
        """Put a folder in the place of another. Another process may be doing the same, or tidying up."""
        aside = target.with_name(f".{target.name}.{uuid.uuid4().hex[:12]}{OLD}")
        try:
            for attempt in range(_ATTEMPTS):
                problem = self._try_to_place(new, target, aside)
                if problem is None:
                    return
                time.sleep(0.001 * attempt)
            raise problem or OSError("others keep writing it")
        finally:
            if aside.exists():
                self._bring_back(aside)

    @staticmethod
    def _try_to_place(new: Path, target: Path, aside: Path) -> OSError | None:
        """One attempt; None where it went well."""
        try:
            # where there is no folder, or an empty one
            os.rename(new, target)
            return None
        except OSError as error:
            problem = error
        if not target.exists():
            return problem
        if _exchange(new, target):
            return None
        _take_away(aside)
        try:
            os.rename(target, aside)
            os.rename(new, target)
        except OSError as error:
            return error
        return None

    def remove(self, name: str) -> None:
        """See `Storage`."""
        target = self._root / checked(name)
        with self._errors(name, "removed"):
            if target.is_dir() and not target.is_symlink():
                # gone at once, whenever the process is killed
                aside = self._partial()
                with contextlib.suppress(FileNotFoundError):
                    os.rename(target, aside)
                target = aside
            _take_away(target)

    def sweep(self) -> None:
        """See `Storage`."""
        folder = self._root / PARTIAL
        with self._errors("", "swept"):
            if not self._root.is_dir():
                return
            for aside in self._root.glob(f"drives/*/.*{OLD}"):
                self._bring_back(aside)
            if not folder.is_dir():
                return
            now = self._now(folder)
            for path in list(folder.iterdir()):
                owner = owner_from(path.name.rpartition("~")[0])
                lives = alive(owner) if owner else None
                if lives is False or (lives is None and self._age_s(path, now) > FOREIGN_AGE_S):
                    _take_away(path)

    @staticmethod
    def _bring_back(aside: Path) -> None:
        """A folder that stood aside when its writer was killed: back if its successor never came, else away."""
        target = aside.with_name(aside.name[1 : -len(OLD)].rpartition(".")[0])
        if target.exists():
            _take_away(aside)
            return
        with contextlib.suppress(OSError):
            os.rename(aside, target)

    @staticmethod
    def _now(folder: Path) -> float:
        """The time by the clock that stamps files there, which on a network folder is another machine's."""
        probe = folder / f"{this_process().text}~{uuid.uuid4().hex[:12]}"
        probe.touch()
        try:
            return probe.stat().st_mtime
        finally:
            probe.unlink(missing_ok=True)

    @staticmethod
    def _age_s(path: Path, now: float) -> float:
        try:
            return now - path.stat().st_mtime
        except FileNotFoundError:
            return 0.0
