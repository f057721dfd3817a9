"""Figures come in pieces that leave no page half empty."""

from __future__ import annotations

import re

from reports.blocks import Document, Plot

A_THIRD_OF_A_PAGE_PT = 285.0


def test_no_piece_of_a_figure_is_taller_than_a_third_of_a_page(rich_document: Document) -> None:
    plots = [b for s in rich_document.sections for b in s.blocks if isinstance(b, Plot)]
    heights = {
        f"{plot.name} {place}": float(re.findall(r'height="([\d.]+)pt"', svg)[0])
        for plot in plots
        for place, svg in enumerate(plot.svgs)
    }
    assert len(heights) > 8
    assert {name: height for name, height in heights.items() if height > A_THIRD_OF_A_PAGE_PT} == {}
