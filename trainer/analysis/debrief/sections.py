"""The tables of a debrief, as HTML."""

import re
from collections.abc import Iterator
from typing import Final

from markupsafe import Markup

from trainer.analysis.debrief.data import Answered, DebriefData
from trainer.analysis.debrief.episodes import SCHEDULE
from trainer.analysis.debrief.scoring import Scored, Verdict
from trainer.analysis.report.html import paragraph, table
from trainer.analysis.report.svg import clock

MOST: Final = 1000  # lines of the log
PLACED: Final = re.compile(r"tick \d+ \([\d.]+ s\): ")  # in an event that says its own place
TOLD: Final = 4  # digits of a value that count


def number(value: float | None) -> str:
    """Return a value as it is told, '-' for none."""
    return "-" if value is None else f"{value:.{TOLD}g}"


def place(debrief: DebriefData, tick: int | None) -> str:
    """Return a moment of the record as time and tick."""
    if tick is None:
        return "-"
    return Markup("{} <small>tick {}</small>").format(clock(tick * debrief.step), tick)


def verdict(debrief: DebriefData) -> Markup:
    """Return the marks of the whole, in words."""
    card = debrief.card
    if not card.scores:
        return paragraph("This run has no scoring rules.")
    if card.verdict is not None:
        return judged(debrief, card.verdict)
    counted = sum(each.marks is not None for each in card.scores)
    total = "-" if card.total is None else f"{card.total:.0f}"
    lines = [Markup('<p class="total"><b>{}</b> of 100 marks</p>').format(total)]
    if counted < len(card.scores):
        lines.append(paragraph(f"{counted} of {len(card.scores)} rules count."))
    if lacking := _unflown(debrief):
        lines.append(paragraph(lacking))
    return Markup().join(lines)


def judged(debrief: DebriefData, verdict: Verdict) -> Markup:
    """Return won, lost or not reached with the reason, and what the marks are made of."""
    card = debrief.card
    total = "no" if card.total is None else f"{card.total:.0f}"
    crew = debrief.plan.baseline.crew if debrief.plan.baseline else None
    unsure = f", +-{crew.deviation:.0f} by the sea alone" if crew and crew.deviation >= 0.5 else ""
    lines = [
        Markup('<p class="total"><b>{}</b></p>').format(verdict.outcome.capitalize()),
        *([paragraph(f"{verdict.reason}.")] if verdict.reason else []),
        Markup('<p class="total"><b>{}</b> of 100 marks{}</p>').format(total, unsure),
        paragraph(made_of(verdict)),
    ]
    if debrief.branch.parent is not None:
        lines.append(paragraph("Practice: time was wound back in this run."))
    if lacking := _unflown(debrief):
        lines.append(paragraph(lacking))
    return Markup().join(lines)


def made_of(verdict: Verdict) -> str:
    """Return what a total is made of, in words."""
    told = f"Tasks {verdict.tasks:.0f}, less nobody aboard; keeping {verdict.keeping:.0f}"
    if verdict.void:
        return f"{told}. The boat turned over: the marks are void."
    if verdict.free:
        return f"{told}. A free run has no marks."
    if verdict.cap is not None:
        why = "the exercise was lost" if verdict.outcome == "lost" else "a limit was broken"
        return f"{told}. At most {verdict.cap:.0f}: {why}."
    return f"{told}; total = tasks x (0.7 + 0.3 x keeping / 100)."


def _unflown(debrief: DebriefData) -> str:
    """Return that the record ends before the exercise, '' if it does not."""
    flown, planned = float(debrief.trajectory.seconds[-1]), debrief.plan.duration
    if planned is None or flown >= planned - debrief.step:
        return ""
    return f"The record ends at {clock(flown)}; the exercise lasts {clock(planned)}."


def scores(debrief: DebriefData) -> Markup:
    """Return the table of the scores."""
    earned = ("nobody", "earned") if debrief.card.verdict is not None else ()
    headings = ("", "score", "value", "full at", "none at", "marks", *earned)
    headings = (*headings, "weight", "place", "formula")
    rows = (_score(debrief, i, each) for i, each in enumerate(debrief.card.scores, start=1))
    return table(headings, rows, "scores")


def _score(debrief: DebriefData, i: int, each: Scored) -> tuple[str, ...]:
    score, attained = each.rule.score, each.attained
    unit = "" if each.unit == "-" else f"\N{NO-BREAK SPACE}{each.unit}"
    value = (attained.why) if attained.value is None else number(attained.value) + unit
    marks = "not counted"
    if each.marks is not None:
        bar = Markup('{0:.0f} <i class="share"><i style="width:{0:.0f}%"></i></i>')
        marks = bar.format(each.marks)
    earned: tuple[str, ...] = ()
    if debrief.card.verdict is not None:
        part = f"{each.rule.part} " if each.earned is None else ""
        earned = (
            "-" if each.nobody is None else f"{each.nobody:.0f}",
            f"{part}{_whole(each.earned)}",
        )
    return (
        *(f"S{i}", (each.name), value, number(score.full), number(score.zero), marks),
        *earned,
        *(f"{each.rule.weight:g}", place(debrief, attained.tick), (each.formula)),
    )


def _whole(marks: float | None) -> str:
    return "" if marks is None else f"{marks:.0f}"


def casualties(debrief: DebriefData) -> Markup:
    """Return the table of the casualties and of what was done about them."""
    headings = (
        "",
        "casualty",
        "began",
        "gone",
        "first order",
        "after",
        "first deflection",
        "after",
    )
    rows = (_casualty(debrief, i, each) for i, each in enumerate(debrief.casualties, start=1))
    return table(headings, rows, "")


def _casualty(debrief: DebriefData, i: int, each: Answered) -> tuple[str, ...]:
    episode, order, moved = each.episode, each.order, each.deflection

    def after(tick: int) -> str:
        return f"{(tick - episode.begun) * debrief.step:g} s"

    return (
        *(f"C{i}", episode.kind, place(debrief, episode.begun)),
        "at the end still there" if episode.ended is None else place(debrief, episode.ended),
        (f"{order.text} ({order.who})") if order else "none",
        after(order.tick) if order else "-",
        moved.surface if moved else "none",
        after(moved.tick) if moved else "-",
    )


def marks(debrief: DebriefData) -> Markup:
    """Return the table of the marks with their remarks."""
    rows = (
        (f"M{i}", place(debrief, each.tick), (each.text), (each.who))
        for i, each in enumerate(debrief.of_kind("mark"), start=1)
    )
    return table(("", "moment", "remark", "by"), rows, "")


def hands(debrief: DebriefData) -> Markup:
    """Return the table of who gave orders."""
    rows = (
        (
            "the exercise" if each.who == SCHEDULE else (each.who),
            str(each.orders),
            str(each.refused),
        )
        for each in debrief.hands
    )
    return table(("line", "orders", "refused"), rows, "")


def log(debrief: DebriefData) -> Markup:
    """Return the table of orders and events, in the order in which they were."""
    entries = sorted(_entries(debrief), key=lambda entry: entry[0])
    rows = ((place(debrief, tick), *cells) for tick, *cells in entries[:MOST])
    more = len(entries) - MOST
    shown = table(("moment", "who", "what", "answer"), rows, "log")
    if more <= 0:
        return shown
    return shown + paragraph(f"{more} more are in the record: trainer export has all.")


def _entries(debrief: DebriefData) -> Iterator[tuple[int, str, str, str]]:
    """Yield tick, who, what and answer of orders and events."""
    for each in debrief.trajectory.orders:
        answer = (
            (each.answer)
            if each.accepted is not False
            else Markup("<strong>refused:</strong> {}").format(each.answer)
        )
        yield each.tick, (each.who), (each.text), answer
    for event in debrief.events:
        words = PLACED.sub("", event.text)
        yield event.tick, (event.who or event.kind), (words), ""


def branches(debrief: DebriefData) -> Markup:
    """Return the table of the branches."""
    rows = []
    for branch, last in debrief.branches:
        begun = "the start" if branch.parent is None else f"branch {branch.parent}"
        here = Markup(" <b>debriefed here</b>") if branch.id == debrief.branch.id else ""
        moments = place(debrief, branch.tick), place(debrief, last)
        rows.append((Markup("{}{}").format(branch.id, here), begun, *moments, (branch.why)))
    return table(("branch", "from", "at", "to", "why"), rows, "")


def ledger(debrief: DebriefData) -> Markup:
    """Return what became of the ticks, and every trouble with them."""
    ticks = debrief.ticks
    if not ticks.work or not ticks.lateness or ticks.duty_cycle is None:
        return paragraph("No tick was timed.")
    rows = [
        ("work", *(f"{value / 1e3:.1f} us" for value in ticks.work)),
        ("lateness", *(f"{value / 1e3:.1f} us" for value in ticks.lateness)),
    ]
    troubles = debrief.of_kind("trouble")
    told = (
        f"{ticks.timed} ticks of {debrief.step:g} s timed, duty cycle "
        f"{100 * ticks.duty_cycle:.3f} %; {len(troubles)} troubles called out"
    )
    listed = Markup().join(
        Markup("<li>{}: {}</li>").format(place(debrief, each.tick), each.text)
        for each in troubles[:50]
    )
    return (
        paragraph(f"{told}.")
        + table(("", "median", "99 %", "most"), rows, "")
        + (Markup("<ul>{}</ul>").format(listed) if listed else "")
    )


def run_facts(debrief: DebriefData) -> Markup:
    """Return what computed the run."""
    header, method = debrief.header, debrief.plan.method
    rows = [
        ("boat", (debrief.plan.file.name)),
        ("sea at the start", (debrief.plan.sea.name)),
        ("computed by", f"{method.equations} set, {method.rates} rates, {method.integrator}"),
        ("step", f"{method.step:g} s"),
        ("seed", str(debrief.plan.seed)),
        ("recorded", (header.get("started", "-"))),
        ("trainer", (f"{header.get('trainer', '-')}, core {header.get('core', '-')}")),
        ("record", (debrief.source.name)),
    ]
    return table(("", ""), rows, "facts")
