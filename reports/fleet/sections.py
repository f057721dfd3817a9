"""The tables of the fleet report that HTML and PDF print alike: outliers, load changes, drifts, failures, how to read it."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import replace

from pipelines.hierarchy.changes import NOT_SEEN, OR_SPRINGS
from pipelines.hierarchy.outliers import LOADED
from reports.blocks import Block, Bullets, Cell, Column, Item, Paragraph, Section, Table
from reports.fleet.failures import KINDS, groups_of
from reports.fleet.findings import share_text
from reports.fleet.records import NEAR_G, NEAR_PROBABILITY, OUTLYING, FleetView, Row, VehicleView
from reports.fleet.view import finite, moment, title_of
from reports.fleet.words import chance_text, date_text, spread_text
from reports.text import DASH, NARROW, clean, count, number, sentence, significant

MOST_ROWS, MOST_PRINTED = 200, 60
"""Rows of a table on the screen and on paper; the store's tables hold all."""

FEWEST_TRENDS = 12
"""Trends that are shown at least, whether they are drifts or not."""

NAMED_DRIVES = 4


def _note(shown: int, total: int, table: str) -> str:
    """What a cut table says of the rest."""
    return f"{number(total - shown, 0)} more in {table}." if total > shown else ""


def _chance_of(row: Row) -> float:
    known = finite(row["probability"])
    return 2.0 if known is None else known


def outliers(view: FleetView, most: int = MOST_ROWS) -> tuple[Block, ...]:
    """Vehicles, the farthest from the others of their kind, or from their data sheet, first."""
    if not view.outliers:
        return (Paragraph("No vehicle can be compared with others of its kind.", "quiet"),)
    labels = {v.vehicle_id: v.label for v in view.vehicles}
    rows = []
    for row in view.outliers[:most]:
        odd = _chance_of(row) < OUTLYING
        name = str(row["parameter"] or DASH)
        title, unit = view.titles.get(name.removeprefix(LOADED), (clean(name, 60), ""))
        title = f"{title}, as usually loaded" if name.startswith(LOADED) else title
        std = finite(row["others_std"])
        rows.append(
            (
                Cell(DASH if row["rank"] is None else str(row["rank"])),
                Cell(labels.get(clean(row["vehicle_id"], 160), clean(row["vehicle_name"] or row["vehicle_id"], 80))),
                Cell("outlier" if odd else "usual", kind="badge", tone="warn" if odd else "quiet"),
                Cell(significant(finite(row["score"]), 2), sub=f"by chance {chance_text(row['probability'])}"),
                Cell(title),
                Cell(spread_text(row["value"], None, unit, std), sub=f"against {spread_text(row['others'], row['others_std'], unit)}"),
                Cell(sentence(row["text"] or "", 300) or DASH),
            )
        )  # fmt: skip
    columns = (
        Column("Rank", weight=0), Column("Vehicle", weight=1.3), Column("", weight=0), Column("Distance, std", "right", 0),
        Column("Farthest in", weight=1.2), Column("Value", "right", 0), Column("In words", weight=2.4),
    )  # fmt: skip
    note = f"Compared with the others of its kind; where there are too few of them, with its own data sheet. Distance: the largest, in joint standard deviations. Outlier: chance makes one as far off in less than {share_text(OUTLYING)} of vehicles."
    more = _note(len(rows), len(view.outliers), "outliers.parquet")
    return (
        Table(columns, tuple(rows), note=f"{note} {more}".strip(), dense=True, caption="The farthest first"),
    )


def _difference(row: Row, name: str, unit: str) -> Cell:
    value, std = finite(row[f"{name}_change_{unit}"]), finite(row[f"{name}_change_std_{unit}"])
    scale, shown = (1000.0, "mm") if unit == "m" else (1.0, unit)
    if value is None:
        return Cell(DASH)
    text = spread_text(value * scale, None if std is None else std * scale, shown)
    return Cell(f"+{text}" if value > 0 else text)


OR_SPRINGS_SHORT = "or springs, or their sensors, changed"


def load_changes(view: FleetView, most: int = MOST_ROWS) -> tuple[Block, ...]:
    """Changes of load that were detected, the surest first."""
    compared = sum(v.compared for v in view.vehicles)
    if not compared:
        why = (
            clean(NOT_SEEN, 300)
            if any(v.changes for v in view.vehicles)
            else "no drive could be compared with one before it of the same vehicle"
        )
        return (Paragraph(sentence(why), "quiet"),)
    rate = view.facts.false_alarm_rate
    stated = (
        "The false-alarm rate is not stated."
        if rate is None
        else f"False-alarm rate {share_text(rate)}: so often a change is told though the load was the same."
    )
    found = [(v, row) for v in view.vehicles for row in v.changes if row["detected"]]
    if not found:
        return (
            Paragraph(f"None of {count(compared, 'comparison')} shows a change of load. {stated}", "quiet"),
        )
    found.sort(key=lambda pair: (_chance_of(pair[1]), pair[0].label, str(pair[1]["drive_id"])))
    names = {d.drive_id: d.name for d in view.drives}
    rows = tuple(
        (
            Cell(v.label),
            Cell(names.get(clean(row["drive_id"], 160), clean(row["drive_id"] or DASH, 80)), sub=date_text(moment(row["start_utc"]))),
            replace(_difference(row, "mass", "kg"), sub=OR_SPRINGS_SHORT if OR_SPRINGS in str(row["text"]) else ""),
            _difference(row, "cg_height", "m"),
            _difference(row, "cg_to_front_axle", "m"),
            _difference(row, "cg_lateral", "m"),
            Cell(chance_text(row["probability"])),
        )
        for v, row in found[:most]
    )  # fmt: skip
    columns = (
        Column("Vehicle", weight=1.2), Column("Before this drive", weight=2), Column("Mass", "right", 0), Column("CG height", "right", 0),
        Column("CG rearwards", "right", 0), Column("CG to the left", "right", 0), Column("By chance", "right", 0),
    )  # fmt: skip
    note = f"This drive less the one before, ± one standard deviation. {stated} {_note(len(rows), len(found), 'load_changes.parquet')}"
    return (Table(columns, rows, note=note.strip(), dense=True, caption="The surest first"),)


def _trend_rows(found: list[tuple[VehicleView, Row]]) -> tuple[tuple[Cell, ...], ...]:
    rows = []
    for v, row in found:
        unit = clean(row["unit"] or "", 20)
        unit = f"{unit} a year" if unit and unit != "–" else "a year"
        drift = bool(row["detected"])
        rows.append(
            (
                Cell(v.label),
                Cell(title_of(row)),
                Cell("drift" if drift else "none seen", kind="badge", tone="warn" if drift else "quiet"),
                Cell(spread_text(row["per_year"], row["std"], unit), sub=f"95{NARROW}%: {spread_text(row['low'], None, '', row['std'])} to {spread_text(row['high'], None, '', row['std'])}"),
                Cell(chance_text(row["probability"])),
                Cell(f"{date_text(moment(row['from_utc']))} to {date_text(moment(row['to_utc']))}", sub=count(int(finite(row["drives"]) or 0), "drive")),
                Cell(sentence(row["text"] or "", 300) or DASH),
            )
        )  # fmt: skip
    return tuple(rows)


def _untold_trends(view: FleetView) -> str:
    """How many parts cannot be told of, and the most frequent reason; or nothing."""
    untold = [row for v in view.vehicles for row in v.trends if row["per_year"] is None]
    why = Counter(clean(row["text"] or "", 200) for row in untold).most_common(1)
    if not untold:
        return ""
    reason = why[0][0].removeprefix("cannot be told: ")
    return sentence(
        f"{count(len(untold), 'part')} cannot be told of" + (f", most often: {reason}" if reason else "")
    )


def trends(view: FleetView, most: int = MOST_ROWS) -> tuple[Block, ...]:
    """Drifts of parts that wear, the surest first; where there is none, those that were looked at."""
    told = [(v, row) for v in view.vehicles for row in v.trends if row["per_year"] is not None]
    if not told:
        why = _untold_trends(view) or "No vehicle has drives over a time long enough to look for a drift."
        return (Paragraph(why, "quiet"),)
    told.sort(key=lambda pair: (not pair[1]["detected"], _chance_of(pair[1]), pair[0].label))
    detected = sum(bool(row["detected"]) for _, row in told)
    shown = told[: max(FEWEST_TRENDS, min(detected, most))]
    columns = (
        Column("Vehicle", weight=1.2), Column("Part", weight=1.4), Column("", weight=0), Column("Change", "right", 0), Column("By chance", "right", 0),
        Column("Drives", weight=1.2), Column("In words", weight=1.8),
    )  # fmt: skip
    rate = view.facts.trend_false_alarm_rate
    stated = "" if rate is None else f"False-alarm rate {share_text(rate)} a part."
    parts = (stated, _note(len(shown), len(told), "trends.parquet"), _untold_trends(view))
    return (
        Table(
            columns,
            _trend_rows(shown),
            note=" ".join(p for p in parts if p),
            dense=True,
            caption="The surest first",
        ),
    )


def failures(view: FleetView, most: int = MOST_ROWS) -> tuple[Block, ...]:
    """Failed drives by reason, the most frequent first."""
    groups = groups_of(view.failed)
    if not groups:
        return (Paragraph("No drive failed." if view.drives else "There is no drive.", "quiet"),)
    rows = []
    for group in groups[:most]:
        names = [d.name for d in group.drives]
        more = f"and {number(len(names) - NAMED_DRIVES, 0)} more" if len(names) > NAMED_DRIVES else ""
        rows.append(
            (
                Cell(number(len(names), 0)),
                Cell(KINDS.get(group.status, group.status)),
                Cell(sentence(group.example) or "no reason is known"),
                Cell(names[0], lines=tuple(names[1:NAMED_DRIVES]), sub=more),
            )
        )
    columns = (Column("Drives", "right", 0), Column("What happened", weight=1), Column("Reason, the first one's words", weight=2.4), Column("Which", weight=2))  # fmt: skip
    note = "Reasons that differ only in names and figures are one row. " + _note(
        len(rows), len(groups), "drives.parquet"
    )
    return (Table(columns, tuple(rows), note=note.strip(), dense=True, caption="The most frequent first"),)


def left_out(view: FleetView, most: int = MOST_ROWS) -> tuple[Block, ...]:
    """The files that are in no drive, by reason, the most frequent first; nothing where there are none."""
    by_reason: dict[str, list[str]] = defaultdict(list)
    for name, why in view.facts.left_out_named:
        by_reason[why].append(clean(name, 160))
    if not by_reason:
        return ()
    groups = sorted(by_reason.items(), key=lambda pair: (-len(pair[1]), pair[0]))
    rows = tuple(
        (
            Cell(number(len(names), 0)),
            Cell(sentence(why, 300)),
            Cell(
                names[0],
                lines=tuple(names[1:NAMED_DRIVES]),
                sub=f"and {number(len(names) - NAMED_DRIVES, 0)} more" if len(names) > NAMED_DRIVES else "",
            ),
        )
        for why, names in groups[:most]
    )
    columns = (Column("Files", "right", 0), Column("Why", weight=2.4), Column("Which", weight=2))
    note = _note(len(rows), len(groups), "fleet.json")
    return (Table(columns, rows, note=note, dense=True, caption="Files that are in no drive"),)


def reading() -> tuple[Block, ...]:
    """What the words and figures mean."""
    words = (
        ("identified", "good", "the log narrowed the parameter well below what was known before."),
        ("weak", "warn", "the log narrowed it a little: the interval still leans on what was known before."),
        ("not identifiable", "quiet", "the log taught next to nothing; no value is given then, and the drive's report says what was missing."),
        (DASH, "quiet", "nothing is known."),
    )  # fmt: skip
    badges = Bullets(tuple(Item(text, badge, tone) for badge, tone, text in words))  # type: ignore[arg-type]
    more = Bullets(
        (
            Item(f"Intervals are 95{NARROW}% intervals; ± is one standard deviation."),
            Item("Alone: what the drive says by itself. Without that word: with all drives of its vehicle joined, because what belongs to the vehicle (springs, dampers, empty mass, sensor mounting) is shared, and only the load is each drive's own."),
            Item("Known before: the prior, from the vehicle file or from measured vehicles. Sharper than one drive: a single drive's spread (the median) over that of all drives."),
            Item(f"Near rollover: a least margin of {number(NEAR_G, 2)}{NARROW}g or less, a probability of {share_text(NEAR_PROBABILITY)} or more of having reached the threshold, or a wheel lift. SSF: static stability factor, half the track over the CG height. All of these are each drive's own, with the CG height that it told alone."),
            Item("Local behind a start: the log does not say of which time zone its clock is; taken as UTC, up to 14 hours off."),
            Item("By chance: how often a difference as large would be seen if there was none."),
            Item("Measured vehicles: 1 270 CG heights that were measured on tables, public domain; passenger cars and light trucks, empty or lightly loaded."),
        )
    )  # fmt: skip
    return (badges, more)


def shared_sections(view: FleetView, most: int = MOST_ROWS) -> tuple[Section, ...]:
    """Those chapters that are the same on the screen and on paper. most: rows of a table."""
    return (
        Section("outliers", "Outlying vehicles", "Outliers", outliers(view, most)),
        Section("load-changes", "Changes of load", "Load changes", load_changes(view, most)),
        Section("trends", "Drifts of springs and dampers", "Drifts", trends(view, most)),
        Section("failures", "Drives that failed", "Failures", (*failures(view, most), *left_out(view, most))),
        Section("reading", "How to read this", "Reading", reading()),
    )
