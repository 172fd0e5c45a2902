"""Polynomials and roots as a page for a terminal, and as a root locus over speed."""

from typing import Final

import numpy as np

from trainer.study.characteristic import Motion, Report, Root, Speed
from trainer.study.page import INDENT, figure, root_text, table
from trainer.study.plots import Curve, Panel

HEADS: Final = ("", "root\n[1/s]", "|s|\n[rad/s]", "damping\nratio", "period\n[s]", "")


def _row(root: Root) -> tuple[str, ...]:
    """Return one root as a line of the table."""
    return (
        root.name,
        root_text(root.real, root.imaginary),
        f"{root.frequency_rad_s:.5f}",
        f"{root.damping_ratio:+.3f}",
        figure(root.period_s, ".1f"),
        "" if root.stable else "NOT STABLE",
    )


def _motion(title: str, motion: Motion) -> list[str]:
    """Return the polynomial and roots of one plane of motion."""
    factors = " ".join(f"{factor:.6g}" for factor in motion.polynomial)
    rows = [_row(root) for root in motion.roots]
    return [f"{INDENT}{title}", f"{INDENT}  {factors}", *table(HEADS, rows, 2 * INDENT)]


def _speed(speed: Speed) -> list[str]:
    """Return all that is said about one speed."""
    return [
        "",
        f"{speed.speed_kn:.4g} kn",
        *_motion("vertical plane, EC140: cubic in s, highest power first [SI]", speed.vertical),
        *_motion("horizontal plane, EC200: quartic in s", speed.horizontal),
        *_motion("depth kept by the autopilot of 1969: quartic in s", speed.depth_loop),
    ]


def _adjusted(report: Report) -> list[str]:
    """Return the quasi-linear coefficients, if any motion is averaged in."""
    means = {name: value for name, value in report.means.items() if value != 0.0}
    if not means:
        return []
    units = {"v": "m/s", "w": "m/s", "q": "rad/s", "r": "rad/s"}
    said = ", ".join(f"|{name}| {value:.4g} {units[name]}" for name, value in means.items())
    names = list(report.speeds[0].adjusted)
    rows = [
        (f"{speed.speed_kn:.4g}", *(f"{1e3 * speed.adjusted[name]:.3f}" for name in names))
        for speed in report.speeds
    ]
    heads = ("speed\n[kn]", *names)
    return ["", f"QUASI-LINEAR COEFFICIENTS x 1000 (EC320; mean {said})", *table(heads, rows)]


def render(report: Report) -> str:
    """Return the report as text."""
    signs = {1.0: "with the stern planes", -1.0: "against the stern planes", 0.0: "not used"}
    lines = [
        report.vessel,
        f"{INDENT}speed frozen; in the depth loop the bow planes move {signs[report.bow_sign]}"
        if report.bow_sign
        else f"{INDENT}speed frozen; no bow planes in the depth loop",
        *_adjusted(report),
    ]
    for speed in report.speeds:
        lines += _speed(speed)
    return "\n".join(lines)


def _locus(report: Report, title: str, which: str) -> Panel:
    """Return the roots of one plane of motion at every speed."""
    curves = []
    for speed in report.speeds:
        roots: tuple[Root, ...] = getattr(speed, which).roots
        pairs = [(r.real, sign * r.imaginary) for r in roots for sign in (1.0, -1.0)]
        real, imaginary = np.array(sorted(set(pairs))).T
        curves.append(Curve(f"{speed.speed_kn:.4g} kn", real, imaginary, points=True))
    marks = (("", 0.0),)
    return Panel(title, "real [1/s]", "imaginary [1/s]", tuple(curves), marks)


def panels(report: Report) -> tuple[Panel, ...]:
    """Return the roots of the three motions over speed."""
    return (
        _locus(report, f"{report.vessel}: vertical plane", "vertical"),
        _locus(report, "horizontal plane", "horizontal"),
        _locus(report, "depth kept by the autopilot of 1969", "depth_loop"),
    )
