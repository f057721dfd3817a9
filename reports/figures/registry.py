"""The figures of a report, in the order in which they are printed. A new figure is one file and one line here.

matplotlib loads when the first figure is drawn, not when this module is imported.
"""

from __future__ import annotations

from reports.figures import fits, residuals, roll_scatter, scatters, signals, standing, tracks
from reports.figures.drawing import FigureSpec

FIGURES: tuple[FigureSpec, ...] = (
    FigureSpec("roll_scatter", "Roll against lateral acceleration", "lead", roll_scatter.draw),
    FigureSpec("standing", "CG height among measured vehicles", "lead", standing.draw),
    FigureSpec("tracks", "Estimates over the drive", "tracks", tracks.draw),
    FigureSpec("fits", "Measured and modelled", "fits", fits.draw),
    FigureSpec("residuals", "Residuals", "fits", residuals.draw),
    FigureSpec("scatters", "Other relations", "fits", scatters.draw),
    FigureSpec("signals", "Signals", "signals", signals.draw),
)
