"""Relations at another place than where they were made linear, as far as the load's moments decide.

A drive's rows are slopes at its own mode. Joined with other drives its unknowns move, and most relations see the load through its
mass and its moments: load x load_h is what lifts the CG, not load_h alone. A relation that is linear in load and moment has

    p(v) = linear(v) + c (load - load₀) (load_h - load_h₀),   c = slope by load_h / load₀,

with all of it known from the row. So rows can be made linear anew anywhere; what else is curved stays as it was at the mode.
"""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray

PLACES = ("load_x", "load_y", "load_h")
LEAST_KG = 15.0
"""Below this load the slope by its place is too small to tell the product's: taken as if this were the load."""


def at_place(
    names: tuple[str, ...], rows: FloatArray, observed: FloatArray, mode: FloatArray, place: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows (m, k) and observed (m,) of relations linear about `mode` (k,), made linear about `place` (k,), SI.

    Without a load among the unknowns they are given back as they are.
    """
    if not {"load", *PLACES} <= set(names):
        return rows, observed
    load = names.index("load")
    kilos = np.copysign(max(abs(float(mode[load])), LEAST_KG), float(mode[load]))
    more = float(place[load] - mode[load])
    rows, observed = rows.copy(), observed.copy()
    for name in PLACES:
        column = names.index(name)
        c = rows[:, column] / kilos
        away = float(place[column] - mode[column])
        rows[:, load] += c * away
        rows[:, column] += c * more
        observed += c * (away * place[load] + more * place[column] - more * away)
    return rows, observed
