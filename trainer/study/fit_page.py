"""A fitted response as a page for a terminal and as a plot."""

from typing import Final

from trainer.core.kernel import Numbers
from trainer.study.fit import Report, Term, response_of
from trainer.study.page import INDENT, WIDTH, cut, figure, root_text, table
from trainer.study.plots import Curve, Panel

HEADS: Final = (
    "",
    "root\n[1/s]",
    "std error\n[1/s]",
    "|s|\n[rad/s]",
    "damping\nratio",
    "amplitude",
    "phase\n[rad]",
)


def _error(term: Term) -> str:
    """Return the standard errors of a root."""
    errors = [term.real_error, *([term.imaginary_error] if term.imaginary else [])]
    return " ".join(figure(error, ".0e") for error in errors)


def _row(label: str, term: Term, error: str) -> tuple[str, ...]:
    """Return one term as a line of the table."""
    return (
        label,
        root_text(term.real, term.imaginary),
        error,
        f"{term.frequency:.5f}",
        f"{term.damping_ratio:+.3f}",
        f"{term.amplitude:+.4g}",
        f"{term.phase_rad:+.3f}" if term.imaginary else "-",
    )


def render(report: Report) -> str:
    """Return the report as text."""
    fit = report.fit
    rows = [_row("start", term, "") for term in fit.start]
    rows += [_row("fit", term, _error(term)) for term in fit.terms]
    state = f"settled in {fit.rounds} rounds" if fit.converged else "DID NOT SETTLE"
    return "\n".join(
        [
            f"FIT OF {report.column} (EC310)",
            f"{INDENT}{cut(report.file, WIDTH - len(INDENT))}",
            f"{INDENT}{report.samples} samples, {report.begin_s:g} to {report.end_s:g} s",
            f"{INDENT}{report.about:.6g} taken off; starting roots from {report.roots_from}",
            "",
            *table(HEADS, rows),
            "",
            f"{INDENT}{state}; left over {fit.rms:.3g} rms, {fit.explained:.4%} explained",
        ]
    )


def panels(report: Report, t: Numbers, y: Numbers) -> tuple[Panel, ...]:
    """Return the response with its fit, and what is left."""
    model = response_of(report.fit.terms, t - t[0])
    label = f"{report.column} less {report.about:.4g}"
    curves = (Curve("response", t, y), Curve("fit", t, model))
    left = (Curve("response less fit", t, y - model),)
    return (
        Panel(f"{report.column}, fitted", "time [s]", label, curves),
        Panel("what is left", "time [s]", label, left, levels=(0.0,)),
    )
