"""The report as one HTML file: no network, no script, no font but the reader's own."""

from __future__ import annotations

import re
from dataclasses import asdict
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from pipelines.drive_results import DriveResults
from reports.blocks import Document
from reports.document import build_document
from reports.files import write_whole

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup


def template_text(name: str) -> str:
    """A file of `reports/templates`, as installed."""
    return (resources.files("reports") / "templates" / name).read_text(encoding="utf-8")


_SPACE = re.compile("([ \u00a0\u202f])")
_BREAK_AFTER = re.compile(r"(?<=[/_.:\]])(?=[^\s/_.:;\d]{2})")


def breakable(text: str) -> Markup:
    """Escape a text, and let long names break behind their /, _, . and :."""
    from markupsafe import Markup, escape

    safe = str(escape(text))
    return Markup(
        "".join(_BREAK_AFTER.sub("<wbr>", word) if len(word) > 16 else word for word in _SPACE.split(safe))
    )


@cache
def page_template(name: str) -> Template:
    """A page of `reports/templates` ("report.html"), compiled once a process; all text but what goes through `svg` is escaped."""
    from jinja2 import DictLoader, Environment, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=DictLoader({page: template_text(f"{page}.j2") for page in (name, "macros.html")}),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["svg"] = Markup
    environment.filters["breaks"] = breakable
    return environment.get_template(name)


def html_of(document: Document) -> str:
    """Print a document as HTML. Every text is escaped; only the figures, escaped when drawn, pass as they are."""
    return page_template("report.html").render(doc=asdict(document), css=template_text("report.css"))


def render_html(results: DriveResults) -> str:
    """Results as HTML text."""
    return html_of(build_document(results))


def write_html(results: DriveResults, path: Path) -> None:
    """Write the report, whole or not at all. Raises ReportError where the file cannot be written."""
    write_whole(path, render_html(results).encode("utf-8"))
