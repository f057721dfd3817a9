"""A real S3 server as a process of its own on loopback, with one bucket, for tests of what lies behind URLs."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
import urllib.request
from collections import Counter as CounterOf
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

import pytest

_STARTS_WITHIN_S = 60.0


@dataclass
class Counter:
    """What was asked of the store, by the operation's name, and the bytes of contents that it sent."""

    calls: CounterOf[str] = field(default_factory=CounterOf)
    bytes: int = 0


@dataclass(frozen=True)
class S3Store:
    """A running server. url: of its bucket, "s3://drives"."""

    endpoint: str
    url: str

    def put(self, source: Path, name: str) -> str:
        """Copy a file or a folder of this disk into the bucket; its URL."""
        from fsspec.core import url_to_fs

        fs, path = url_to_fs(f"{self.url}/{name}", use_listings_cache=False)
        files = [p for p in sorted(source.rglob("*")) if p.is_file()] if source.is_dir() else [source]
        for file in files:
            below = f"/{file.relative_to(source).as_posix()}" if source.is_dir() else ""
            fs.pipe_file(path + below, file.read_bytes())
        return f"{self.url}/{name}"

    def write(self, name: str, content: bytes) -> str:
        """Write one object; its URL."""
        from fsspec.core import url_to_fs

        fs, path = url_to_fs(f"{self.url}/{name}", use_listings_cache=False)
        fs.pipe_file(path, content)
        return f"{self.url}/{name}"


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _wait_for(endpoint: str, server: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + _STARTS_WITHIN_S
    while time.monotonic() < end:
        if server.poll() is not None:
            pytest.skip("the S3 server (moto) did not start on this machine")
        try:
            with urllib.request.urlopen(f"{endpoint}/moto-api/", timeout=5):
                return
        except OSError:
            time.sleep(0.1)
    pytest.skip("the S3 server (moto) did not answer")


@contextmanager
def running_server() -> Iterator[str]:
    """The endpoint of a server process of its own."""
    port = _free_port()
    endpoint = f"http://127.0.0.1:{port}"
    command = [
        sys.executable,
        "-c",
        "from moto.server import main; main()",
        "-H",
        "127.0.0.1",
        "-p",
        str(port),
    ]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        _wait_for(endpoint, server)
        yield endpoint
    finally:
        server.terminate()
        server.wait(20)


def environment(endpoint: str) -> dict[str, str]:
    """How botocore and s3fs find the server, and nothing else."""
    return {
        "AWS_ENDPOINT_URL": endpoint,
        "AWS_ACCESS_KEY_ID": "AKIDTEST",
        "AWS_SECRET_ACCESS_KEY": "not-a-secret",
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_EC2_METADATA_DISABLED": "true",
        "AWS_CONFIG_FILE": os.devnull,
        "AWS_SHARED_CREDENTIALS_FILE": os.devnull,
        "NO_PROXY": "127.0.0.1",
    }


def empty_bucket(endpoint: str) -> S3Store:
    """A server without anything but one empty bucket; the environment is set."""
    import s3fs

    urllib.request.urlopen(urllib.request.Request(f"{endpoint}/moto-api/reset", method="POST")).close()
    s3fs.S3FileSystem.clear_instance_cache()
    s3fs.S3FileSystem(use_listings_cache=False).mkdir("drives")
    return S3Store(endpoint, "s3://drives")


@pytest.fixture(scope="session")
def s3_server() -> Iterator[str]:
    """The endpoint of a server process."""
    for module, extra in (("moto", "moto[server]"), ("flask", "moto[server]"), ("s3fs", "cogest[remote]")):
        if find_spec(module) is None:
            pytest.skip(f"{extra} is not installed: there is no S3 server to test against")
    with running_server() as endpoint:
        yield endpoint


@pytest.fixture
def s3_store(s3_server: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[S3Store]:
    """A bucket, empty at first, found by the environment as botocore and s3fs read it."""
    for name, value in environment(s3_server).items():
        monkeypatch.setenv(name, value)
    yield empty_bucket(s3_server)
    import s3fs

    s3fs.S3FileSystem.clear_instance_cache()


@contextmanager
def counting() -> Iterator[Counter]:
    """Counts what is asked of the store, and the bytes of contents that it sends."""
    import s3fs

    counter = Counter()
    plain = s3fs.S3FileSystem._call_s3

    async def call(self, method, *args, **kwargs):
        answer = await plain(self, method, *args, **kwargs)
        counter.calls[method] += 1
        if method == "get_object":
            counter.bytes += answer["ContentLength"]
        return answer

    s3fs.S3FileSystem._call_s3 = call
    try:
        yield counter
    finally:
        s3fs.S3FileSystem._call_s3 = plain


@pytest.fixture
def counted() -> Iterator[Counter]:
    """Counts what is asked of the store."""
    with counting() as counter:
        yield counter
