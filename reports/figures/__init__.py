"""Figures of a report: one file a plot, one line each in `reports.figures.registry`."""
