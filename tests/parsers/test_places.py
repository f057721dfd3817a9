"""Places: paths of this machine and URLs in one way, and nothing secret shown."""

from __future__ import annotations

import copy
import pickle
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from parsers import places_fs
from parsers.errors import LogError
from parsers.places import as_path, facts, join, parent, place_of, read_bytes, remote, walk
from parsers.places_text import is_url, masked, masked_text
from parsers.registry import read_head
from parsers.remote_marks import content_mark, mark_instead
from pipelines.discover import databases_beside, nearest

SIGNED = "https://me:hunter2@host/a/drive.mcap?X-Amz-Signature=hunter2"


@pytest.fixture
def memory(tmp_path: Path) -> str:
    """A folder of fsspec's memory with files in it."""
    fsspec = pytest.importorskip("fsspec", reason="fsspec (cogest[remote]) is not installed")
    fs, root = fsspec.filesystem("memory"), f"/{tmp_path.name}"
    for name in ("fleet/vehicle.toml", "fleet/van/drive.blf", "fleet/van/chassis.dbc", "fleet/van/b/bag.db3"):
        fs.pipe_file(f"{root}/{name}", name.encode())
    return f"memory:/{root}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("s3://b/k", True),
        ("memory://x", True),
        ("file:///x", True),
        ("https://h/x?y", True),
        ("/tmp/s3://b", False),
        ("C:/x", False),
        ("c://x", False),
        ("drive.mcap", False),
        ("simplecache::s3://b/k", False),
        ("", False),
    ],
)
def test_what_is_a_url(text: str, expected: bool) -> None:
    assert is_url(text) is expected


def test_local_places_are_paths() -> None:
    assert as_path("a/b.csv") == Path("a/b.csv")
    assert as_path(Path("a")) == Path("a")
    assert as_path("file:///a/b%20c.csv") == Path("/a/b c.csv")
    assert remote(Path("a")) is None
    assert place_of(Path("a/b")) == str(Path("a/b"))


def test_secrets_are_masked_wherever_a_place_is_shown() -> None:
    path = as_path(SIGNED)
    assert (path.name, path.stem, path.suffix) == ("drive.mcap", "drive", ".mcap")
    for shown in (
        str(path),
        repr(path),
        masked(SIGNED),
        masked_text(f"cannot open '{SIGNED}'"),
        str(LogError("x", path=SIGNED)),
    ):
        assert "hunter2" not in shown
        assert "host/a/drive.mcap" in shown
    assert place_of(path) == SIGNED
    # what lies beside it needs the password, but has another signature
    assert place_of(path.parent / "map.toml") == "https://me:hunter2@host/a/map.toml"
    assert masked("s3://bucket/what?.csv") == "s3://bucket/what?.csv"
    told = places_fs.as_os_error(RuntimeError(f"GET {SIGNED} gave 500"), SIGNED)
    assert "hunter2" not in str(told)


def test_a_remote_path_is_asked_as_a_path_is(memory: str) -> None:
    path = as_path(f"{memory}/fleet/van/drive.blf")
    assert path.is_file()
    assert not path.is_dir()
    assert path.exists()
    assert not (path.parent / "none").exists()
    assert path.stat().st_size == len("fleet/van/drive.blf")
    assert stat.S_ISDIR(path.parent.stat().st_mode)
    assert [each.name for each in path.parent.iterdir()] == ["b", "chassis.dbc", "drive.blf"]
    assert [each.is_dir() for each in path.parent.iterdir()] == [True, False, False]
    assert path.read_text() == "fleet/van/drive.blf"
    assert read_head(path) == b"fleet/van/drive.blf"
    with path.open(encoding="utf-8") as file:
        assert file.readline() == "fleet/van/drive.blf"
    with pytest.raises(OSError, match="only for reading"):
        path.open("wb")
    assert path.parent / "drive.blf" == path == path.with_name("drive.blf")
    assert sorted([path, path.parent]) == [path.parent, path]
    assert len({path, path.parent / "drive.blf"}) == 1
    assert path.resolve() is path
    assert path.parent / "../vehicle.toml" == as_path(f"{memory}/fleet/vehicle.toml")
    assert str(as_path("s3://b/k") / "../../../x/./y") == "s3://b/x/y"
    assert str(path / "s3://b/map.toml") == "s3://b/map.toml"
    assert pickle.loads(pickle.dumps(path)) == copy.deepcopy(path) == path
    with pytest.raises(TypeError):
        Path(path)


def test_what_belongs_to_a_log_is_found_beside_and_above_it(memory: str) -> None:
    log = as_path(f"{memory}/fleet/van/drive.blf")
    assert str(nearest("vehicle.toml", log)) == f"{memory}/fleet/vehicle.toml"
    assert nearest("map.toml", log) is None
    assert [str(each) for each in databases_beside(log)] == [f"{memory}/fleet/van/chassis.dbc"]


def test_folders_are_walked_with_what_the_store_says(memory: str, tmp_path: Path) -> None:
    found = list(walk(f"{memory}/fleet/van"))
    below = [each.place.removeprefix(memory) for each in found]
    assert below == ["/fleet/van/b/bag.db3", "/fleet/van/chassis.dbc", "/fleet/van/drive.blf"]
    for each in found:
        assert facts(each.place) == each
        assert each.changed_ns is not None
        assert len(read_bytes(each.place)) == each.size
    assert read_bytes(found[0].place, 3) == b"fle"
    assert list(walk(found[0].place)) == [found[0]]
    with pytest.raises(FileNotFoundError):
        list(walk(f"{memory}/none"))
    with pytest.raises(FileNotFoundError):
        facts(f"{memory}/none")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "x").write_bytes(b"12")
    (tmp_path / "a").write_bytes(b"1")
    assert [(each.place, each.size) for each in walk(str(tmp_path))] == [
        (str(tmp_path / "a"), 1),
        (str(tmp_path / "b" / "x"), 2),
    ]


def test_places_are_joined_and_have_folders() -> None:
    assert join("s3://b/k/", "x", "y/z") == "s3://b/k/x/y/z"
    assert join("a", "b") == str(Path("a/b"))
    assert parent("s3://b/k/x") == "s3://b/k"
    assert parent("s3://b") is None
    assert parent("/a/b") == str(Path("/a"))
    assert parent("/") is None


def test_an_s3_etag_stands_for_the_content(s3_store) -> None:
    url = s3_store.write("drive.csv", b"1" * 2_000_000)
    mark = mark_instead(url)
    assert mark is not None
    assert mark.startswith("s3 etag ")
    assert mark == content_mark(facts(s3_store.write("copy.csv", b"1" * 2_000_000)))
    assert mark != content_mark(facts(s3_store.write("drive.csv", b"2" * 2_000_000)))
    assert mark_instead(s3_store.write("small.csv", b"1")) is None


def test_without_the_extra_it_is_said_what_to_install() -> None:
    code = (
        "import sys; sys.modules['fsspec'] = None\n"
        "from parsers.places import as_path\n"
        "from parsers.registry import read_head\n"
        "from parsers.errors import LogError\n"
        "try: read_head(as_path('s3://b/k'))\n"
        "except LogError as error: print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("s3://b/k: cannot be opened (")
    assert "pip install 'cogest[remote]'" in done.stdout


def test_local_logs_load_no_library_for_urls() -> None:
    code = (
        "import sys\nimport parsers.load, parsers.registry, pipelines.discover\n"
        "print('fsspec' in sys.modules, 'parsers.places_path' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]
