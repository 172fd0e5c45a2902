"""The summary of a run: the trainee, the timer, and what went wrong."""

import math

import click

from trainer.boat import compilation
from trainer.boat.boat import Boat
from trainer.boat.limits import account_of
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.status_line import course
from trainer.session.session import Session
from trainer.session.time.ledger import Summary
from trainer.units import KNOT

SEE_IT = "trainer debrief FILE shows how it went, trainer replay FILE flies it again"
SECONDS_1969 = "1969: 38 % at 0.5 s, 19 % at 1 s"


def account(session: Session, wall: float, kept: str, *, aside: bool) -> int:
    """Print the summary of a run of ``wall`` [s] and what went wrong. Return the exit code.

    ``kept`` is the path of its recording, "" if it has none; ``aside`` prints on stderr, where a
    console has stdout.
    """
    summary = "\n".join(
        (
            *outcome_lines(session),
            summary_text(
                session.boat, session.time.ledger.summary(), wall, session.conduct.compiled_from
            ),
        )
    )
    if granted := session.time.punctuality.granted:
        summary += f"\nthe clock   {granted.line()}"
    if times := session.monitor.times | session.depths.times | session.pilot.times:
        summary += f"\nevents      {account_of(times)}"
    if kept:
        absences = session.history.recording.absences
        whole = absences and not session.history.recording.missing
        again = f"; it was out of reach {absences} times, and is whole" if whole else ""
        summary += f"\nrecorded    {kept}{again}\n            {SEE_IT}"
    click.echo(summary, err=aside)
    failure = session.control.failure and f"frozen: {session.control.failure}"
    recording = describe_missing(session.history.recording) if kept else ""
    troubles = [failure, session.deserted, session.recorder.trouble, recording]
    safe = "; the recording has all that happened" if kept and not recording else ""
    for station in session.event_log.stations:
        if station.line.dropped:
            unread = f"{station.line.dropped} lines were not read there{safe}"
            click.echo(f"trainer: {station.who}: {unread}", err=True)
    if not aside:  # nobody was there to hear it
        troubles += session.refused
    for trouble in filter(None, troubles):
        click.echo(f"trainer: {trouble}", err=True)
    return 1 if any(troubles) else 0


def outcome_lines(session: Session) -> list[str]:
    """Return the trainee's result: the end of the exercise, the marks and their reasons."""
    conduct = session.conduct
    marks = conduct.final_marks()
    if not (conduct.ending.over or marks):
        return []
    lost = f": {conduct.ending.why}" if conduct.ending.why else ""
    ended = (
        f"{conduct.ending.over}{lost}"
        if conduct.ending.over
        else f"left at {session.boat.time:g} s"
    )
    told = f"outcome     {ended}; {marks}" if marks else f"outcome     {ended}"
    return [told, *(f"            {each}" for each in (marks.reasons if marks else ()))]


def describe_missing(recording: Recording | NoRecording) -> str:
    """Return what a closed recording lacks and why, "" if it is whole."""
    if not (recording.missing or recording.trouble):
        return ""
    why = f"; {recording.trouble}" if recording.trouble else ""
    return f"NOT RECORDED: {recording.missing or 'nothing more'}{why}"


def summary_text(boat: Boat, ledger: Summary, wall: float, compiled_from: int = 0) -> str:
    """Return the one-screen account of a run that took ``wall`` [s].

    ``compiled_from`` is the tick from which machine code computed it, 0 where all was one.
    """
    s = boat.state
    step = boat.method.step
    until = f" before tick {compiled_from}" if compiled_from else ""
    how = f", interpreted{until}" if compilation.is_interpreted() else ""
    return "\n".join(
        (
            boat.file.name,
            f"computed    {boat.method.equations} set, {boat.method.integrator} at {step:g} s{how}",
            f"simulated   {boat.time:.1f} s in {ledger.ticks} ticks; {wall:.2f} s on the clock",
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
