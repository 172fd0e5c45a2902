"""The report of ``trainer boat check`` for a terminal: 79 columns of ASCII.

``cli/vessel`` prints it. ``check`` has the figures; here they are only put into tables and
sentences, so that ``--json`` and the page agree.
"""

from collections.abc import Iterator

from trainer.analysis.check import STABILITY_METHODS, CheckReport, StraightFlight, TurnComparison
from trainer.boat.linear import NEUTRAL_TOLERANCE
from trainer.boat.stability import BLAMED_GROWTH
from trainer.report.text import INDENT, PAGE_WIDTH, cut_text, format_number, wrap

TURN_LABELS = {
    "diameter_m": "diameter [m]",
    "speed_kn": "speed [kn]",
    "yaw_rate_deg_s": "yaw rate [deg/s]",
    "heel_deg": "heel [deg]",
}


def _coefficients(report: CheckReport) -> list[str]:
    """Return the absent coefficients, and the numbers that make port and starboard differ."""
    lines = ["", "COEFFICIENTS (absent ones count as zero)"]
    kept = "absent, which the compact set would keep", report.absent_but_kept
    dropped = "absent, of no use to the compact set", report.absent_and_dropped
    for title, groups in (kept, dropped):
        lines += wrap(f"{title}: {sum(map(len, groups.values())) or 'none'}")
        for equation, names in groups.items():
            lines += wrap(" ".join(names), f"{2 * INDENT}{equation}  ", 2 * INDENT + "   ")
    sides = ", ".join(f"{name} {value:.4g}" for name, value in report.asymmetries.items())
    return lines + wrap("port and starboard differ by: " + (sides or "nothing"))


def _hull(report: CheckReport) -> list[str]:
    """Return inertia, margins of stability and critical speeds."""
    inertia = report.inertia
    definite = "positive definite" if inertia.definite else "NOT POSITIVE DEFINITE"
    sweep = ", ".join(f"{name} {rate:.3f}" for name, rate in inertia.contraction.items())
    critical = ", ".join(
        f"{plane} planes {'none' if speed is None else f'{speed:.1f} kn'}"
        for plane, speed in report.critical_speed_kn.items()
    )
    margins = ", ".join(f"{name} {format_number(value)}" for name, value in report.margins.items())
    return [
        "",
        "HULL",
        f"{INDENT}mass matrix             {definite}, condition {inertia.condition:.3g}",
        f"{INDENT}lagged sweep            keeps of an error: {sweep}",
        f"{INDENT}margins of stability    {margins}",
        f"{INDENT}depth control reverses  {critical}",
    ]


def _flight(flight: StraightFlight) -> Iterator[str]:
    """Yield trim and modes at one speed."""
    trim = (
        f"pitch {flight.pitch_deg:+.2f}, stern planes {flight.stern_planes_deg:+.2f}, "
        f"bow planes {flight.bow_planes_deg:+.2f} deg"
        if flight.trimmed
        else "no trim within the plane limits; about level flight, planes at zero"
    )
    yield f"{INDENT}{flight.speed_kn:g} kn: {trim}"
    for row in flight.modes:
        steps = "".join(f"{row.largest_s.get(name, 0.0):>8.3g}" for name in STABILITY_METHODS)
        if not row.stable:
            steps = f"{'unstable' if row.real > NEUTRAL_TOLERANCE else 'neutral':>16}"
        root = f"{row.real:+.4f}" + (f" +-{row.imaginary:.4f}i" if row.imaginary else "")
        period, time = (format_number(x, ".1f") for x in (row.period_s, row.time_constant_s))
        numbers = f"{period:>8}{format_number(row.damping_ratio):>8}{time:>9}"
        yield f"{2 * INDENT}{row.name:<9}{root:<20}{numbers}{steps}"


def _modes(report: CheckReport) -> list[str]:
    """Return the modes by speed, and which modes the boat does not damp."""
    lines = [
        "",
        "MODES (full set; the steps are those of the method's stability region)",
        f"{2 * INDENT}{'':<29}{'period':>8}{'damping':>8}{'1/Re':>9}{'largest step [s]':>18}",
        f"{2 * INDENT}{'':9}{'root [1/s]':20}{'[s]':>8}{'ratio':>8}{'[s]':>9} Adams 2   Euler",
    ]
    wild: dict[str, list[tuple[float, float]]] = {}
    for flight in report.flights:
        lines += _flight(flight)
        for row in flight.modes:
            if row.real > NEUTRAL_TOLERANCE:
                wild.setdefault(row.name, []).append((row.real, flight.speed_kn))
    phrases = []
    for name, entries in wild.items():
        rates, speeds = zip(*entries, strict=True)
        phrases.append(f"{name} up to {max(rates):+.3g} /s ({min(speeds):g} to {max(speeds):g} kn)")
    sentence = "UNSTABLE BY NATURE, at any step: " + "; ".join(phrases)
    return lines + (wrap(sentence) if phrases else [])


def _steps(report: CheckReport) -> list[str]:
    """Return the largest steps of the map flown, and the verdicts."""
    lines = ["", "STEPS (as flown, lagged accelerations; what grows by nature is not counted)"]
    lines += wrap(
        "stable: nothing grows; only a swing that the boat damps by less than "
        f"{BLAMED_GROWTH:.0%} may, by {BLAMED_GROWTH:.0%} of its frequency"
    )
    for equations, limits in report.largest_flown_s.items():
        steps = (limits[name] for name in STABILITY_METHODS)
        adams, euler = ("any" if step is None else f"{step:.3f} s" for step in steps)
        lines.append(f"{INDENT}{equations:<9} largest: Adams 2 {adams}, Euler {euler}")
    for verdict in report.verdicts:
        word = "stable" if verdict.stable else "NOT STABLE"
        why = "" if verdict.stable else f": {verdict.worst} x {verdict.growth:.3f} per tick"
        lines.append(f"{INDENT}{verdict.equations:<9} {verdict.step_s:g} s, Adams 2: {word}{why}")
    return lines


def _turn_lines(turn: TurnComparison) -> Iterator[str]:
    """Yield the compact turn beside the full one."""
    yield ""
    yield f"TURN ({turn.rudder_deg:g} deg rudder at {turn.speed_kn:g} kn; depth {turn.depth})"
    if turn.full is None or turn.modified is None:
        yield from wrap("cannot be compared: " + turn.problem)
        return
    yield f"{INDENT}{'':<18}{'full':>10}{'compact':>10}{'change':>10}"
    for name, label in TURN_LABELS.items():
        change = f"{turn.percent[name]:+.1f} %" if name in turn.percent else "-"
        full, compact = getattr(turn.full, name), getattr(turn.modified, name)
        yield f"{INDENT}{label:<18}{full:>10.3f}{compact:>10.3f}{change:>10}"


def render(report: CheckReport) -> str:
    """Return the report as text."""
    periods = ", ".join(f"{name} {period:.1f} s" for name, period in report.afloat.period_s.items())
    parts = ", ".join(f"{step:g} s in {count}" for step, count in report.afloat.parts.items())
    cut_off = "linear coefficients would feed the boat beyond their range: that is cut off"
    texts = [f"from the defaults file: {', '.join(report.defaulted)}"] * bool(report.defaulted)
    texts += [f"remark: {remark}" for remark in report.remarks]
    texts += [f"note: {note}" for note in report.notes]
    verb = "is" if report.own_step_stable else "is NOT"
    verdict = f"Not every step above is stable; the boat's own, {report.own_step_s:g} s, {verb}."
    lines = [
        report.vessel,
        INDENT + cut_text(report.path, PAGE_WIDTH - len(INDENT)),
        *(line for text in texts for line in wrap(text)),
        *_coefficients(report),
        *_hull(report),
        *_modes(report),
        *_steps(report),
        "",
        "AFLOAT (at the lightest)",
        f"{INDENT}periods                 {periods}",
        f"{INDENT}steps are divided       {parts}",
        *(wrap(cut_off) if report.clipped else []),
        *_turn_lines(report.turn),
        "",
        "All steps above are stable." if report.stable else verdict,
    ]
    return "\n".join(lines)
