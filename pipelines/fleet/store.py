"""The results store: a folder a drive, written whole or not at all, and the fleet's tables above them.

store.json                                    format number
drives/<2 hex>/<drive_id>/drive.json          key, status, the drive as found, facts of its inputs, sizes and hashes of the
                                              files beside it
                          rows.json           what the fleet's tables take from the drive
                          relations.parquet   what the drive told, for joining it with others
                          results.json, results.archive.json, report.html …
drives.parquet, parameters.parquet …          tables (`pipelines.fleet.tables`); tables.json: sizes and hashes of them
vehicles/<2 hex>/<hash>.json                  a vehicle's drives as they were joined last (`pipelines.fleet.joined`)
claims/<drive_id>.json                        drives that a batch is working on (`pipelines.fleet.claims`)
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING

from parsers.errors import StoreError
from pipelines.fleet.plain import from_plain, json_bytes, read_json
from pipelines.fleet.records import Facts, FoundDrive
from pipelines.fleet.storage import MARK, Storage
from pipelines.fleet.storage_at import storage_at
from pipelines.fleet.stored import DRIVES, Catalogue, Sealed, StoredDrive, folder_of, sealed, shown

if TYPE_CHECKING:
    import polars as pl

    from pipelines.drive_results import DriveResults
    from pipelines.fleet.rows import DriveRows
    from pipelines.joint.kept import KeptRelations

__all__ = ["FORMAT", "STORE_FILE", "Catalogue", "Sealed", "Store", "StoredDrive", "folder_of", "open_store"]

FORMAT = 1
STORE_FILE = "store.json"
TABLES_FILE = "tables.json"
MOST_MARK_BYTES = 16 * 2**20
"""No drive.json is larger."""
LOOKS = 3
"""Times that what is not as it should be is looked at: another process may be replacing it just then."""


def open_store(place: str, *, create: bool = False) -> Store:
    """The store at a path or URL. create: make one of an empty or missing folder, and tidy up what killed runs left.

    Raises StoreError: no store there, one of a newer cogest, or a folder that holds something else.
    """
    return Store(storage_at(place), create=create)


class Store:
    """A results store on any storage. Safe to use from several processes and machines at once."""

    def __init__(self, storage: Storage, *, create: bool = False) -> None:
        """See `open_store`."""
        self.storage = storage
        content = storage.read(STORE_FILE)
        if content is None:
            self._begin(create)
        else:
            self._check(content)
        if create:
            storage.sweep()

    @property
    def place(self) -> str:
        """Where the store is, as the user gave it."""
        return self.storage.place

    def _begin(self, create: bool) -> None:
        if not create:
            raise StoreError(
                f"no results store ({STORE_FILE} is missing)",
                path=self.place,
                hint="`cogest batch` makes one with --out",
            )
        names = [name for name in self.storage.names("") if not name.startswith(".")]
        made = self.storage.read(STORE_FILE) if names else None
        if made is not None:
            # by another batch that began at the same time
            self._check(made)
            return
        if names:
            raise StoreError(
                f"holds {names[0]!r} and is no results store",
                path=self.place,
                hint="give an empty folder with --out",
            )
        if not self.storage.create(STORE_FILE, json_bytes({"cogest_store": FORMAT})):
            self._check(self.storage.read(STORE_FILE) or b"")

    def _check(self, content: bytes) -> None:
        try:
            number = read_json(content).get("cogest_store")
        except StoreError as error:
            raise StoreError(f"{STORE_FILE}: {error}", path=self.place) from error
        if not isinstance(number, int) or isinstance(number, bool) or number < 1:
            raise StoreError(f"{STORE_FILE} is not that of a results store", path=self.place)
        if number > FORMAT:
            raise StoreError(
                f"a store of format {number}, this cogest reads {FORMAT}",
                path=self.place,
                hint="install a newer cogest",
            )

    # drives -----------------------------------------------------------------------------------------------------------

    def stored(self, drive_id: str) -> StoredDrive | None:
        """The drive as stored; None where it is not, or its folder is damaged (`damage` says how)."""
        found = self._seen(drive_id, self.storage.tree(folder_of(drive_id)))
        return found if isinstance(found, StoredDrive) else None

    def damage(self, drive_id: str) -> str | None:
        """What is wrong with the drive's folder, None where nothing is or there is none."""
        found = self._seen(drive_id, self.storage.tree(folder_of(drive_id)))
        return found if isinstance(found, str) else None

    def all(self) -> Catalogue:
        """All drives of the store, by drive_id."""
        folders: dict[str, dict[str, int]] = {}
        for name, size in self.storage.tree(DRIVES).items():
            folder, _, _ = name.rpartition("/")
            folders.setdefault(folder, {})[name] = size
        # what does not lie where a drive of that name belongs is none of ours
        ids = {folder: folder.rpartition("/")[2] for folder in folders}
        mine = sorted(
            id_ for folder, id_ in ids.items() if folder.count("/") == 2 and folder_of(id_) == folder
        )
        with ThreadPoolExecutor(self.storage.parallel) as pool:
            looked = list(pool.map(lambda id_: self._seen(id_, folders[folder_of(id_)]), mine))
        pairs = list(zip(mine, looked, strict=True))
        return Catalogue(
            {id_: found for id_, found in pairs if isinstance(found, StoredDrive)},
            {id_: found for id_, found in pairs if isinstance(found, str)},
        )

    def _seen(self, drive_id: str, there: Mapping[str, int]) -> StoredDrive | str | None:
        """As `_look`, of a folder that another batch may have replaced since its files were listed: that is no damage."""
        found = self._look(drive_id, there)
        for _ in range(LOOKS):
            if not isinstance(found, str):
                break
            before, found = found, self._look(drive_id, self.storage.tree(folder_of(drive_id)))
            if found == before:
                break
        return found

    def _look(self, drive_id: str, there: Mapping[str, int]) -> StoredDrive | str | None:
        """The drive, what is wrong with its folder, or None where there is no folder. there: its files."""
        folder = folder_of(drive_id)
        if not there:
            return None
        mark = there.get(f"{folder}/{MARK}")
        if mark is None:
            return f"{MARK} is missing"
        if mark > MOST_MARK_BYTES:
            return f"{MARK} is larger than any"
        content = self.storage.read(f"{folder}/{MARK}")
        if content is None:
            return f"{MARK} is missing"
        try:
            stored = from_plain(StoredDrive, read_json(content))
        except StoreError as error:
            return f"{MARK}: {error}"
        if stored.drive.drive_id != drive_id:
            return f"{MARK} is that of drive {stored.drive.drive_id[:80]!r}"
        for name, seal in stored.files.items():
            found = there.get(f"{folder}/{name}")
            if found is None:
                return f"{name} is missing"
            if found != seal.size:
                return f"{name} has {found} bytes, {seal.size} were written"
        return stored

    def put(
        self,
        drive: FoundDrive,
        key: str,
        facts: Mapping[str, Facts],
        results: DriveResults,
        kept: KeptRelations | None,
        files: Mapping[str, bytes],
    ) -> None:
        """Store a finished drive in place of what was there. files: results.json, the archive, reports …, by name."""
        from pipelines.fleet import relations_file, rows

        whole = {**files, rows.FILE_NAME: rows.rows_bytes(rows.rows_of(results))}
        if kept is not None:
            whole[relations_file.FILE_NAME] = relations_file.relations_bytes(kept)
        self._publish(StoredDrive(drive, key, "done", "", facts), whole)

    def put_failure(
        self, drive: FoundDrive, key: str, facts: Mapping[str, Facts], status: str, reason: str
    ) -> None:
        """Store that a drive failed, in place of what was there; older results went with what has changed since."""
        self._publish(StoredDrive(drive, key, status, reason, facts), {})

    def _publish(self, stored: StoredDrive, files: Mapping[str, bytes]) -> None:
        seals = {name: sealed(content) for name, content in sorted(files.items())}
        mark = json_bytes(shown(replace(stored, files=seals)))
        self.storage.publish(folder_of(stored.drive.drive_id), {**files, MARK: mark})

    def note(self, stored: StoredDrive, drive: FoundDrive, facts: Mapping[str, Facts]) -> None:
        """Bring a kept drive's description up to date: files touched but equal, other notes. Writes only what changed."""
        now = shown(replace(stored, drive=drive, facts=facts))
        if now == stored or self.stored(drive.drive_id) != stored:
            # another batch did the drive meanwhile: its description goes with its files, and this one does not
            return
        mark = json_bytes(now)
        self.storage.write(f"{folder_of(drive.drive_id)}/{MARK}", mark)

    def doubt(self, stored: StoredDrive) -> None:
        """Mark a drive as to be done again, as a file of it is not what was written: it has no key any more. One that was replaced since stays."""
        if self.stored(stored.drive.drive_id) != stored:
            return
        self.storage.write(f"{folder_of(stored.drive.drive_id)}/{MARK}", json_bytes(replace(stored, key="")))

    def forget(self, drive_id: str) -> None:
        """Take a drive out of the store."""
        self.storage.remove(folder_of(drive_id))

    def file(self, stored: StoredDrive, name: str) -> bytes | None:
        """A file of a drive's folder, None where the drive has none. Raises StoreError where it is not what was written."""
        seal = stored.files.get(name)
        if seal is None:
            return None
        folder = folder_of(stored.drive.drive_id)
        content = self.storage.read(f"{folder}/{name}")
        if content is None or sealed(content) != seal:
            problem = "is missing" if content is None else "is not what was written there"
            raise StoreError(
                problem, path=self.storage.at(f"{folder}/{name}"), hint="run `cogest batch` again"
            )
        return content

    def rows(self, stored: StoredDrive) -> DriveRows | None:
        """What the tables take from a drive; None for a failed one. Raises StoreError where the file is damaged."""
        from pipelines.fleet import rows

        content = self.file(stored, rows.FILE_NAME)
        return None if content is None else rows.rows_from(content)

    def kept(self, drive: StoredDrive | str) -> KeptRelations | None:
        """What a drive's relations told; None where it told nothing. drive: as stored, or its id. Raises StoreError."""
        from pipelines.fleet import relations_file

        stored = self.stored(drive) if isinstance(drive, str) else drive
        content = None if stored is None else self.file(stored, relations_file.FILE_NAME)
        return None if content is None else relations_file.relations_from(content)

    def report(self, stored: StoredDrive, name: str = "report.html") -> str | None:
        """The drive's report as a name below the store, None where it has none."""
        return f"{folder_of(stored.drive.drive_id)}/{name}" if name in stored.files else None

    # tables -----------------------------------------------------------------------------------------------------------

    def write_tables(self, tables: Mapping[str, pl.DataFrame]) -> None:
        """Write tables by name, each whole or not at all; one that did not change is left alone."""
        from pipelines.fleet.table_files import table_bytes

        made = {name: table_bytes(table) for name, table in tables.items()}
        new = {name: sealed(content) for name, content in made.items()}
        known = self._table_seals()
        both = {name: list(dict.fromkeys([*known.get(name, []), seal])) for name, seal in new.items()}
        # while tables are replaced, each is either what it was or what it becomes
        self._write_changed(TABLES_FILE, json_bytes(both))
        for name, content in made.items():
            self._write_changed(f"{name}.parquet", content)
        self._write_changed(TABLES_FILE, json_bytes({name: [seal] for name, seal in new.items()}))

    def _write_changed(self, name: str, content: bytes) -> None:
        if self.storage.read(name) != content:
            self.storage.write(name, content)

    def _table_seals(self) -> dict[str, list[Sealed]]:
        """What each table may be; nothing where that is not known."""
        content = self.storage.read(TABLES_FILE)
        try:
            raw = read_json(content or b"")
            return {name: [from_plain(Sealed, seal) for seal in seals] for name, seals in raw.items()}
        except (StoreError, TypeError):
            return {}

    def read_table(self, name: str, where: pl.Expr | None = None) -> pl.DataFrame:
        """A table by name, or these rows of it. Raises StoreError where it is not there yet, or is not what was written."""
        from pipelines.fleet.table_files import check_name, table_from

        check_name(name)
        place = self.storage.at(f"{name}.parquet")
        for _ in range(LOOKS):
            content = self.storage.read(f"{name}.parquet")
            if content is None or sealed(content) in self._table_seals().get(name, []):
                break
            # a batch may have ended between the two readings
        if content is None:
            hint = "it is written when `cogest batch` has ended"
            raise StoreError("the table is not there yet", path=place, hint=hint)
        # reading damaged Parquet can end the whole process: its hash comes first
        if sealed(content) not in self._table_seals().get(name, []):
            raise StoreError("is not what was written there", path=place, hint="run `cogest batch` again")
        return table_from(content, name, place, where)
