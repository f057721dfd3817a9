"""The fleet report as one HTML file: its data, its styles and its small scripts inside, nothing from a network."""

from __future__ import annotations

import base64
import hashlib
from dataclasses import asdict

from reports.fleet import overview
from reports.fleet.distributions import plots
from reports.fleet.findings import findings_of
from reports.fleet.payload import payload, script_json
from reports.fleet.records import FleetView
from reports.fleet.sections import shared_sections
from reports.html import page_template, template_text
from reports.text import clean

SCRIPTS = ("fleet_base.js", "fleet_table.js", "fleet_charts.js", "fleet_drives.js", "fleet_vehicles.js", "fleet_page.js")  # fmt: skip


def script_text() -> str:
    """The page's scripts, one after the other."""
    return "\n" + "\n".join(template_text(name) for name in SCRIPTS)


def script_hash(script: str) -> str:
    """What the page's security policy names: no other script may run in it."""
    digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    return f"sha256-{digest}"


def html_page(view: FleetView) -> str:
    """The page as text. All text of logs is escaped, or stands in the JSON that the script shows as text alone."""
    script = script_text()
    page = {
        "title": overview.title(view),
        "version": clean(view.facts.version, 40),
        "facts": [asdict(f) for f in overview.facts_line(view)],
        "summary": overview.summary(view),
        "tiles": [asdict(f) for f in overview.tiles(view)],
        "findings": [asdict(f) for f in findings_of(view)],
        "any": bool(view.drives),
        "plots": [asdict(p) for p in plots(view)],
        "sections": [asdict(s) for s in shared_sections(view)],
        "footer": overview.footer(view),
    }
    return page_template("fleet.html").render(
        page=page,
        css=template_text("report.css") + template_text("fleet.css"),
        data=script_json(payload(view)),
        script=script,
        script_hash=script_hash(script),
    )
