"""Rebuild the reference pages from the code's own tables: `python docs/make_reference.py`. A test keeps them fresh."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from parsers.registry import importers  # noqa: E402
from parsers.signals import SIGNALS  # noqa: E402
from parsers.units import SI_TEXT, spellings  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.parameters import PARAMETERS  # noqa: E402
from pipelines.settings import texts  # noqa: E402

NOTE = "<!-- made by docs/make_reference.py: edit the code's tables, not this page -->\n"


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return (
        "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
        + "\n"
    )


def signals_page() -> str:
    """Signals, units, parameters."""
    signals = [
        [f"`{s.name}`", f"`{s.column}`", SI_TEXT[s.quantity], s.description, f"{s.low:g} to {s.high:g}"]
        for s in SIGNALS.values()
    ]
    units = [
        [quantity.replace("_", " "), SI_TEXT[quantity], ", ".join(f"`{word}`" for word in words)]
        for quantity, words in spellings().items()
    ]
    parameters = [[f"`{p.name}`", p.title, p.unit, p.meaning] for p in PARAMETERS.values()]
    return (
        f"# Signals, units, parameters\n\n{NOTE}\n"
        "SI inside, converted once by the mapping. Axes are those of ISO 8855: x forward, y left, z up; roll, pitch and yaw are\n"
        "right-handed about them, so that in a left turn `accel_y` > 0, `yaw_rate` > 0 and the body leans out with `roll` > 0, and in\n"
        "braking `accel_x` < 0 and `pitch` > 0 (nose down). Accelerometers read specific force: at rest `accel_z` is +9.81 m/s².\n"
        "Time is int64 nanoseconds. Wheels: fl, fr, rl, rr. `suspension_deflection` is compression at the wheel, positive, zero for the\n"
        "empty vehicle at rest; a log in which all four stand within half a millimetre of zero before the first motion is taken as zeroed under its load\n"
        "(`deflection_zero` in [vehicle files](vehicle.md)).\n\n## Signals\n\nIn a mapping file a signal goes by its name, in the store by its column.\n\n"
        + _table(["signal", "column", "unit", "what", "possible range"], signals)
        + "\n## Units that are understood\n\nUpper and lower case, spaces, brackets and `²` make no difference (but `mPa` is not `MPa`, and `kN` no knot).\n\n"
        + _table(["quantity", "inside", "spellings"], units)
        + "\nA `road_grade` in per cent is rise over run: 100 % is 45°. No other angle is taken in per cent.\n"
        + "\n## Parameters\n\n"
        + _table(["parameter", "what", "unit", "exactly"], parameters)
    )


def formats_table() -> str:
    """The registered formats."""
    rows = [[i.title, f"`{i.name}`", ", ".join(f"`{s}`" for s in i.suffixes)] for i in importers()]
    return _table(["format", "name", "usual suffixes"], rows)


def settings_page() -> str:
    """Every estimator's needs and settings."""
    parts = [f"# Estimators: needs and settings\n\n{NOTE}"]
    for e in estimators():
        needs = [
            *([f"signal {' or '.join(f'`{n}`' for n in need.any_of)}", need.why] for need in e.signal_needs),
            *(
                [f"vehicle {' or '.join(f'`{n}`' for n in need.any_of)}", need.why]
                for need in e.vehicle_needs
            ),
        ]
        settings = [
            [f"`{s.name}`", f"{s.default:g}", s.unit or "–", f"{s.low:g} to {s.high:g}", s.meaning]
            for s in e.settings
        ]
        settings += [
            [f"`{t.name}`", t.default, "–", ", ".join(f"`{c}`" for c in t.choices), t.meaning]
            for t in texts(e)
        ]
        parts.append(
            f"## {e.name}: {e.title}\n\nSource: {e.source}\n\nGives: {', '.join(f'`{p}`' for p in e.parameters)}\n\n"
            + _table(["needs", "why"], needs)
            + "\n"
            + _table(["setting", "default", "unit", "range", "meaning"], settings)
        )
    return "\n".join(parts)


def speed_table() -> str:
    """Format, peer and ratios of the import benchmark's last saved run, with what the conversion of a BLF drive takes."""
    results = HERE.parent / "benchmarks" / "results"
    lines = (results / "import_speed.md").read_text(encoding="utf-8").splitlines()
    table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    head, rows = table[0], table[2:]
    chosen = [head.index(name) for name in ("format", "peer", "peer CPU s", "cogest CPU s", "ratio")]
    return _table([head[k] for k in chosen], [[row[k] for k in chosen] for row in rows])


def _between(path: Path, name: str, content: str) -> str:
    """A page with what stands between two marks replaced."""
    begin, end = f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"
    head, rest = path.read_text(encoding="utf-8").split(begin)
    return head + begin + content + end + rest.split(end)[1]


def pages() -> dict[Path, str]:
    """Path -> text of every generated page."""
    formats, readme = HERE / "formats.md", HERE.parent / "README.md"
    return {
        HERE / "signals.md": signals_page(),
        HERE / "settings.md": settings_page(),
        formats: _between(formats, "formats", formats_table()),
        readme: _between(readme, "speed", speed_table()),
    }


if __name__ == "__main__":
    for path, content in pages().items():
        path.write_text(content, encoding="utf-8")
