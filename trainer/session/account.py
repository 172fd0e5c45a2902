"""The summary at a run's end: its result, how punctual it was, what went wrong.

``run`` calls ``account`` when a session has ended, and ends the program with the exit code that it
returns. A run without any trouble gets one line; ``--verbose`` adds the load and lateness.
"""

import math
import shlex
import textwrap
from dataclasses import dataclass

import click

from trainer.boat.boat import Boat
from trainer.boat.limits import account_of
from trainer.config.exercise.outcome import Outcome
from trainer.core.kernel import INTERPRETED
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.status_line import course
from trainer.session.session import Session
from trainer.session.time.ledger import Summary
from trainer.units import KNOT

RESULT_WIDTH = 80  # [columns] of the reasons of a result
# duty cycle of the report's program on its own machine, by step
SECONDS_1969 = "1969: 38 % at 0.5 s, 19 % at 1 s"


@dataclass(frozen=True)
class SummaryOptions:
    """The parts of a run's summary, and where it is printed."""

    kept: str = ""  # path of the recording, "" without one
    verbose: bool = False  # with duty cycle, lateness and what the clock was granted
    aside: bool = False  # on stderr, where a console has stdout


def account(session: Session, wall: float, options: SummaryOptions) -> int:
    """Print the summary of a run of ``wall`` [s] and what went wrong. Return the exit code."""
    path = options.kept
    lines = outcome_lines(session)
    if times := session.monitors.times:
        lines.append(f"events      {account_of(times)}")
    recording = describe_missing(session.history.recording) if path else ""
    lines.append(one_line(session, "" if recording else path))
    lines += details(session, wall, path) if options.verbose else []
    click.echo("\n".join(lines), err=options.aside)
    failure = session.control.failure and f"frozen: {session.control.failure}"
    ending = session.conduct.ending
    failure = failure or (f"{ending.over}: {ending.why}" if ending.outcome is Outcome.LOST else "")
    troubles = [failure, session.control.deserted, session.rows.recorder.trouble, recording]
    safe = "; the recording has all that happened" if path and not recording else ""
    for station in session.event_log.stations:
        if station.line.dropped:
            why = f": {station.line.trouble}" if station.line.trouble else ""
            unread = f"{station.line.dropped} lines were not read there{why}{safe}"
            click.echo(f"trainer: {station.who}: {unread}", err=True)
    if not options.aside:  # nobody was there to hear it
        troubles += session.dispatch.refused
    for trouble in filter(None, troubles):
        click.echo(f"trainer: {trouble}", err=True)
    return 1 if any(troubles) else 0


def one_line(session: Session, kept: str) -> str:
    """Return how long the boat flew, whether on time, and how to see the recording."""
    ledger = session.time.ledger.summary()
    late = ledger.overruns + ledger.caught_up + ledger.skipped
    troubles = [f"{late} late"] if late else []
    troubles += [f"not running for {ledger.gap_ns / 1e9:.1f} s"] if ledger.gaps else []
    timing = ", ".join(troubles) or "all on time"
    ticks = "tick" if ledger.ticks == 1 else "ticks"
    flown = f"simulated   {session.boat.time:.1f} s in {ledger.ticks} {ticks}, {timing}"
    return f"{flown}; trainer debrief {shlex.quote(kept)} shows how it went" if kept else flown


def details(session: Session, wall: float, kept: str) -> list[str]:
    """Return the lines for an engineer about a run of ``wall`` [s]: load, lateness, recording."""
    summary = session.time.ledger.summary()
    lines = [summary_text(session.boat, summary, wall)]
    if granted := session.time.punctuality.granted:
        lines.append(f"the clock   {granted.line()}")
    if kept:
        absences = session.history.recording.absences
        whole = absences and not session.history.recording.missing
        again = f"; it was out of reach {absences} times, and is whole" if whole else ""
        lines.append(f"recorded    {kept}{again}")
    return lines


def outcome_lines(session: Session) -> list[str]:
    """Return the trainee's result: the end of the exercise, the marks and their reasons."""
    ending, marks = session.conduct.ending, session.conduct.marks.final()
    if not (ending.over or marks):
        return []
    lost = f": {ending.why}" if ending.why else ""
    ended = f"{ending.over}{lost}" if ending.over else f"left at {session.boat.time:g} s"
    outcome = f"outcome     {ended}; {marks}" if marks else f"outcome     {ended}"
    shape = textwrap.TextWrapper(RESULT_WIDTH, " " * 12, " " * 14, break_on_hyphens=False)
    reasons = marks.reasons if marks else ()
    return [outcome, *(line for each in reasons for line in shape.wrap(each))]


def describe_missing(recording: Recording | NoRecording) -> str:
    """Return what a closed recording lacks and why, "" if it is whole."""
    if not (recording.missing or recording.trouble):
        return ""
    why = f"; {recording.trouble}" if recording.trouble else ""
    return f"NOT RECORDED: {recording.missing or 'nothing more'}{why}"


def summary_text(boat: Boat, ledger: Summary, wall: float) -> str:
    """Return the one-screen account of a run that took ``wall`` [s]."""
    s = boat.state
    step = boat.method.step
    how = ", interpreted" if INTERPRETED else ""
    return "\n".join(
        (
            boat.file.name,
            f"computed    {boat.method.equations} set, {boat.method.integrator} at {step:g} s{how}",
            f"took        {wall:.2f} s on the clock",
            f"duty cycle  {100 * ledger.duty_cycle:.4f} %   ({SECONDS_1969})",
            (
                f"work a tick median {ledger.work.p50_ns / 1e3:.1f} us, "
                f"99 % {ledger.work.p99_ns / 1e3:.1f} us, most {ledger.work.max_ns / 1e3:.1f} us"
            ),
            (
                f"on time     overruns {ledger.overruns}, caught up {ledger.caught_up}, "
                f"slipped {ledger.skipped}, gaps {ledger.gaps} ({ledger.gap_ns / 1e9:.1f} s)"
            ),
            (
                f"the boat    {s.z:.5g} m, course {course(math.degrees(s.psi), 1)}, "
                f"{s.u / KNOT:.4g} kn, pitch {math.degrees(s.theta):+.2f}, "
                f"heel {math.degrees(s.phi):+.2f} degrees"
            ),
        )
    )
