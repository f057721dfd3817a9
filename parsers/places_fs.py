"""The one door to fsspec: which file system a URL means, errors in words, and asking again where a connection breaks."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from typing import Any, TypeVar, cast

from parsers.places_text import masked_text

T = TypeVar("T")

WAITS_S = (0.3, 1.0, 3.0)
"""How long to wait before a request is made again; after the last, the connection is given up."""

EXTRA = "pip install 'cogest[remote]'"
_BUCKETS = ("NoSuchBucket", "bucket does not exist")
_CREDENTIALS = ("credential", "InvalidAccessKeyId", "SignatureDoesNotMatch", "ExpiredToken", "InvalidToken")


class IgnoresRangesError(OSError):
    """The server sends the whole file where a range was asked for. content: the file."""

    def __init__(self, content: bytes) -> None:
        super().__init__(errno.ENOTSUP, "the server does not send parts of files")
        self.content = content


@contextmanager
def said_plainly(url: str) -> Iterator[None]:
    """Whatever a store raises becomes an OSError whose `strerror` says it in words, without secrets."""
    try:
        yield
    except Exception as error:
        raise as_os_error(error, url) from None


def as_os_error(error: BaseException, url: str) -> OSError:
    """The error that the rest of cogest knows how to tell. `filename` is left out: callers name the place."""
    scheme = url.partition("://")[0].lower()
    if scheme in ("http", "https") and isinstance(error, FileNotFoundError) and error.__cause__ is not None:
        # fsspec calls every failure so, a broken connection too
        error = error.__cause__
    text = _one_line(error)
    if isinstance(error, IgnoresRangesError):
        return error
    if isinstance(error, ImportError):
        return OSError(errno.ENOTSUP, f"reading {scheme}:// needs more libraries ({text}): {EXTRA}")
    if any(mark in text for mark in _BUCKETS):
        return OSError(errno.ENXIO, "there is no such bucket")
    status = getattr(error, "status", None)
    if isinstance(error, FileNotFoundError) or status in (404, 410):
        return FileNotFoundError(errno.ENOENT, "no such file")
    if (
        isinstance(error, PermissionError)
        or status in (401, 403)
        or any(mark.lower() in text.lower() for mark in _CREDENTIALS)
    ):
        return PermissionError(errno.EACCES, f"no permission ({text}); check the credentials")
    if isinstance(error, IsADirectoryError | NotADirectoryError):
        return type(error)(error.errno or errno.EISDIR, "is a folder, not a file")
    if isinstance(error, ValueError) and "rotocol" in text:
        return OSError(errno.EPROTONOSUPPORT, f"no library knows {scheme}:// ({text})")
    return OSError(errno.EIO, f"the store does not answer as it should ({text})")


def _one_line(error: BaseException) -> str:
    strerror = error.strerror if isinstance(error, OSError) else None
    first = (str(strerror or error).splitlines() or [""])[0].strip()
    return masked_text(first)[:200] or type(error).__name__


def file_system(url: str) -> tuple[Any, str]:
    """fsspec's file system for a URL, and the path in it. Raises OSError."""
    with said_plainly(url):
        try:
            from fsspec.core import url_to_fs
        except ImportError:
            raise ImportError("fsspec is not installed") from None
        # a listing that is kept would hide what another worker has written in the meantime
        fs, path = url_to_fs(url, use_listings_cache=False, **_own_options(url))
        return fs, cast("str", path)


def _own_options(url: str) -> dict[str, Any]:
    """S3's client asks five times by itself, more slowly than `again`, which asks anew anyway: where nobody wants it so, once."""
    if url.partition("://")[0].lower() not in ("s3", "s3a"):
        return {}
    if "AWS_MAX_ATTEMPTS" in os.environ or "AWS_RETRY_MODE" in os.environ:
        return {}
    return {"config_kwargs": {"retries": {"mode": "standard", "total_max_attempts": 1}}}


def again(ask: Callable[[], T], url: str) -> T:
    """ask(), again after a pause where the connection broke. Raises OSError in words."""
    for wait_s in WAITS_S:
        try:
            return ask()
        except Exception as error:
            told = as_os_error(error, url)
            if told.errno != errno.EIO:
                raise told from None
        time.sleep(wait_s)
    try:
        return ask()
    except Exception as error:
        told = as_os_error(error, url)
        if told.errno != errno.EIO:
            raise told from None
        tries = len(WAITS_S) + 1
        raise OSError(errno.EIO, f"the connection failed {tries} times ({_one_line(error)})") from None


def fetch(url: str, start: int, stop: int) -> bytes:
    """The bytes [start, stop) of a file. Raises OSError; IgnoresRangesError where the server cannot do that."""
    fs, path = file_system(url)

    def ask() -> bytes:
        data = cast("bytes", fs.cat_file(path, start=start, end=stop))
        if len(data) > stop - start:
            raise IgnoresRangesError(data)
        if len(data) < stop - start:
            raise ConnectionError(f"{len(data)} of {stop - start} bytes came")
        return data

    return again(ask, url)


def info(url: str) -> Mapping[str, Any]:
    """What the store says of a file or folder, anew. Raises OSError."""
    fs, path = file_system(url)
    return again(lambda: cast("Mapping[str, Any]", fs.info(path)), url)


def listing(url: str, *, deep: bool) -> list[Mapping[str, Any]]:
    """What is directly in a folder, or all files below it, with what the store says of each. Raises OSError."""
    fs, path = file_system(url)
    if deep:
        return list(again(lambda: cast("dict[str, Any]", fs.find(path, detail=True)), url).values())
    return again(lambda: cast("list[Mapping[str, Any]]", fs.ls(path, detail=True)), url)


def etag_of(entry: Mapping[str, Any]) -> str | None:
    """The store's mark of the content, without quotes; of some stores a checksum of it."""
    found = entry.get("ETag") or entry.get("etag") or entry.get("Content-MD5") or entry.get("md5Hash")
    return str(found).strip('"') if found else None


def changed_ns_of(entry: Mapping[str, Any]) -> int | None:
    """When the file was written last, in ns since 1970."""
    for key in ("LastModified", "last_modified", "mtime", "Last-Modified", "updated", "created"):
        value = entry.get(key)
        if isinstance(value, str) and value:
            from email.utils import parsedate_to_datetime

            try:
                value = parsedate_to_datetime(value) if "," in value else datetime.fromisoformat(value)
            except ValueError:
                continue
        if isinstance(value, datetime):
            return round(value.timestamp() * 1_000_000) * 1000
        if isinstance(value, int | float) and value > 0:
            return round(value * 1_000_000) * 1000
    return None
