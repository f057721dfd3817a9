"""What a file's name says before its content is looked at."""

from __future__ import annotations

DOUBLE = (".db3.zstd", ".mcap.zstd")
"""Suffixes of two parts."""

LOG_SUFFIXES = frozenset(
    (
        ".mcap", ".bag", ".active", ".db3", ".mf4", ".mdf", ".blf", ".parquet", ".pq", ".vbo", ".trc", ".asc", ".candump",
        ".csv", ".tsv", *DOUBLE,
    )
)  # fmt: skip
"""Suffixes that only a log has: such a file is a drive, though nothing may be able to read it."""

TABLE_SUFFIXES = frozenset((".csv", ".tsv"))
"""Those of tables of text, which may be tables of anything."""

NO_LOG_SUFFIXES = frozenset(
    (
        ".toml", ".dbc", ".md", ".rst", ".py", ".ipynb", ".json", ".jsonl", ".yaml", ".yml", ".xml", ".html", ".htm", ".css",
        ".js", ".pdf", ".png", ".jpg", ".jpeg", ".gif", ".svg", ".webp", ".bmp", ".tif", ".tiff", ".mp4", ".avi", ".mov",
        ".mkv", ".wav", ".mp3", ".doc", ".docx", ".xls", ".xlsx", ".ppt", ".pptx", ".odt", ".ods", ".zip", ".gz", ".tar",
        ".7z", ".rar", ".xz", ".exe", ".dll", ".so", ".m", ".slx", ".cfg", ".ini", ".bat", ".sh", ".ps1", ".sql", ".lock",
        ".sha256", ".md5", ".idx", ".kml", ".kmz", ".gpx", ".a2l", ".arxml",
    )
)  # fmt: skip
"""Files with these are not opened: no log, and each is said to be none."""

UNPACKED_BY = {
    ".gz": "gunzip",
    ".xz": "unxz",
    ".zip": "unzip",
    ".7z": "7z x",
    ".rar": "unrar x",
    ".zst": "zstd -d",
    ".bz2": "bunzip2",
}
"""What unpacks a file of each suffix."""

_QUIET_NAMES = frozenset(
    (
        "metadata.yaml", "import_record.json", "results.json", "results.archive.json", "report.html", "report.pdf", "fleet.html",
        "fleet.pdf", "tire_normal_forces.parquet",
    )
)  # fmt: skip
_QUIET_ENDS = (".toml", ".dbc", "truth.json", ".db3-wal", ".db3-shm", ".db3-journal")


def is_quiet(name: str) -> bool:
    """Whether a file is what cogest itself writes or reads beside logs: nobody needs to be told that it is no log."""
    lower = name.lower()
    return lower in _QUIET_NAMES or lower.endswith(_QUIET_ENDS)


def why_packed(name: str) -> str:
    """Why a file that is packed by its name is no log yet; "" for any other. Packed recordings of ROS 2 are read as they are."""
    inner, _, end = name.lower().rpartition(".")
    unpack = UNPACKED_BY.get(f".{end}", "")
    if not unpack or suffix_of(name) in LOG_SUFFIXES:
        return ""
    if suffix_of(inner) in LOG_SUFFIXES:
        return f"a packed log, by its name: unpack it ({unpack})"
    return f"packed: unpack it ({unpack}), if a log is in it"


def suffix_of(name: str) -> str:
    """The suffix in lower case, of two parts for some; "" where there is none."""
    lower = name.lower()
    double = next((end for end in DOUBLE if lower.endswith(end)), None)
    return double or (f".{lower.rpartition('.')[2]}" if "." in lower[1:] else "")
