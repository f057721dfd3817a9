"""The storage of a place: a folder of this machine, or what lies behind a URL."""

from __future__ import annotations

from parsers.places import as_path
from parsers.places_text import is_url
from pipelines.fleet.storage import Storage


def storage_at(place: str) -> Storage:
    """The storage for a path, or for a URL that fsspec opens ("s3://…"). Raises StoreError."""
    if is_url(place) and not place.lower().startswith("file://"):
        from pipelines.fleet.storage_url import UrlStorage

        return UrlStorage(place)
    from pipelines.fleet.storage_local import LocalStorage

    return LocalStorage(as_path(place))
