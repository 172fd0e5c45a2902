"""The account of a run that is over."""

import math

import click

from trainer import compilation
from trainer.boat import Boat
from trainer.io.no_recording import NoRecording
from trainer.io.recording import Recording
from trainer.io.teletype import course
from trainer.ledger import Summary
from trainer.session import Session
from trainer.units import KNOT

SEE_IT = "trainer debrief FILE shows how it went, trainer replay FILE flies it again"
SECONDS_1969 = "1969: 38 % at 0.5 s, 19 % at 1 s"


def account(session: Session, wall: float, kept: str, *, aside: bool) -> int:
    """Print the summary of a run of ``wall`` [s] and what went wrong; return the exit code.

    ``kept`` is the path of its recording, "" if it has none; ``aside`` prints on stderr, where a
    console has stdout.
    """
    summary = summary_text(session.boat, session.time.ledger.summary(), wall)
    if granted := session.time.punctuality.granted:
        summary += f"\nthe clock   {granted.line()}"
    if session.watch.times:
        summary += f"\nevents      {session.watch.account()}"
    if kept:
        absences = session.history.recording.absences
        whole = absences and not session.history.recording.missing
        again = f"; it was out of reach {absences} times, and is whole" if whole else ""
        summary += f"\nrecorded    {kept}{again}\n            {SEE_IT}"
    click.echo(summary, err=aside)
    failure = session.desk.failure and f"frozen: {session.desk.failure}"
    recording = unrecorded(session.history.recording) if kept else ""
    troubles = [failure, session.deserted, session.recorder.trouble, recording]
    for station in session.board.stations:
        if station.line.dropped:
            name = station.line.name
            click.echo(f"trainer: {name}: {station.line.dropped} lines dropped", err=True)
    for trouble in filter(None, troubles):
        click.echo(f"trainer: {trouble}", err=True)
    return 1 if any(troubles) else 0


def unrecorded(recording: Recording | NoRecording) -> str:
    """Return what a recording that has been closed lacks and why, "" if it is whole."""
    if not (recording.missing or recording.trouble):
        return ""
    why = f"; {recording.trouble}" if recording.trouble else ""
    return f"NOT RECORDED: {recording.missing or 'nothing more'}{why}"


def summary_text(boat: Boat, ledger: Summary, wall: float) -> str:
    """Return the one-screen account of a run that took ``wall`` [s]."""
    s = boat.state
    step = boat.method.step
    how = ", interpreted" if compilation.done_without() else ""
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
