"""ROS 2 bags: SQLite or MCAP storage, a folder with or without metadata.yaml or a single file, split, compressed."""

from __future__ import annotations

from pathlib import Path

from parsers.importer import ImportLog, LogReader, ReadOptions

SQLITE_MAGIC = b"SQLite format 3\x00"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


class RosBag2Importer:
    """ROS 2 bags. Single .mcap files are the MCAP importer's; those in a bag folder are handed to it from here."""

    name = "rosbag2"
    title = "ROS 2 bag"
    suffixes = (".db3", ".db3.zstd", ".mcap.zstd")

    def claims(self, path: Path, head: bytes) -> bool:
        """A folder with metadata.yaml or storage files; an SQLite file with a bag's tables, compressed or not."""
        # decoders load only when the first bytes say that this may be a bag
        if path.is_dir():
            from parsers.ros.bag2_files import is_bag_folder

            try:
                return is_bag_folder(path)
            except OSError:
                return False
        if head.startswith(SQLITE_MAGIC):
            from parsers.ros.bag2_database import is_bag

            return is_bag(path)
        if head.startswith(ZSTD_MAGIC):
            from parsers.ros.bag2_files import bag_file

            return bag_file(path) is not None
        return False

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Open a bag. Raises LogError where nothing of it can be used; says in the log book what could not be."""
        from parsers.rosbag2_reader import open_bag

        return open_bag(path, options, log)
