"""``trainer identify --data-only``: a record by itself, before any fit, as text and as plots.

``cli/workshop/identify`` prints it. A wrong unit, sign or gap is seen here, before it spoils a fit.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.record.measurements import CHANNEL_UNITS, Record
from trainer.identify.record.study import Study, observe_record, studies_of
from trainer.identify.sheet import input_curve, screens_of
from trainer.report.plots import Curve, Panel, Screen
from trainer.report.text import INDENT, cut_text, items, table
from trainer.units import DEGREE, KNOT


@dataclass(frozen=True)
class ChannelSummary:
    """The values of one column in few numbers, all in its ``unit``."""

    name: str
    unit: str
    samples: int
    missing: int
    mean: float
    deviation: float
    least: float
    largest: float


@dataclass(frozen=True)
class EvidenceSummary:
    """What channels say of each other: found, and what is usual."""

    test: str
    found: float
    least: float
    largest: float | None  # None: there is no limit
    agrees: bool


@dataclass(frozen=True)
class RecordSummary:
    """One record: its times, oddities and columns."""

    source: str
    samples: int
    interval_s: float
    begin_s: float
    end_s: float
    between_readings: str  # one of fit_options.INPUT_PATHS, of the inputs
    findings: tuple[str, ...]
    channels: tuple[ChannelSummary, ...]
    evidence: tuple[EvidenceSummary, ...]


@dataclass(frozen=True)
class RecordReport:
    """All that ``trainer identify --data-only`` says."""

    study: str
    runs: tuple[RecordSummary, ...]


def carry_out(study: Study) -> tuple[RecordReport, tuple[Screen, ...]]:
    """Return what a study's records hold, and their figures. ConfigError if one is unusable."""
    seen = [observe_record(one) for one in studies_of(study)]
    report = RecordReport(study.heading.name, tuple(map(_run, seen)))
    groups = {one.source: _panels(one) for one in seen}
    return report, screens_of(groups)


def _columns(record: Record) -> Iterator[tuple[str, str, Numbers]]:
    """Yield name, unit and values of each column, in the models' units."""
    for name in record.channels:
        unit, by = OUTPUT_UNITS.get(
            name, ("kn", 1.0 / KNOT) if name == "speed" else ("deg", 1.0 / DEGREE)
        )
        yield name, unit, record.column(name) * by
    for name, values in record.plain.items():
        yield name, "-", values


def _run(record: Record) -> RecordSummary:
    channels = []
    for name, unit, values in _columns(record):
        known = values[~np.isnan(values)]
        sizes = (float(size(known)) for size in (np.mean, np.std, np.min, np.max))
        channels.append(ChannelSummary(name, unit, len(known), len(values) - len(known), *sizes))
    return RecordSummary(
        source=record.source,
        samples=len(record.t),
        interval_s=record.interval,
        begin_s=float(record.t[0]),
        end_s=float(record.t[-1]),
        between_readings=record.between_readings,
        findings=tuple(map(str, record.findings)),
        channels=tuple(channels),
        evidence=tuple(
            EvidenceSummary(
                one.test, one.found, low, None if math.isinf(high) else high, one.agrees()
            )
            for one in record.evidence
            for low, high in (one.limits,)
        ),
    )


def _panels(record: Record) -> Iterator[Panel]:
    """Yield each column over time; inputs are drawn as they act."""
    for name, unit, values in _columns(record):
        acts = name == "rudder" or name in record.driving
        title = "rudder, positive to port" if name == "rudder" and name in CHANNEL_UNITS else name
        curve = Curve(name, record.t, values, points=True)
        curve = input_curve(name, record.t, values, record.between_readings) if acts else curve
        yield Panel(title, "time [s]", f"[{unit}]", (curve,))


def render(report: RecordReport) -> str:
    """Return the page of a record."""
    lines = ["RECORD", f"{INDENT}{cut_text(report.study, 70)}"]
    for run in report.runs:
        span = f"{run.samples} samples every {run.interval_s:g} s"
        lines += ["", f"{INDENT}{cut_text(run.source, 75)}"]
        lines += [f"{INDENT}{span}, from {run.begin_s:g} s to {run.end_s:g} s"]
        lines += items(run.findings)
        rows = []
        for one in run.channels:
            sizes = (one.mean, one.deviation, one.least, one.largest)
            known = (one.name, one.unit, str(one.samples), str(one.missing))
            rows.append((*known, *(f"{size:.4g}" for size in sizes)))
        heads = ("column", "unit", "known", "missing", "mean", "std dev", "least", "largest")
        lines += ["", *table(heads, rows)]
        rows = [
            (
                one.test,
                f"{one.found:.3g}",
                f"{one.least:.3g}",
                "" if one.largest is None else f"{one.largest:.3g}",
                "agrees" if one.agrees else "does not",
            )
            for one in run.evidence
        ]
        lines += (
            ["", *table(("channels compared", "found", "from", "to", ""), rows)] if rows else []
        )
    return "\n".join(lines)
