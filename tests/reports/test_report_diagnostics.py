"""Diagnostics stand in words with units, in rows of pairs."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sample_results import rich

from pipelines.results import Estimate
from reports.blocks import Folded, Table
from reports.sections import estimators
from reports.sections.diagnostic_words import diagnostic
from reports.text import NARROW


def test_diagnostics_fill_rows_of_pairs() -> None:
    figures = {f"figure_{i}": float(i) for i in range(4)}
    told = replace(rich(), estimates=(Estimate("m", "ran", "", diagnostics=figures),))
    folded = estimators.build(told, {})[-1]
    assert isinstance(folded, Folded)
    table = folded.blocks[-1]
    assert isinstance(table, Table)
    assert [cell.text for cell in table.rows[1]] == ["figure 3", "3", "", "", "", ""]
    (printed,) = folded.printed
    assert isinstance(printed, Table)
    assert [cell.text for cell in printed.rows[0]] == ["m", "figure 0 0; figure 1 1; figure 2 2; figure 3 3"]


@pytest.mark.parametrize(
    ("name", "value", "words", "shown"),
    [
        ("moving_std_m", 0.19043, "spread of the height over the last seconds", f"0.1904{NARROW}m"),
        ("slip_height_std_m", 0.20868, "CG height by the wheels' slip, its spread", f"0.2087{NARROW}m"),
        ("spread_unequal_tyres_m", 0.098454, "height's spread from unequal tyres", f"0.09845{NARROW}m"),
        ("roll_delay_std_s", 0.0087463, "roll delay, spread", f"0.008746{NARROW}s"),
        ("rate_offset_degps", 0.020952, "rate offset", f"0.02095{NARROW}deg/s"),
        ("model_K_own_std", 7904.7, "model's roll stiffness, spread within a cloud", f"7905{NARROW}N·m/rad"),
        ("pitch_by_spring_deflections_chi2", 1.1023, "pitch by spring deflections, chi² a figure", "1.102"),
        ("explained_share", 0.9776, "explained share", f"98{NARROW}%"),
        ("samples", 290.0, "samples", "290"),
        ("blocks", 1.0, "blocks", "1"),
    ],
)  # fmt: skip
def test_names_become_words_and_endings_units(name: str, value: float, words: str, shown: str) -> None:
    assert diagnostic(name, value) == (words, shown)
