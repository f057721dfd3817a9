"""ROS 1 bags: how they are recognised. The decoders load only when one is opened."""

from __future__ import annotations

from pathlib import Path

from parsers.importer import ImportLog, LogReader, ReadOptions


class RosBag1Importer:
    """ROS 1 bags."""

    name = "rosbag1"
    title = "ROS 1 bag"
    suffixes = (".bag",)

    def claims(self, path: Path, head: bytes) -> bool:
        """By the magic bytes, of any version."""
        return head.startswith(b"#ROSBAG V")

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Open a bag. Raises LogError where it is of another version, encrypted, or holds nothing."""
        from parsers.rosbag1_reader import open_bag

        return open_bag(path, options, log)
