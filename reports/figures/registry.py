"""The figures of a report, in the order in which they are printed. A new figure is one file and one line here.

matplotlib loads when the first figure is drawn, not when this module is imported.
"""

from __future__ import annotations

from reports.figures import (
    distributions,
    fits,
    learned,
    methods,
    residuals,
    roll_scatter,
    rollover_drive,
    rollover_limits,
    scatters,
    shares,
    signals,
    standing,
    tire_forces,
    tracks,
)
from reports.figures.drawing import FigureSpec

FIGURES: tuple[FigureSpec, ...] = (
    FigureSpec("roll_scatter", "Roll against lateral acceleration", "lead", roll_scatter.draw),
    FigureSpec("standing", "CG height among measured vehicles", "lead", standing.draw),
    FigureSpec("learned", "Before and after", "taught", learned.draw),
    FigureSpec("shares", "Which relation brought how much", "taught", shares.draw),
    FigureSpec("rollover_limits", "Limits to both sides", "rollover", rollover_limits.draw),
    FigureSpec("rollover_margin", "Margin over the drive", "rollover", rollover_drive.draw_margin),
    FigureSpec("rollover_coefficient", "Rollover coefficient", "rollover", rollover_drive.draw_coefficient),
    FigureSpec("tire_forces", "Forces over the drive", "tire_forces", tire_forces.draw),
    FigureSpec("methods", "Verdict and methods side by side", "methods", methods.draw),
    FigureSpec("tracks", "Estimates over the drive", "tracks", tracks.draw),
    FigureSpec("distributions", "Distributions over the drive", "tracks", distributions.draw),
    FigureSpec("fits", "Measured and modelled", "fits", fits.draw),
    FigureSpec("residuals", "Residuals", "fits", residuals.draw),
    FigureSpec("scatters", "Other relations", "fits", scatters.draw),
    FigureSpec("signals", "Signals", "signals", signals.draw),
)
