"""Drawings of the log, of the time line, and of the ledger of the ticks.

``app`` has log and time line on every screen, and ``layouts`` the ledger and casualties on the
instructor's. A drawing takes the model, and the columns and rows that there are; it returns lines
and changes nothing.
"""

from trainer.console.drawing.chart import TICK_SPACINGS_S
from trainer.console.drawing.values import course, no_value_reason, number
from trainer.console.journal import TimelineMoment, clock, wrap_entry
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Run, fit, line

MIN_TIMELINE_COLUMNS = 24  # [columns] of a time line
CUT_SIGN = " ..."
MOMENT_COLUMNS = 15  # [columns] from moment to moment named on it, at least
SHIP_NAME_COLUMNS = 9  # [columns]
SHIP_PARTS = ("bearing", "range", "course", "speed", "cpa", "tcpa")
SHIPS_HEADING = " ship      brg  range crs kn   cpa  sec"


def log(model: SessionModel, width: int, height: int) -> Lines:
    """Return the last entries, the newest at the bottom.

    Where there is no room for all of the newest, its beginning is shown, which has what matters.
    """
    journal = model.journal
    newest = wrap_entry(journal.entries[-1], width) if journal.entries else []
    cut = 0 if journal.back else max(len(newest) - height, 0)
    rows: list[tuple[str, str, str]] = []
    for entry in reversed(journal.entries):
        rows[:0] = wrap_entry(entry, width)
        if len(rows) >= height + journal.back:
            break
    back = cut or min(journal.back, max(len(rows) - height, 0))
    shown = rows[max(len(rows) - height - back, 0) : len(rows) - back]
    lines = [line((f" {when} ", "dim"), (text, ink)) for when, text, ink in shown]
    if cut and lines:
        when, text, ink = shown[-1]
        words = text.split()
        while len(words) > 1 and len(f" {when} {' '.join(words)}{CUT_SIGN}") > width:
            words.pop()
        lines[-1] = line((f" {when} ", "dim"), (f"{' '.join(words)}{CUT_SIGN}", ink))
    elif back and lines:
        lines[-1] = line((f" ... {back} more lines below: Page Down", "warning"))
    return [*(fit(each, width) for each in lines), *[fit(line(), width)] * (height - len(lines))]


def time_line(model: SessionModel, width: int, _height: int) -> Lines:
    """Return the run in one line: moments, plans, a bar for the present."""
    now, end = model.picture.seconds, end_of(model)
    start_label = line((" 00:00 ", "dim"))
    right = line((f" {clock(end)} ", "dim"))
    room = width - sum(len(text) for text, _ in (*start_label, *right))
    if room < MIN_TIMELINE_COLUMNS:
        return [fit(line((f" {clock(now)}", "dim")), width)]
    return [(*start_label, *scale(model, now, end, room), *right)]


def time_at(model: SessionModel, width: int, column: int) -> float:
    """Return the time [s] at a column of the line of time."""
    end = end_of(model)
    label_width, right = len(" 00:00 "), 10
    share = (column - label_width) / max(width - label_width - right - 1, 1)
    return min(max(share, 0.0), 1.0) * end


def end_of(model: SessionModel) -> float:
    """Return how long the line of time is [s]: flown, and planned."""
    ahead = (each.seconds for each in model.timeline.plans)
    return max(model.picture.seconds, model.timeline.furthest, 1.0, *ahead)


def moments(model: SessionModel) -> list[TimelineMoment]:
    """Return the snapshots, marks and casualties on the time line, oldest first."""
    return sorted([*model.timeline.snapshots, *model.timeline.marks], key=lambda kept: kept.seconds)


def scale(model: SessionModel, now: float, end: float, room: int) -> tuple[Run, ...]:
    """Return the line from the start to the end in ``room`` columns."""

    def column(seconds: float) -> int:
        return min(max(round(seconds / end * (room - 1)), 0), room - 1)

    signs: list[Run] = [("━" if at <= column(now) else "╌", "dim") for at in range(room)]
    for plan in model.timeline.plans:
        signs[column(plan.seconds)] = (plan.sign, "ordered")
    for moment in moments(model):
        signs[column(moment.seconds)] = (moment.sign, "warning")
    signs[column(now)] = ("┃", "value")
    least = end * MOMENT_COLUMNS / room
    rough = TICK_SPACINGS_S[-1] * -(-least // TICK_SPACINGS_S[-1])
    step = next((each for each in TICK_SPACINGS_S if each >= least), rough)
    for k in range(1, int(end / step) + 1):
        named = f" {clock(k * step).removeprefix('00:')} "  # in the middle of its moment
        cells = slice(first := column(k * step) - len(named) // 2, first + len(named))
        if cells.stop < room and all(sign in "━╌" for sign, _ in signs[cells]):
            signs[cells] = [(letter, "dim") for letter in named]
    return tuple(signs)


def ledger(model: SessionModel, width: int, height: int) -> Lines:
    """Return the ledger of the ticks in five lines."""
    picture = model.picture

    def told(name: str, decimals: int = 0) -> str:
        return number(picture.number("ledger", name), decimals)

    lines = [
        line(
            (" ledger   ", "heading"),
            (f"{told('ticks')} ticks, duty {told('duty_cycle', 3)} %", "plain"),
        ),
        row("overruns", f"{told('overruns')}, caught up {told('caught_up')}"),
        row("slipped", f"{told('slipped')}, gaps {told('gaps')}"),
        row("work", f"{told('work_p50')} us, at most {told('work_most')} us"),
        row("late", f"{told('late_p50')} us, at most {told('late_most')} us"),
    ]
    return [fit(each, width) for each in lines[:height]]


def row(label: str, text: str) -> Line:
    """Return a labelled line."""
    return line((f" {label:<9}", "dim"), (text, "plain"))


def suffering(model: SessionModel, width: int, height: int) -> Lines:
    """Return the casualties: kind, present degree, and seconds until it is there or gone."""
    picture = model.picture
    lines = [fit(line((" casualties", "heading")), width, "heading")]
    for name in picture.rows("casualties", "casualty_"):
        if not name[-1].isdigit():
            continue
        target, seconds = (
            picture.number("casualties", f"{name}_{part}") for part in ("target", "left")
        )
        going = (
            "" if not seconds else (" going" if target == 0.0 else " coming") + f", {seconds:.0f} s"
        )
        says = picture.word("casualties", f"{name}_says")
        lines.append(
            line((f" {picture.word('casualties', name)} ", "alarm"), f" {says}{going}".rstrip())
        )
    if len(lines) == 1:
        text = no_value_reason(picture, "casualties", "none; F4 lists what can break")
        lines.append(line((f" {text}", "dim")))
    return [fit(each, width) for each in lines[:height]]


def around(model: SessionModel, width: int, height: int) -> Lines:
    """Return the casualties, and the ships near if there are any."""
    broken, near = suffering(model, width, height), ships(model, width)
    return [*broken, *near][:height]


def ships(model: SessionModel, width: int) -> Lines:
    """Return the ships near: bearing, range, course, speed, closest approach and time to it."""
    picture = model.picture
    names = [name for name in picture.rows("contacts", "contact_") if name[-1].isdigit()]
    if not names:
        return []
    rows = [line((SHIPS_HEADING, "heading")), *(ship_row(model, name) for name in names)]
    return [fit(each, width) for each in rows]


def ship_row(model: SessionModel, name: str) -> Line:
    """Return the line of one ship. A closest approach in the past has no time."""
    picture = model.picture
    values = {part: picture.number("contacts", f"{name}_{part}") for part in SHIP_PARTS}
    until = values["tcpa"]
    when = "past" if until is not None and until < 0.0 else number(until, 0)
    return line(
        (" ", "value"),
        *fit(line((picture.word("contacts", name), "value")), SHIP_NAME_COLUMNS),
        f" {course(values['bearing']):>3} {number(values['range'], 0):>6}"
        f" {course(values['course']):>3} {number(values['speed'], 0):>2}"
        f" {number(values['cpa'], 0):>5} {when:>4}",
    )
