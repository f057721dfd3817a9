"""The chapters behind the first screen, in order. A new chapter is one file and one line here."""

from __future__ import annotations

from reports.sections import (
    assumptions,
    errors,
    estimators,
    mapping,
    methods,
    plots,
    provenance,
    quality,
    reading,
    rollover_page,
    taught,
    tire_forces,
    verdict,
)
from reports.sections.contract import SectionSpec

SECTIONS: tuple[SectionSpec, ...] = (
    SectionSpec("taught", "What the drive taught", "Taught", taught.build, taught.INTRO),
    SectionSpec("detail", "Verdict in detail", "Detail", verdict.build_detail, verdict.DETAIL_INTRO),
    SectionSpec("rollover", "Rollover", "Rollover", rollover_page.build, rollover_page.INTRO),
    SectionSpec("tire_forces", "Tyre normal forces", "Tyre forces", tire_forces.build, tire_forces.INTRO),
    SectionSpec("errors", "Against the reference", "Reference", errors.build, errors.INTRO),
    SectionSpec("methods", "Methods beside the verdict", "Methods", methods.build, methods.INTRO),
    SectionSpec("tracks", "Estimates over the drive", "Tracks", plots.tracks),
    SectionSpec("fits", "Fit and residuals", "Fit", plots.fits),
    SectionSpec("signals", "Signals", "Signals", plots.signals),
    SectionSpec("quality", "Data quality", "Data quality", quality.build),
    SectionSpec("mapping", "Which channel became which signal", "Mapping", mapping.build),
    SectionSpec("estimators", "Estimators", "Estimators", estimators.build, estimators.INTRO),
    SectionSpec(
        "assumptions", "What was taken as given", "Assumptions", assumptions.build, assumptions.INTRO
    ),
    SectionSpec("reading", "How to read this report", "Reading", reading.build),
    SectionSpec("provenance", "Where this report comes from", "Provenance", provenance.build),
)
