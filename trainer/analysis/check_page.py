"""The report of ``trainer check`` as a page for a terminal, 79 columns of ASCII."""

import textwrap
from collections.abc import Mapping

from trainer.analysis.check import REGIONS, Comparison, Flight, ModeRow, Report
from trainer.boat.linear import NEUTRAL
from trainer.boat.stability import BARELY

WIDTH = 79
INDENT = "  "
LABELS = {
    "diameter_m": "diameter [m]",
    "speed_kn": "speed [kn]",
    "yaw_rate_deg_s": "yaw rate [deg/s]",
    "heel_deg": "heel [deg]",
}


def _wrap(text: str, first: str = INDENT, rest: str = 2 * INDENT) -> list[str]:
    """Return ``text`` in lines of the page."""
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=rest)


def _end_of(path: str, width: int) -> str:
    """Return a path in ``width`` characters of ASCII, its end if all of it does not fit."""
    plain = path.encode("ascii", "replace").decode()
    return plain if len(plain) <= width else "..." + plain[3 - width :]


def _figure(number: float | None, form: str = ".2f") -> str:
    """Return ``number`` as text, '-' for none."""
    return "-" if number is None else format(number, form)


def _group(title: str, groups: Mapping[str, list[str]]) -> list[str]:
    """Return ``title`` with the count, and one paragraph per equation."""
    lines = _wrap(f"{title}: {sum(map(len, groups.values())) or 'none'}")
    for equation, names in groups.items():
        lines += _wrap(" ".join(names), f"{2 * INDENT}{equation}  ", 2 * INDENT + "   ")
    return lines


def _file(report: Report) -> list[str]:
    """Return where the numbers come from."""
    lines = [report.vessel, INDENT + _end_of(report.path, WIDTH - len(INDENT))]
    if report.defaulted:
        lines += _wrap("from the defaults file: " + ", ".join(report.defaulted))
    for remark in report.remarks:
        lines += _wrap("remark: " + remark)
    return lines


def _coefficients(report: Report) -> list[str]:
    """Return what is absent and what makes the sides differ."""
    lines = ["", "COEFFICIENTS (absent ones count as zero)"]
    lines += _group("absent, which the compact set would keep", report.absent_but_kept)
    lines += _group("absent, of no use to the compact set", report.absent_and_dropped)
    sides = ", ".join(f"{name} {value:.4g}" for name, value in report.asymmetries.items())
    return lines + _wrap("port and starboard differ by: " + (sides or "nothing"))


def _hull(report: Report) -> list[str]:
    """Return inertia, margins of stability and critical speeds."""
    inertia = report.inertia
    definite = "positive definite" if inertia.definite else "NOT POSITIVE DEFINITE"
    sweep = ", ".join(f"{name} {rate:.3f}" for name, rate in inertia.contraction.items())
    critical = ", ".join(
        f"{plane} planes {'none' if speed is None else f'{speed:.1f} kn'}"
        for plane, speed in report.critical_speed_kn.items()
    )
    margins = ", ".join(f"{name} {_figure(value, '.3f')}" for name, value in report.margins.items())
    return [
        "",
        "HULL",
        f"{INDENT}mass matrix             {definite}, condition {inertia.condition:.3g}",
        f"{INDENT}lagged sweep            keeps of an error: {sweep}",
        f"{INDENT}margins of stability    {margins}",
        f"{INDENT}depth control reverses  {critical}",
    ]


def _mode(row: ModeRow) -> str:
    """Return one mode as a line of the table."""
    root = f"{row.real:+.4f}" + (f" +-{row.imaginary:.4f}i" if row.imaginary else "")
    steps = "".join(f"{row.largest_s.get(name, 0.0):>8.3g}" for name in REGIONS)
    if not row.stable:
        steps = f"{'unstable' if row.real > NEUTRAL else 'neutral':>16}"
    return (
        f"{2 * INDENT}{row.name:<9}{root:<20}{_figure(row.period_s, '.1f'):>8}"
        f"{_figure(row.damping_ratio, '.3f'):>8}{_figure(row.time_constant_s, '.1f'):>9}{steps}"
    )


def _wild(report: Report) -> list[str]:
    """Return what the boat does not damp, one phrase for each motion."""
    found: dict[str, list[tuple[float, float]]] = {}
    for flight in report.flights:
        for row in flight.modes:
            if row.real > NEUTRAL:
                found.setdefault(row.name, []).append((row.real, flight.speed_kn))
    phrases = []
    for name, entries in found.items():
        rates, speeds = zip(*entries, strict=True)
        phrases.append(f"{name} up to {max(rates):+.3g} /s ({min(speeds):g} to {max(speeds):g} kn)")
    return _wrap("UNSTABLE BY NATURE, at any step: " + "; ".join(phrases)) if phrases else []


def _flight(flight: Flight) -> list[str]:
    """Return trim and modes at one speed."""
    trim = (
        f"pitch {flight.pitch_deg:+.2f}, stern planes {flight.stern_planes_deg:+.2f}, "
        f"bow planes {flight.bow_planes_deg:+.2f} deg"
        if flight.trimmed
        else "no trim within the plane limits; about level flight, planes at zero"
    )
    return [f"{INDENT}{flight.speed_kn:g} kn: {trim}", *(_mode(row) for row in flight.modes)]


def _modes(report: Report) -> list[str]:
    """Return the modes by speed, and what the boat does not damp."""
    lines = [
        "",
        "MODES (full set; the steps are those of the method's stability region)",
        f"{2 * INDENT}{'':<29}{'period':>8}{'damping':>8}{'1/Re':>9}{'largest step [s]':>18}",
        f"{2 * INDENT}{'':9}{'root [1/s]':20}{'[s]':>8}{'ratio':>8}{'[s]':>9} Adams 2   Euler",
    ]
    for flight in report.flights:
        lines += _flight(flight)
    return lines + _wild(report)


def _steps(report: Report) -> list[str]:
    """Return the largest steps of the map flown, and the verdicts."""
    lines = ["", "STEPS (as flown, lagged accelerations; what grows by nature is not counted)"]
    lines += _wrap(
        f"stable: nothing grows; only a swing that the boat damps by less than {BARELY:.0%} may, "
        f"by {BARELY:.0%} of its frequency"
    )
    for equations, limits in report.largest_flown_s.items():
        adams, euler = (
            "any" if limits[name] is None else f"{limits[name]:.3f} s" for name in REGIONS
        )
        lines.append(f"{INDENT}{equations:<9} largest: Adams 2 {adams}, Euler {euler}")
    for verdict in report.verdicts:
        word = "stable" if verdict.stable else "NOT STABLE"
        why = "" if verdict.stable else f": {verdict.worst} x {verdict.growth:.3f} per tick"
        lines.append(f"{INDENT}{verdict.equations:<9} {verdict.step_s:g} s, Adams 2: {word}{why}")
    return lines


def _afloat(report: Report) -> list[str]:
    """Return the boat at the surface, and what it is beyond the range of its coefficients."""
    periods = ", ".join(f"{name} {period:.1f} s" for name, period in report.afloat.period_s.items())
    parts = ", ".join(f"{step:g} s in {count}" for step, count in report.afloat.parts.items())
    lines = [
        "",
        "AFLOAT (at the lightest)",
        f"{INDENT}periods                 {periods}",
        f"{INDENT}steps are divided       {parts}",
    ]
    if report.clipped:
        lines += _wrap(
            "linear coefficients would feed the boat beyond their range: that is cut off"
        )
    return lines


def _turn(turn: Comparison) -> list[str]:
    """Return the compact turn beside the full one."""
    head = f"TURN ({turn.rudder_deg:g} deg rudder at {turn.speed_kn:g} kn; depth {turn.depth})"
    lines = ["", head]
    if turn.full is None or turn.modified is None:
        return lines + _wrap("cannot be compared: " + turn.problem)
    lines.append(f"{INDENT}{'':<18}{'full':>10}{'compact':>10}{'change':>10}")
    for name, label in LABELS.items():
        change = f"{turn.percent[name]:+.1f} %" if name in turn.percent else "-"
        full, compact = getattr(turn.full, name), getattr(turn.modified, name)
        lines.append(f"{INDENT}{label:<18}{full:>10.3f}{compact:>10.3f}{change:>10}")
    return lines


def _verdict(report: Report) -> str:
    """Return which steps are stable, the boat's own above all."""
    if report.stable:
        return "All steps above are stable."
    own = "is" if report.own_step_stable else "is NOT"
    return f"Not every step above is stable; the boat's own, {report.own_step_s:g} s, {own}."


def render(report: Report) -> str:
    """Return the report as text."""
    lines = [
        *_file(report),
        *_coefficients(report),
        *_hull(report),
        *_modes(report),
        *_steps(report),
        *_afloat(report),
        *_turn(report.turn),
        "",
        _verdict(report),
    ]
    return "\n".join(lines)
