"""Write the report in every form that was asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from parsers.errors import ReportError
from pipelines.drive_results import DriveResults
from reports.archive import FILE_NAME, archive_bytes
from reports.files import make_folder, remove_old, write_whole

FORMATS: dict[str, str] = {"html": "report.html", "pdf": "report.pdf", "json": "results.json"}
"""What may be asked for, and the file that it gives."""


def check_formats(formats: str | Sequence[str]) -> tuple[str, ...]:
    """Formats in the order of `FORMATS`, each once; from a list or from "html,pdf".

    Raises ReportError on one that is unknown or on none.
    """
    if isinstance(formats, str):
        formats = [part.strip().lower() for part in formats.split(",") if part.strip()]
    unknown = [f for f in formats if f not in FORMATS]
    if unknown:
        raise ReportError(
            f"unknown format {unknown[0]!r}", hint=f"known are {', '.join(FORMATS)}", wrong_usage=True
        )
    if not formats:
        raise ReportError("no format was asked for", hint=f"known are {', '.join(FORMATS)}", wrong_usage=True)
    return tuple(f for f in FORMATS if f in formats)


def check_drive_reports(reports: str) -> tuple[str, ...]:
    """The reports that a batch makes of each drive, from "html,pdf" or "none"; in the order of `FORMATS`, each once.

    Raises ReportError on one that is unknown, on none, or on "none" beside another.
    """
    asked = [part.strip().lower() for part in reports.split(",") if part.strip()]
    if asked == ["none"]:
        return ()
    known = tuple(name for name in FORMATS if name != "json")
    hint = f"known are {', '.join(known)}, or none alone; results are always kept"
    if unknown := [name for name in asked if name not in known]:
        raise ReportError(f"unknown report {unknown[0]!r}", hint=hint, wrong_usage=True)
    if not asked:
        raise ReportError("no report was asked for", hint=hint, wrong_usage=True)
    return tuple(name for name in known if name in asked)


def report_files(results: DriveResults, formats: Sequence[str] = tuple(FORMATS)) -> dict[str, bytes]:
    """Every file of a drive's folder, by name: the report in each form, and the archive that it can be made from again.

    The figures are drawn once for all forms. Raises ReportError.
    """
    wanted = check_formats(formats)
    made: dict[str, bytes] = {FILE_NAME: archive_bytes(results)}
    if "json" in wanted:
        from reports.results_json import json_text

        made[FORMATS["json"]] = json_text(results).encode("utf-8")
    if "html" in wanted or "pdf" in wanted:
        from reports.document import build_document
        from reports.html import html_of
        from reports.pdf import pdf_of

        document = build_document(results)
        printers: dict[str, Callable[[], bytes]] = {
            "html": lambda: html_of(document).encode("utf-8"),
            "pdf": lambda: pdf_of(document),
        }
        made.update({FORMATS[name]: printers[name]() for name in wanted if name in printers})
    return made


def write_reports(
    results: DriveResults, out: Path, formats: Sequence[str] = tuple(FORMATS), *, replace: bool = False
) -> list[Path]:
    """Write report.html, report.pdf, results.json into `out` (made if needed) and give their paths.

    The archive goes beside them; all files are made before the first is written. replace: these are new results,
    so what an earlier run left of the other formats is taken away. Raises ReportError.
    """
    wanted = check_formats(formats)
    make_folder(out)
    made = report_files(results, wanted)
    # without these nothing in the folder is of a run, and a report.pdf is somebody else's
    ran_before = any((out / name).exists() for name in (FILE_NAME, FORMATS["json"]))
    for name, content in made.items():
        write_whole(out / name, content)
    if replace and ran_before:
        for name in FORMATS.values():
            if name not in made:
                remove_old(out / name)
    return [out / FORMATS[name] for name in wanted]
