"""Every error that cogest raises on purpose.

CogestError                 the root: one message for the user, exit code 1; 2 where the command line itself is wrong
├── LogError                a log cannot be read: names the file, the place, what was found and expected
├── MappingError            a mapping file or profile is wrong
├── DatabaseError           a CAN database (DBC) cannot be used
├── VehicleError            a vehicle file is wrong
├── SettingsError           a settings file is wrong, or an estimator's name is unknown
├── ExpansionError          a polynomial chaos expansion cannot be built as asked
└── ReportError             a report cannot be made or written
"""

from __future__ import annotations

from pathlib import Path

from parsers.places import as_path
from parsers.places_text import masked


class CogestError(Exception):
    """A known error. `str()` is the one line that the user sees."""

    def __init__(
        self,
        problem: str,
        *,
        path: Path | str | None = None,
        place: str | None = None,
        hint: str | None = None,
        wrong_usage: bool = False,
    ) -> None:
        """Build the line `path, place: problem; hint`.

        problem: what was found and what was expected. place: line, byte or time. hint: the next step.
        wrong_usage: a name or a number that was asked for does not exist, whatever the files hold.
        """
        self.problem = problem
        self.path = None if path is None else as_path(path)
        self.place = place
        self.hint = hint
        self.wrong_usage = wrong_usage
        shown = masked(path) if isinstance(path, str) else path
        where = ", ".join(str(part) for part in (shown, place) if part)
        line = f"{where}: {problem}" if where else problem
        super().__init__(f"{line}; {hint}" if hint else line)


class LogError(CogestError):
    """A log cannot be read."""


class MappingError(CogestError):
    """A mapping file or profile is wrong."""


class DatabaseError(CogestError):
    """A CAN database cannot be used."""


class VehicleError(CogestError):
    """A vehicle file is wrong."""


class SettingsError(CogestError):
    """A settings file is wrong, or an estimator's name is unknown."""


class ExpansionError(CogestError):
    """A polynomial chaos expansion cannot be built as asked: shapes, sizes, points that do not determine it."""


class ReportError(CogestError):
    """A report cannot be made or written."""


class EngineError(CogestError):
    """Workers cannot be started, reached or used."""


class StoreError(CogestError):
    """A results store cannot be read or written, or is not one."""
