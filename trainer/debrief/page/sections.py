"""The tables of a debrief, as HTML.

``page`` puts them in their order, one function each. What they show was computed in ``data``; here
it is only rounded and put into words.
"""

# long: the sections of one page, a function each
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, NamedTuple

from markupsafe import Markup

from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.score_rules import RULES_FORM
from trainer.core.digest import same_core
from trainer.debrief.attainable.changes import MarkChange
from trainer.debrief.attainable.words import change_words, until_words
from trainer.debrief.marks.changes import OUTCOME_NAME, WIDTH_NAME, Change
from trainer.debrief.marks.mark_numbers import KEEPING_SHARE, WEAKEST_SHARE
from trainer.debrief.marks.scoring import RuleScore, Scorecard, Verdict
from trainer.debrief.page.charts import change_name
from trainer.debrief.page.data import CasualtyAnswer, DebriefData, deviation_of, standard_error_of
from trainer.debrief.passage.crew_work import CrewWork
from trainer.debrief.passage.episodes import ReadBack, hints_told
from trainer.debrief.passage.ships_met import Detection, look_out, meet_ships
from trainer.debrief.passage.trajectory import hole_words
from trainer.debrief.passage.watches import named
from trainer.io.lines import plain
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import CLASS_LINE, HAND_AXES
from trainer.io.recording.facts import Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.report.html import paragraph, table
from trainer.report.svg import clock
from trainer.session.past.header import ENDLESS_KEY
from trainer.session.stations.alerts import Alert, Instant

MAX_TABLE_ROWS: Final = 1000  # lines of the log, of marks, of branches
INLINE_CODE: Final = Markup("<code>{}</code>")
BY_ORDERS: Final = Markup(
    "<p>To play from a moment: {}, then the orders beside it, and <code>run</code>.</p>"
)
OLDER_RULES: Final = (
    "The rules of marking have changed since this was recorded: it is marked by today's, "
    "with the bands that its exercise had."
)
FREE_RUN_TEXT: Final = (
    "A free run has no marks: {}. Something broke by hand, or the autopilot was given what the "
    "crew was to work. To have marks, go back to before that order, or begin again."
)
NO_CHANGE: Final = "No minute cost marks that a careful crew would have kept."
JSON_HINT: Final = "trainer debrief --json has all"
JOINED_KEY_GAP_S: Final = 1.0  # [s] from one press of a key to the next
EVENT_TICK: Final = re.compile(r"tick \d+ \([\d.]+ s\): ")  # in an event that says its own tick
VALUE_DIGITS: Final = 4  # digits of a value that count
ROUNDED_DIGITS: Final = 9  # after the point, in any unit of a measure
MIN_SHOWN_DEVIATION: Final = 0.5  # [%] of a deviation
SURE_DEVIATIONS: Final = 2.8  # between two runs: docs/debrief.md, "How sure a mark is"


def format_value(value: float | None) -> str:
    """Return a value as text, '-' for none; what is left of rounding is 0."""
    return "-" if value is None else f"{round(value, ROUNDED_DIGITS) + 0.0:.{VALUE_DIGITS}g}"


def format_moment(debrief: DebriefData, tick: int | None) -> str:
    """Return a moment of the record as time and tick."""
    if tick is None:
        return "-"
    return Markup("{} <small>tick {}</small>").format(clock(tick * debrief.step), tick)


def verdict(debrief: DebriefData) -> Markup:
    """Return the result of the run: the outcome, the marks with their certainty, the crew."""
    card = debrief.final
    if debrief.familiarisation:
        return paragraph("A familiarisation run: to get to know the simulator. It has no marks.")
    if debrief.shown:
        return paragraph("Flown by the reference crew, to show the way: it counts for no mark.")
    if not card.scores:
        return paragraph("This run has no scoring rules.")
    lines = [*_outcome(debrief), *map(paragraph, _beside_marks(debrief))]
    if card.verdict is not None:
        fold = Markup("<details><summary>How the marks came about</summary>{}</details>")
        lines.append(fold.format(paragraph(explain_total(card.verdict))))
    if debrief.plan.hand:
        lines.append(paragraph(by_hand(debrief)))
    return Markup().join(lines)


def _outcome(debrief: DebriefData) -> Iterator[Markup]:
    """Yield the outcome with its reason, and the marks."""
    verdict, total = debrief.final.verdict, debrief.total
    marks = Markup("<b>{:.0f}</b> of 100 marks{}").format(total or 0.0, how_sure(debrief))
    if total is None:
        marks = Markup("no marks")
    outcome = Markup("<b>{}</b>, ").format(verdict.outcome.capitalize()) if verdict else ""
    yield Markup('<p class="total">{}{}</p>').format(outcome, marks)
    if verdict is not None and verdict.reason:
        yield paragraph(f"{verdict.reason[0].upper()}{verdict.reason[1:]}.")


def how_sure(debrief: DebriefData) -> str:
    """Return what stands behind the marks: how much they differ by chance."""
    deviations = _shown_deviations(debrief) if debrief.total is not None else {}
    return "".join(f", \N{PLUS-MINUS SIGN}{each:.0f} {cause}" for cause, each in deviations.items())


def _shown_deviations(debrief: DebriefData) -> dict[str, float]:
    """Return by what a mark differs by chance, and by how much [%], where that is worth telling."""
    known = {
        "by the sea alone": deviation_of(debrief) or 0.0,
        "from run to run, by model people": standard_error_of(debrief) or 0.0,
    }
    return {cause: each for cause, each in known.items() if each >= MIN_SHOWN_DEVIATION}


def branch_notes(debrief: DebriefData) -> Iterator[str]:
    """Yield which branch this is, where there are several."""
    here, latest = debrief.branch.id, debrief.branches[-1][0].id
    words = f"trainer debrief {plain(debrief.source.name)} --branch"
    if here != latest:
        yield f"This is branch {here} of {latest}; {words} {latest} shows what was flown last."
    elif latest > 1:
        yield f"This is branch {latest} of {latest}; {words} N shows an earlier one."


def _how_flown(debrief: DebriefData) -> Iterator[str]:
    """Yield what helped the crew: aids, hints, another try; and which branch it is."""
    yield from branch_notes(debrief)
    if debrief.aids:
        yield f"Flown with {' and '.join(debrief.aids)}."
    for hint in hints_told(debrief.trajectory):
        yield f"At {clock(hint.tick * debrief.step)}: {hint.answer}."
    if debrief.practice:
        yield f"Practice: this run was wound back ({debrief.practice})."


def _beside_marks(debrief: DebriefData) -> Iterator[str]:
    """Yield the notes about the marks, a sentence or two each."""
    card = debrief.final
    if not is_of_today(debrief):
        yield OLDER_RULES
    yield from _how_flown(debrief)
    if (verdict := card.verdict) is not None and verdict.cap is not None:
        why = "the exercise was lost" if verdict.outcome is Outcome.LOST else "a limit was broken"
        yield f"At most {verdict.cap:.0f} marks: {why}."
    if debrief.changed is not None:
        yield f"Changed by the instructor; before: {describe_card(debrief.card)}."
    if debrief.width != "qualified":
        yield f"Judged at {debrief.width} width: bands half as wide again."
    counted = sum(each.marks is not None for each in card.scores)
    if counted < len(card.scores):
        yield f"{counted} of {len(card.scores)} rules count."
    if deviations := _shown_deviations(debrief).values():
        yield f"Two runs differ for sure only beyond {SURE_DEVIATIONS * max(deviations):.0f} marks."
    flown, planned = float(debrief.trajectory.seconds[-1]), debrief.plan.duration
    if planned is not None and flown < planned - debrief.step:
        yield f"The record ends at {clock(flown)}; the exercise lasts {clock(planned)}."


def by_hand(debrief: DebriefData) -> str:
    """Return in words which axes the crew worked, and which were automatic."""
    plan = debrief.plan
    automatic = [axis for axis in HAND_AXES if axis not in plan.hand]
    sentence = f"By hand: {', '.join(plan.hand)}; automatic: {', '.join(automatic) or 'nothing'}"
    if plan.allowed:
        sentence += f"; allowed: {', '.join(plan.allowed)}"
    return f"{sentence}."


def describe_card(card: Scorecard) -> str:
    """Return the outcome and the marks of a card, in words."""
    marks = "no marks" if card.total is None else f"{card.total:.0f} of 100 marks"
    return marks if card.verdict is None else f"{card.verdict.outcome}, {marks}"


def is_of_today(debrief: DebriefData) -> bool:
    """Return whether it was recorded under today's rules of marking, or has no marks."""
    return not debrief.card.scores or debrief.header.get("rules") == RULES_FORM


def explain_total(verdict: Verdict) -> str:
    """Return in words how the total came about, by the formula of ``judgement``."""
    words = (
        f"Tasks {verdict.tasks:.0f}, beyond what a boat with nobody aboard gets; "
        f"keeping {verdict.keeping:.0f}"
    )
    if verdict.void:
        return f"{words}. The boat turned over: the marks are void."
    if verdict.free:
        return f"{words}. A free run has no marks."
    words += (
        f"; total = tasks \N{MULTIPLICATION SIGN} ({1.0 - KEEPING_SHARE:g} + "
        f"{KEEPING_SHARE:g} keeping / 100)"
    )
    if verdict.weakest < 1.0:
        words += (
            f" \N{MULTIPLICATION SIGN} ({1.0 - WEAKEST_SHARE:g} + {WEAKEST_SHARE:g} "
            f"\N{MULTIPLICATION SIGN} {verdict.weakest:.2f}), "
            "by how far the weakest task was carried out"
        )
    if verdict.hint_marks:
        words += f", less {verdict.hint_marks:g} for hints"
    return f"{words}."


class PlayOn(NamedTuple):
    """How one flies on from a moment of a page."""

    offer: Callable[[Sequence[str]], Markup]  # by the orders that lead to the moment
    below: Callable[[DebriefData], Markup]  # said once, below all moments


def _link_on(orders: Sequence[str]) -> Markup:
    """Return the link that has the boat in the page fly on (js/tab/link)."""
    link = Markup('<a href="#fly" data-orders="{}">Play from here</a>')
    return link.format("; ".join((*orders, "run")))


def _orders_on(orders: Sequence[str]) -> Markup:
    """Return the orders by which a session flies on."""
    return Markup("Play from here: {}").format(Markup(", ").join(map(INLINE_CODE.format, orders)))


def _session_on(debrief: DebriefData) -> Markup:
    """Return how the session is begun in which those orders are given."""
    return BY_ORDERS.format(INLINE_CODE.format(f"trainer resume {plain(debrief.source.name)}"))


PLAY_BY_LINK: Final = PlayOn(_link_on, lambda _: Markup())
PLAY_BY_ORDERS: Final = PlayOn(_orders_on, _session_on)  # of a page without the boat


def minutes(debrief: DebriefData, play: PlayOn) -> Markup:
    """Return what each minute cost: each change of the attainable marks, with its cause."""
    comparison = debrief.compared
    if comparison is None:
        return paragraph("This exercise has no reference crew to compare with.")
    curve = comparison.curve
    if curve is None:
        return paragraph(f"There is no curve: {comparison.no_curve}.")
    head = Markup("<p><b>{}</b></p>").format(until_words(curve, debrief.step))
    if not curve.changes:
        return head + paragraph(NO_CHANGE)
    items = (
        _change_item(debrief, play, change_name(i), each) for i, each in enumerate(curve.changes)
    )
    return head + Markup("<ul>{}</ul>").format(Markup().join(items)) + play.below(debrief)


def _change_item(debrief: DebriefData, play: PlayOn, name: str, change: MarkChange) -> Markup:
    """Return one change of the curve, the way to its moment, and how to fly on from there."""
    last = int(debrief.trajectory.ticks[-1])
    item = Markup('<li>{} <a href="#{}-attainable">Go there</a>')
    item = item.format(change_words(change, debrief.step), name)
    if change.told_at < last:
        back = f"backtrack {(last - change.told_at) * debrief.step:g} s"
        item += Markup(" · ") + play.offer((f"branch {debrief.branch.id}", back))
    return item + Markup("</li>")


def cost(debrief: DebriefData) -> Markup:
    """Return the dearest causes, and the marks of the reference crew."""
    if (judged := debrief.final.verdict) and judged.free:
        return paragraph(FREE_RUN_TEXT.format(judged.reason))
    items = Markup().join(Markup("<li>{}</li>").format(each.told) for each in debrief.costs)
    lines = [Markup("<ol>{}</ol>").format(items) if items else paragraph("Nothing.")]
    if (comparison := debrief.compared) is not None:
        sentence = f"The reference crew at this seed: {describe_card(comparison.reference.card)}."
        if comparison.from_here is not None:
            since = clock(comparison.from_here.since or 0.0)
            sentence += f" Taking over at {since}: {describe_card(comparison.from_here.card)}."
        lines.append(paragraph(sentence))
    return Markup().join(lines)


def changes(debrief: DebriefData) -> Markup:
    """Return the table of the instructor's changes, old and new beside each other."""
    rows = [
        (change.name, _before(debrief, change), change.what, change.reason, change.at)
        for change in debrief.changes
    ]
    summary = paragraph(
        f"Before: {describe_card(debrief.card)}. Now: {describe_card(debrief.final)}."
    )
    return summary + table(("", "was", "is", "why", "when"), rows, "")


def _before(debrief: DebriefData, change: Change) -> str:
    """Return the value that a change replaced."""
    card = debrief.card
    if change.name == OUTCOME_NAME:
        return card.verdict.outcome if card.verdict else "-"
    if change.name == WIDTH_NAME:
        return debrief.width
    weights = [each.rule.weight for each in card.scores if each.name == change.name]
    return f"weight {weights[0]:g}" if weights else "-"


def legend(debrief: DebriefData) -> Markup:
    """Return the legend of the charts' lines and shades."""
    words = "Shaded: a casualty. Dotted upright: a mark. Time from the start, minutes and seconds."
    if comparison := debrief.compared:
        words += " Grey dashes: the reference crew at the same seed."
        changed = comparison.curve and comparison.curve.changes
        words += " Thick upright: where marks began to be lost or won." if changed else ""
        words += (
            " Green upright: where the reference crew took over." if comparison.from_here else ""
        )
    if holes := debrief.trajectory.holes:
        words += f" {hole_words(holes).capitalize()}."
    if debrief.compared and not same_core(debrief.header.get("core")):
        words += " The reference crew is flown by another core than the recording was."
    return Markup('<p class="legend"><small>{}</small></p>').format(words)


def read_backs(debrief: DebriefData) -> Markup:
    """Return the table of the orders to the crew: repeated, and carried out."""
    headings = ("", "ordered", "at", "by", "repeated by", "after", "repeated wrong", "kept from")
    rows = (_read_back(debrief, i, each) for i, each in enumerate(debrief.read_backs, start=1))
    return table(headings, rows, "")


def _read_back(debrief: DebriefData, i: int, each: ReadBack) -> tuple[str, ...]:
    order, said = each.order, each.repeated
    after = "-" if said is None else f"{(said.tick - order.tick) * debrief.step:g} s"
    by = by_whom(order.giver)
    return (
        f"O{i}",
        each.told,
        format_moment(debrief, order.tick),
        by,
        "not repeated" if said is None else said.who,
        after,
        ", ".join(each.wrong) or "-",
        format_moment(debrief, each.carried_out),
    )


def scores(debrief: DebriefData) -> Markup:
    """Return the table of the scores."""
    cards = [debrief.compared.reference.card] if debrief.compared else []
    best = {each.name: each for card in cards for each in card.scores}
    judged = debrief.card.verdict is not None
    headings = [
        "",
        "measure",
        "value",
        *(("reference",) if best else ()),
        "full at",
        "none at",
        "marks",
        *(("nobody", "earned") if judged else ()),
        "weight",
        "place",
        "formula",
    ]
    rows = (_score(debrief, i, each, best) for i, each in enumerate(debrief.card.scores, start=1))
    return table(headings, rows, "scores")


def _score(
    debrief: DebriefData, i: int, each: RuleScore, best: dict[str, RuleScore]
) -> tuple[str, ...]:
    score, attained = each.rule.score, each.attained
    value = attained.why if attained.value is None else value_of(each)
    marks = "not counted"
    if each.marks is not None:
        bar = Markup('{0:.0f} <i class="share"><i style="width:{0:.0f}%"></i></i>')
        marks = bar.format(each.marks)
    earned: tuple[str, ...] = ()
    if debrief.card.verdict is not None:
        nobody = "-" if each.nobody is None else f"{each.nobody:.0f}"
        part = "not counted" if each.idle else f"{each.rule.part} "
        earned = (nobody, part if each.earned is None else f"{each.earned:.0f}")
    beside = (value_of(best[each.name]) if each.name in best else "-",) if best else ()
    return (
        f"S{i}",
        each.name,
        value,
        *beside,
        format_value(score.full),
        format_value(score.zero),
        marks,
        *earned,
        f"{each.rule.weight:g}",
        format_moment(debrief, attained.tick),
        each.formula,
    )


def task_marks(debrief: DebriefData) -> Markup:
    """Return the table of whose the marks of each task are."""
    rows = (
        (each.name, f"{each.marks:.0f}", ", ".join(each.able) or "-", each.whose)
        for each in debrief.task_marks
    )
    return table(("task", "marks", "stations that move it", "whose"), rows, "")


def value_of(each: RuleScore) -> str:
    """Return the value of a score with its unit."""
    unit = "" if each.unit == "-" else f"\N{NO-BREAK SPACE}{each.unit}"
    value = each.attained.value
    return "-" if value is None else format_value(value) + unit


def casualties(debrief: DebriefData) -> Markup:
    """Return the table of the casualties and of the crew's answers."""
    first = ("first order", "after", "first deflection", "after")
    headings = ("", "casualty", "began", "gone", *first)
    rows = (_casualty(debrief, i, each) for i, each in enumerate(debrief.casualties, start=1))
    return table(headings, rows, "")


def _casualty(debrief: DebriefData, i: int, each: CasualtyAnswer) -> tuple[str, ...]:
    episode, order, moved = each.episode, each.order, each.deflection

    def after(tick: int) -> str:
        return f"{(tick - episode.begun) * debrief.step:g} s"

    return (
        f"C{i}",
        episode.kind,
        format_moment(debrief, episode.begun),
        "at the end still there"
        if episode.ended is None
        else format_moment(debrief, episode.ended),
        (f"{order.text} ({order.who})") if order else "none",
        after(order.tick) if order else "-",
        moved.surface if moved else "none",
        after(moved.tick) if moved else "-",
    )


def alerts(debrief: DebriefData) -> Markup:
    """Return the table of the alerts, and of who silenced and acknowledged them."""
    every = debrief.trajectory.alerts
    rows = (_alert(debrief, each) for each in every[:MAX_TABLE_ROWS])
    headings = ("rank", "alert", "came", "silenced", "acknowledged", "over")
    return table(headings, rows, "") + _more(len(every), JSON_HINT)


def _alert(debrief: DebriefData, each: Alert) -> tuple[str, ...]:
    def after(role: str, when: Instant) -> str:
        by = named(debrief.watches, role, when.tick)
        return f"{by} after {when.seconds - each.raised.seconds:g} s"

    seen = after(each.seen_by, each.seen) if each.seen and each.seen_by else "-"
    return (
        each.rank.value,
        each.words,
        format_moment(debrief, each.raised.tick),
        ", ".join(after(role, when) for role, when in each.silenced) or "-",
        "no" if each.owed else seen,
        format_moment(debrief, each.over.tick) if each.over else "at the end still there",
    )


def ships(debrief: DebriefData) -> Markup:
    """Return the table of the ships that were met, the nearest first; empty without any."""
    met, looked = meet_ships(debrief.trajectory), look_out(debrief.trajectory)
    if not met.closest:
        return Markup()
    detections = {each.name: each for each in looked.ships}
    rows = [
        (
            name,
            f"{apart:.0f} m",
            format_moment(debrief, tick),
            *_detected(debrief, detections.get(name)),
        )
        for name, (apart, tick) in sorted(met.closest.items(), key=lambda each: each[1])
    ]
    remarks = [
        f"Collision with {name} at {clock(tick * debrief.step)}." for tick, name in met.collisions
    ]
    if looked.false:
        when = ", ".join(clock(tick * debrief.step) for tick in looked.false)
        remarks.append(f"Marked where no ship was seen: {when}.")
    headings = ("ship", "closest approach", "when", "in sight from", "marked", "after")
    return Markup().join(map(paragraph, remarks)) + table(headings, rows, "")


def _detected(debrief: DebriefData, found: Detection | None) -> tuple[str, str, str]:
    """Return when a ship came in sight, when it was marked, and how long after."""
    if found is None:
        return "-", "-", "-"
    if found.seen is None:
        return "nobody looked", "-", "-"
    if found.marked is None:
        return format_moment(debrief, found.seen), "no", "-"
    after = f"{(found.marked - found.seen) * debrief.step:g} s"
    return format_moment(debrief, found.seen), format_moment(debrief, found.marked), after


def marks(debrief: DebriefData) -> Markup:
    """Return the table of the marks with their remarks."""
    every = debrief.of_kind("mark")
    rows = (
        (f"M{i}", format_moment(debrief, mark.tick), (mark.text), (mark.who))
        for i, mark in enumerate(every[:MAX_TABLE_ROWS], start=1)
    )
    return table(("", "moment", "remark", "by"), rows, "") + _more(len(every), JSON_HINT)


def by_whom(giver: Giver) -> str:
    """Return the giver of an order in the words of the page."""
    return "the exercise" if giver.kind is GiverKind.SCHEDULE else giver.words


def hands(debrief: DebriefData) -> Markup:
    """Return the table of who gave orders, and that of who had the watch."""
    rows = ((by_whom(each.giver), str(each.orders), str(each.refused)) for each in debrief.hands)
    return table(("line", "orders", "refused"), rows, "") + _watches(debrief)


def _watches(debrief: DebriefData) -> Markup:
    """Return the table of the persons at the stations, nothing where none was named."""
    rows = (
        (
            *(each.role, each.person, format_moment(debrief, each.begun)),
            format_moment(debrief, each.ended) if each.ended is not None else "the end",
            str(each.orders),
        )
        for each in debrief.watches
    )
    heads = ("station", "has the watch", "from", "to", "orders")
    return table(heads, rows, "") if debrief.watches else Markup()


def crew_work(debrief: DebriefData, work: CrewWork) -> Markup:
    """Return how the crew worked: loops, who informed whom, faults, load by station."""
    wait = "" if work.latency_s is None else f", half of them within {work.latency_s:.3g} s"
    words = f"Of {work.orders} orders to the crew {work.repeated} were repeated{wait}. "
    words += f"Loops closed (ordered, repeated, reported): {work.closed}."
    informed = ", ".join(f"{who} to {whom} {count}" for who, whom, count in work.informed)
    load = ((s.role, *map(str, (s.worked, s.busiest, s.repeats, s.reports))) for s in work.load)
    faults = [
        (format_moment(debrief, f.tick), named(debrief.watches, f.role, f.tick), f.kind, f.what)
        for f in work.faults
    ]
    heads = ("station", "orders worked", "most in a minute", "repeats", "reports")
    shown = faults[:MAX_TABLE_ROWS]
    return Markup().join(
        [
            paragraph(words),
            paragraph(f"Informed: {informed or 'nobody'}."),
            table(heads, load, ""),
            table(("moment", "station", "fault", "what"), shown, "") if shown else Markup(),
            _more(len(faults), JSON_HINT),
        ]
    )


def log(debrief: DebriefData) -> Markup:
    """Return the table of orders and events by time."""
    entries = sorted(_entries(debrief), key=lambda entry: entry[0])
    rows = ((format_moment(debrief, tick), *cells) for tick, *cells in entries[:MAX_TABLE_ROWS])
    shown = table(("moment", "who", "what", "answer"), rows, "log")
    left_out = Markup().join(paragraph(f"{each}.".capitalize()) for each in debrief.excess)
    return shown + _more(len(entries), "trainer export has all") + left_out


def _entries(debrief: DebriefData) -> Iterator[tuple[int, str, str, str]]:
    """Yield tick, who, what and answer of orders and events."""
    given = (each for each in debrief.trajectory.orders if each.giver.role != CLASS_LINE)
    for presses in pressed_together(given, debrief.step):  # the class tells of boats all the time
        first, last = presses[0], presses[-1]
        answer: str = last.answer
        if last.accepted is False:
            answer = Markup("<strong>refused:</strong> {}").format(last.answer)
        words = last.text
        if len(presses) > 1:
            more = Markup("{} <small>after {} more</small>")
            words = more.format(last.text, len(presses) - 1)
        yield first.tick, first.who, words, answer
    for event in debrief.events:
        yield event.tick, event.who or event.kind, EVENT_TICK.sub("", event.text), ""


def pressed_together(orders: Iterable[RecordedOrder], step: float) -> list[list[RecordedOrder]]:
    """Return orders in groups of one kind and giver, a second apart at most.

    A key that is held, or pressed again and again, gives many orders, and the page has room for one
    line. ``step`` [s] is that of the run. A refused order stands alone.
    """
    groups: list[list[RecordedOrder]] = []
    last_of: dict[tuple[str, str], list[RecordedOrder]] = {}  # the group that a key's next may join
    for order in orders:
        known = parse(order.text)
        key = order.who, known.name if isinstance(known, Order) else order.text
        group = last_of.get(key)
        near = group and (order.tick - group[-1].tick) * step <= JOINED_KEY_GAP_S
        if group and near and order.accepted and group[-1].accepted:
            group.append(order)
        else:
            last_of[key] = [order]
            groups.append(last_of[key])
    return groups


def branches(debrief: DebriefData) -> Markup:
    """Return the table of the branches."""
    rows = []
    for branch, last in debrief.branches[:MAX_TABLE_ROWS]:
        begun = "the start" if branch.parent is None else f"branch {branch.parent}"
        here = Markup(" <b>debriefed here</b>") if branch.id == debrief.branch.id else ""
        moments = format_moment(debrief, branch.tick), format_moment(debrief, last)
        rows.append((Markup("{}{}").format(branch.id, here), begun, *moments, (branch.why)))
    shown = table(("branch", "from", "at", "to", "why"), rows, "")
    return shown + _more(len(debrief.branches), JSON_HINT)


def _more(count: int, elsewhere: str) -> Markup:
    """Return how many of so many are not shown, and what has them; nothing if all are."""
    if count <= MAX_TABLE_ROWS:
        return Markup()
    return paragraph(f"{count - MAX_TABLE_ROWS} more are in the record: {elsewhere}.")


def tick_ledger(debrief: DebriefData) -> Markup:
    """Return the section on ticks: how late, how many missed, and each trouble."""
    ticks = debrief.ticks
    if not ticks.work or not ticks.lateness or ticks.duty_cycle is None:
        return paragraph("No tick was timed.")
    rows = [
        ("work", *(f"{value / 1e3:.1f} us" for value in ticks.work)),
        ("lateness", *(f"{value / 1e3:.1f} us" for value in ticks.lateness)),
    ]
    troubles = debrief.of_kind("trouble")
    counts = (
        f"{ticks.timed} ticks of {debrief.step:g} s timed, duty cycle "
        f"{100 * ticks.duty_cycle:.3f} %; {len(troubles)} troubles called out"
    )
    listed = Markup().join(
        Markup("<li>{}: {}</li>").format(format_moment(debrief, event.tick), event.text)
        for event in troubles[:50]
    )
    return (
        paragraph(f"{counts}.")
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
        *([("battery", "endless: not drained")] if ENDLESS_KEY in header else []),
        ("trainees", ", ".join(debrief.trainees) or "-"),
        ("recorded", (header.get("started", "-"))),
        ("trainer", (f"{header.get('trainer', '-')}, core {header.get('core', '-')}")),
        ("record", plain(debrief.source.name)),
    ]
    return table(("", ""), rows, "facts")
