"""Start-up: `cogest --help` against a two-command Typer program that does nothing, as a ratio from one run.

python benchmarks/startup.py [runs]
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FLOOR = """
import typer

app = typer.Typer()


@app.command()
def one() -> None:
    "Do nothing."


@app.command()
def two() -> None:
    "Do nothing."


app()
"""


def once(command: list[str]) -> float:
    """Wall seconds of one process."""
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - start


def main() -> None:
    """Run both in turn and print the medians and the ratio."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    program = Path(sys.executable).parent / "cogest"
    with tempfile.TemporaryDirectory() as folder:
        floor = Path(folder) / "floor.py"
        floor.write_text(FLOOR, encoding="utf-8")
        ours, theirs = [str(program), "--help"], [sys.executable, str(floor), "--help"]
        once(ours), once(theirs)
        pairs = [(once(ours), once(theirs)) for _ in range(runs)]
    a, b = (statistics.median(column) for column in zip(*pairs, strict=True))
    ratio = statistics.median(x / y for x, y in pairs)
    print(
        f"cogest --help {a * 1000:.0f} ms, Typer floor {b * 1000:.0f} ms, ratio {ratio:.2f} (target: at most 1.3)"
    )


if __name__ == "__main__":
    main()
