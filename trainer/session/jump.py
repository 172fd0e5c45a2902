"""The road of a jump in time: how a session becomes what it was then.

1. **Asked.** An order about the past (``control``), a call of the Python face, a lesson whose step
   begins again, or the end of what the reference crew has shown names a moment.
2. **Found** (``history``). A moment is the whole state, the last order that it includes, and the
   next entry of the schedule. It comes from the recording, or from memory without one.
3. **Gone to** (``history``). The state is restored, and the world obeys its orders anew. Then a
   new branch begins in the recording, or a replay of the old one. If that cannot be read or
   written, all is as before: nothing is flown twice on one branch. No numbers are lost any more,
   and no single steps are left (``control``).
4. **Followed.** Whatever the session remembers beside the state is later than this moment. So each
   object with a memory follows, in the order of ``followers``: first what is computed from the
   boat alone, then the words and plans, then the lesson, whose step gives orders that these words
   and plans must not undo. The news comes after them, because it tells programs the branches before
   they hear of the jump. Last comes what a branch has to have in its journal for its marks.
5. **Judged** (``conduct``). The moment may be the end of an exercise, or the boat lost there.
   Then stations are told all alerts that hold there.
6. **Shown, and told** by who asked. News has a fact ``back``, by which programs forget as well.

``Follower.follow`` alone takes an object back, and it is always told the moment gone to. It does
not announce anything of its own past, because nothing has happened there twice.

The end of a replay is no jump: the boat has flown to that moment, and all have gone with it. Only
the plans are put back, because a replay also notes plans that were refused, and the alerts, which
somebody may have acknowledged in it (``end_replay``).

A jump leaves alone what is of no moment: the recording, who is attached, who commands, the work of
the machine. Whoever adds an object that remembers anything else gives it ``follow`` and a line in
``followers``: ``tests/session/test_jump`` finds each object with a memory that has neither that nor
a reason.
"""

from collections.abc import Sequence
from typing import Protocol

from trainer.io.recording.recording import Moment
from trainer.session.parts import Parts
from trainer.session.stations.station import Fact


class Follower(Protocol):
    """An object that remembers something, and goes along when time jumps."""

    def follow(self, moment: Moment) -> None:
        """Be as it was at a moment, which is the present one again."""


def followers(session: Parts) -> Sequence[Follower]:
    """Return all objects that remember something, in the order in which they follow."""
    conduct = session.conduct
    return (
        session.monitors,
        conduct.ending,
        conduct.marks,
        conduct.damage_watch,
        conduct.muster,
        session.in_force,
        conduct.guide,
        session.event_log,
        session.evaluation,
        conduct.aids,
        conduct.chair,
        conduct.hints,
    )


def follow_jump(session: Parts) -> None:
    """Have all followers go to the moment to which time has jumped, and judge it."""
    moment = session.history.now()
    for follower in followers(session):
        follower.follow(moment)
    session.conduct.judge_moment()
    session.event_log.take_up(session.holding())


def jump_to(session: Parts, moment: Moment, why: str) -> None:
    """Jump to a moment of this run: a new branch begins there, frozen."""
    session.control.begin_branch(moment, why)
    follow_jump(session)
    session.shown.show()


def repeat_step(session: Parts, moment: Moment, why: str) -> None:
    """Jump to the beginning of a step of a lesson, and let time run."""
    jump_to(session, moment, why)
    session.event_log.tell("moment", f"back: {why}", fact=Fact("back", why))
    session.event_log.recall(session.crew.unrepeated)
    session.time.pacer.run()
    session.shown.show()


def end_replay(session: Parts) -> None:
    """Freeze time where a replay has come to its end. The run can go on from there."""
    session.event_log.tell("moment", session.history.end_replay())
    session.in_force.put_back_plans()
    session.event_log.put_back_alerts()
    session.conduct.judge_moment()
    session.control.stop()
    session.shown.show()
