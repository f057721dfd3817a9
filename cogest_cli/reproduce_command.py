"""`cogest reproduce`: the published tables and claims beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def reproduce(
    paper: Annotated[
        str | None,
        typer.Argument(
            metavar="[PAPER]", help="pence, park, wu, berntorp …; default: all of them.", show_default=False
        ),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(
            help="Noise seeds of the study against the bound; default: 50; pence 200, berntorp 1000.",
            min=2,
            max=10_000,
            show_default=False,
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(help="Seed of the random numbers; the same seed gives the same figures.", min=0)
    ] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder for a page a paper; default: print only.", show_default=False)
    ] = None,
    formats: Annotated[str, typer.Option("--format", help="What to write into --out.")] = "html,pdf,json",
) -> None:
    """Do a paper again: its tables and claims beside ours, with the errors against the Cramér-Rao bound."""
    import zlib

    import numpy as np

    from cogest_cli.options import check_out
    from cogest_cli.output import show, show_line
    from cogest_cli.progress import ProgressLine
    from cogest_cli.version import version
    from pipelines.reproduce.registry import PAPERS, RUNS, RUNS_OF, choose_papers
    from pipelines.reproduce.registry import paper as load
    from reports.files import make_folder
    from reports.layout import terminal_width
    from reports.write import check_formats

    wanted = check_formats(formats)
    chosen = choose_papers(paper, PAPERS)
    if out is not None:
        check_out(out)
        make_folder(out)
    from reports.reproduction_text import reproduction_text, write_reproduction

    for place, name in enumerate(chosen):
        with ProgressLine() as progress:
            # each paper has its own generator: its figures do not change with the company it is asked for in
            rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
            result = load(name).reproduce(runs or RUNS_OF.get(name, RUNS), rng, progress)
        if place:
            show("")
        show(reproduction_text(result, terminal_width()))
        if out is not None:
            for path in write_reproduction(result, version(), out, wanted):
                show_line(path)
