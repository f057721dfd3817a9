"""One contract over every registered importer, on the sample logs of every format."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import CogestError
from parsers.importer import ImportLog, ReadOptions
from parsers.load import LoadOptions, load_drive
from parsers.mapping import MapFile, read_map
from parsers.mapping.map_file import MapEntry
from parsers.registry import FORMATS, find_importer, importers, read_head
from parsers.signals import SIGNALS

SAMPLES: dict[str, str] = {
    "csv/drive.csv": "csv",
    "tsv/drive.tsv": "csv",
    "vbo/drive.vbo": "vbo",
    "parquet/drive.parquet": "parquet",
    "can/drive.blf": "blf",
    "can/drive.asc": "asc",
    "can/drive.trc": "trc",
    "can/drive.log": "candump",
    "can/console.txt": "candump",
    "can/drive.mf4": "mf4",
    "mf4/drive.mf4": "mf4",
    "ros/drive.bag": "rosbag1",
    "ros/drive_sqlite3": "rosbag2",
    "ros/drive_mcap": "rosbag2",
    "ros/drive_ros1.mcap": "mcap",
    "ros/drive_ros2.mcap": "mcap",
    "mcap/drive_json.mcap": "mcap",
    "mcap/drive_protobuf.mcap": "mcap",
}
FILES = [name for name in SAMPLES if "." in Path(name).name]


def options_for(sample: Path) -> LoadOptions:
    """The mapping file and databases beside a sample, as the command finds them."""
    mapping = sample.parent / "map.toml"
    return LoadOptions(
        map=read_map(mapping, strict=False) if mapping.exists() else None,
        dbc=tuple(sorted(sample.parent.glob("*.dbc"))),
    )


def test_every_registered_importer_has_a_sample() -> None:
    assert {importer.name for importer in importers()} == set(SAMPLES.values())
    assert len({importer.name for importer in importers()}) == len(FORMATS)
    for importer in importers():
        assert importer.title
        assert all(suffix.startswith(".") and suffix == suffix.lower() for suffix in importer.suffixes)


@pytest.mark.parametrize("name", SAMPLES)
def test_claimed_by_its_importer(name: str, samples: Path) -> None:
    assert find_importer(samples / name).name == SAMPLES[name]


@pytest.mark.parametrize("name", SAMPLES)
def test_chunks_keep_the_contract(name: str, samples: Path) -> None:
    path = samples / name
    log = ImportLog()
    reader = find_importer(path).open(path, ReadOptions(dbc=options_for(path).dbc), log)
    infos = {info.name: info for info in reader.channels}
    assert len(infos) == len(reader.channels)
    numbers = [info.name for info in reader.channels if info.kind == "number"]
    wanted = frozenset(numbers[::2])
    rows = 0
    seen: set[str] = set()
    for chunk in reader.read(wanted):
        assert chunk.time_ns.dtype == np.int64
        assert set(chunk.columns) <= wanted
        for channel, values in chunk.columns.items():
            assert values.dtype == np.float64
            assert values.shape == chunk.time_ns.shape
            assert infos[channel].group == chunk.group
        seen |= set(chunk.columns)
        rows += len(chunk.time_ns)
    assert seen == wanted
    assert rows >= 1823
    assert log.status == "complete"
    assert log.messages > 0
    assert reader.clock


@pytest.mark.parametrize("name", FILES)
def test_wrong_suffix_changes_nothing(name: str, samples: Path, tmp_path: Path) -> None:
    copy = tmp_path / "drive.bin"
    shutil.copy(samples / name, copy)
    assert find_importer(copy).name == SAMPLES[name]


def _damaged(path: Path, kind: str) -> bytes:
    data = path.read_bytes()
    if kind == "truncated":
        cut = len(data) * 3 // 5
        while data[cut - 1] in b"\r\n " or data[cut] in b"\r\n":
            # a text log cut just behind a line, or in the blanks before the next, cannot be told from a whole one
            cut += 5
        return data[:cut]
    if kind == "cut early":
        return data[:100]
    if kind == "zeros in the middle":
        middle = len(data) // 2
        return data[:middle] + bytes(2000) + data[middle + 2000 :]
    middle = len(data) // 2
    noise = np.random.default_rng(3).integers(0, 256, 2000, dtype=np.uint8).tobytes()
    return data[:middle] + noise + data[middle + 2000 :]


def _expected_or_partial(path: Path, options: LoadOptions) -> Iterator[str]:
    """Load; yield what went wrong if neither a clear error nor a stated partial result came of it."""
    try:
        drive = load_drive([path], options)
    except CogestError as error:
        if str(path) not in str(error) or "\n" in str(error):
            yield f"unclear error: {error}"
        return
    record = drive.record
    # values of a page without a checksum are told from real ones only by what a vehicle can do
    removed = any(decision.applied and decision.kind == "spikes" for decision in record.decisions)
    if record.status == "complete" and not record.rejected and not removed:
        yield "called complete with nothing rejected"


@pytest.mark.parametrize("kind", ["truncated", "cut early", "zeros in the middle", "noise in the middle"])
@pytest.mark.parametrize("name", FILES)
def test_damage_is_an_error_or_a_stated_partial_result(
    name: str, kind: str, samples: Path, tmp_path: Path
) -> None:
    path = tmp_path / Path(name).name
    path.write_bytes(_damaged(samples / name, kind))
    assert not list(_expected_or_partial(path, options_for(samples / name)))


@pytest.mark.parametrize("kind", ["truncated", "zeros in the middle", "noise in the middle"])
@pytest.mark.parametrize("name", ["ros/drive_sqlite3", "ros/drive_mcap"])
def test_damaged_bag_folders(name: str, kind: str, samples: Path, tmp_path: Path) -> None:
    folder = tmp_path / Path(name).name
    shutil.copytree(samples / name, folder)
    for file in folder.iterdir():
        if file.suffix != ".yaml":
            file.write_bytes(_damaged(file, kind))
    assert not list(_expected_or_partial(folder, options_for(samples / name)))


@pytest.mark.parametrize("name", SAMPLES)
def test_no_usable_channel_is_one_clear_line(name: str, samples: Path) -> None:
    nothing = MapFile(Path("map.toml"), {name: MapEntry(name, "", ignore=True) for name in SIGNALS})
    options = LoadOptions(map=nothing, dbc=options_for(samples / name).dbc)
    with pytest.raises(CogestError, match="no channel maps to a signal") as caught:
        load_drive([samples / name], options)
    assert str(samples / name) in str(caught.value)
    assert "--write-map" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", sorted({s for importer in importers() for s in importer.suffixes}))
def test_an_empty_file_is_one_clear_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"drive{suffix}"
    path.touch()
    with pytest.raises(CogestError, match="empty") as caught:
        find_importer(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [b"hello\n", bytes(5000), b"\x89PNG\r\n\x1a\n" + bytes(100), b"PK\x03\x04" + bytes(50), b"{}\n"],
)
def test_what_is_no_log_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "drive.mcap"
    path.write_bytes(content)
    with pytest.raises(CogestError, match=r"drive\.mcap"):
        load_drive([path])


@pytest.mark.parametrize(
    ("head", "kind"), [(b"\x1f\x8b\x08", "gzip"), (b"PK\x03\x04", "ZIP"), (b"\xfd7zXZ\x00", "xz")]
)
def test_a_packed_log_is_to_be_unpacked(head: bytes, kind: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.csv.gz"
    path.write_bytes(head + bytes(50))
    with pytest.raises(CogestError, match=f"a {kind} file.*unpack it"):
        find_importer(path)


def test_a_missing_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(CogestError, match="no such file"):
        read_head(tmp_path / "absent.csv")
