"""What the fleet is: title, figures of the first screen, one sentence."""

from __future__ import annotations

from pathlib import PurePosixPath

from reports.blocks import Fact
from reports.fleet.records import FleetView
from reports.fleet.words import date_text, hours_text
from reports.text import DASH, clean, count, number


def title(view: FleetView) -> str:
    """The fleet's name: that of its folder."""
    folder = view.facts.folder.replace("\\", "/").rstrip("/")
    name = clean(PurePosixPath(folder).name or folder or "fleet", 100)
    return "Fleet" if name.casefold() == "fleet" else f"Fleet {name}"


def dates(view: FleetView) -> str:
    """From the first to the last drive."""
    starts = [d.start for d in view.drives if d.start is not None]
    if not starts:
        return DASH
    first, last = date_text(min(starts)), date_text(max(starts))
    return first if first == last else f"{first} to {last}"


def driven_s(view: FleetView) -> float:
    """Seconds of all drives that tell how long they were."""
    return sum(d.duration_s or 0.0 for d in view.drives)


def summary(view: FleetView) -> str:
    """The fleet in one sentence or two."""
    if not view.drives:
        return "No drive was found: there is nothing to report."
    vehicles = sum(bool(v.drives) for v in view.vehicles)
    text = f"{count(vehicles, 'vehicle')}, {count(len(view.drives), 'drive')}, {hours_text(driven_s(view))} of driving"
    when = dates(view)
    if when != DASH:
        text += f", {when}" if " to " not in when else f" from {when}"
    if not view.done:
        return f"{text}. No drive could be analysed: the reasons are below."
    undated = sum(d.start is None for d in view.drives)
    return f"{text}." + (f" {count(undated, 'drive')} without a start time." if undated else "")


def tiles(view: FleetView) -> tuple[Fact, ...]:
    """The figures of the first screen."""
    failed, near = len(view.failed), sum(d.near for d in view.done)
    changes, drifts = sum(v.changed for v in view.vehicles), sum(v.drifts for v in view.vehicles)
    compared, looked = sum(v.compared for v in view.vehicles), sum(v.looked for v in view.vehicles)
    odd = sum(v.outlying for v in view.vehicles)
    judged = any(d.margin_g is not None or d.exceedance is not None or d.lifts is not None for d in view.done)

    def some(label: str, value: int, known: bool, tone: str, sub: str = "") -> Fact:
        shown = number(value, 0) if known else DASH
        return Fact(label, shown, sub if known else "not known", tone=tone if known and value else "plain")  # type: ignore[arg-type]

    return (
        Fact("Vehicles", number(sum(bool(v.drives) for v in view.vehicles), 0)),
        Fact("Drives", number(len(view.drives), 0), f"{number(len(view.done), 0)} analysed"),
        Fact("Driven", hours_text(driven_s(view))),
        some("Failed", failed, True, "bad", "reasons below" if failed else "all were analysed" if view.drives else ""),
        some("Near rollover", near, judged, "bad", "drives"),
        some("Load changes", changes, compared > 0, "warn", f"of {number(compared, 0)} compared"),
        some("Drifts", drifts, looked > 0, "warn", f"of {number(looked, 0)} parts"),
        some("Outliers", odd, bool(view.outliers), "warn", f"of {count(len(view.outliers), 'vehicle')}"),
    )  # fmt: skip


def facts_line(view: FleetView) -> tuple[Fact, ...]:
    """Beside the title."""
    out = [Fact("Drives from", dates(view))]
    if view.facts.created:
        out.append(Fact("Made", clean(view.facts.created, 60)))
    return tuple(out)


def footer(view: FleetView) -> str:
    """Who made it of what."""
    facts = view.facts
    parts = [f"cogest {clean(facts.version, 40)}".strip(), f"folder {clean(facts.folder, 200)}"]
    if facts.store:
        parts.append(f"store {clean(facts.store, 200)}")
    if facts.left_out:
        parts.append(f"{count(facts.left_out, 'file')} left out")
    return " · ".join(parts)
