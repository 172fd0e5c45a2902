"""The evaluation of a session under test, in its own process, for a recording without a header."""

import base64
import functools
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from helpers.crewed import Crewed
from trainer.debrief.attainable.search import NoCurve
from trainer.debrief.live.evaluator import Evaluator, FreeRun, RunFollower
from trainer.debrief.marks.judgement import plain_marks
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.io.recording.recording import Recording
from trainer.session.exercise import evaluation as module
from trainer.session.exercise.evaluation import Question
from trainer.session.past.plan import Plan


@functools.cache
def nobody_of(name: str, plan: Callable[[], Plan]) -> Mapping[str, float]:
    """Return the marks of an exercise with nobody aboard."""
    assert name
    return plain_marks(fly_rehearsal(plan()).trajectory, plan())


def evaluate_here(ship: Crewed, patch: pytest.MonkeyPatch, plan: Plan) -> None:
    """Have a session evaluated by this process, in the thread that else waits for another."""
    alone = plan.alone()
    nobody = nobody_of(plan.title, functools.partial(lambda each: each, alone))

    class Here:
        """The evaluator, asked by a call."""

        def __init__(self, words: Sequence[str]) -> None:
            self.path = Path(words[-1])
            self.follower = RunFollower(alone, nobody)

        def ask(self, question: Question) -> Mapping[str, Any] | None:
            """Return the answer of the evaluator."""
            moment = question.moment
            line = {
                "branch": moment.branch,
                "tick": moment.tick,
                "after": moment.after,
                "wants": question.wants,
                "order": question.order,
                "state": base64.b64encode(moment.state).decode(),
            }
            with closing(Recording.look(self.path)) as recording, np.errstate(all="ignore"):
                try:
                    return Evaluator(recording, self.path, self.follower).answer(line)
                except FreeRun as free:
                    return {"free": free.why}
                except NoCurve as none:
                    return {"why": none.why}

        def end(self) -> int:
            """End nothing."""
            return 0

    patch.setattr(module, "EvaluatorProcess", Here)
    ship.session.evaluation.begin(("-m", "it"), ship.conduct.marks.kept, plan)
