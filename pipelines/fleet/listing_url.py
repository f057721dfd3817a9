"""What lies in a fleet's folder behind a URL."""

from __future__ import annotations

from pipelines.fleet.entries import Entry, Listing, is_hidden
from pipelines.fleet.records import BatchError
from pipelines.fleet.store import STORE_FILE


def list_url(folder: str, store: str | None = None) -> Listing:
    """The files below a URL, with one listing. Raises BatchError where it cannot be listed, or holds nothing."""
    from parsers.places import walk
    from parsers.places_text import masked

    root = folder.rstrip("/")
    listing = Listing(root)
    own = store.rstrip("/") if store is not None else None
    try:
        found = sorted(walk(root), key=lambda facts: facts.place)
    except OSError as error:
        raise BatchError(f"cannot be listed ({error.strerror or error})", path=masked(root)) from error
    if not found:
        raise BatchError("no such folder, or nothing in it", path=masked(root), hint="check the URL")
    names = [(facts, facts.place[len(root) :].lstrip("/")) for facts in found if facts.place.startswith(root)]
    stores = {below.rpartition("/")[0] for _, below in names if below.rpartition("/")[2] == STORE_FILE}
    for where in sorted(stores):
        if own is None or f"{root}/{where}".rstrip("/") != own:
            listing.left_out.append((f"{root}/{where}".rstrip("/"), "a results store of cogest"))
    for facts, below in names:
        folders = below.split("/")
        above = {"/".join(folders[:k]) for k in range(len(folders))}
        inside_own = own is not None and (facts.place == own or facts.place.startswith(own + "/"))
        # a marker of an empty folder has no name
        if not below or inside_own or above & stores or any(is_hidden(part) for part in folders):
            continue
        listing.entries.append(Entry(facts.place, below, facts.size, facts.changed_ns or 0))
    return listing
