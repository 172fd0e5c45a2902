"""A recording is judged as an exercise: measures, marks, a page.

Begin with ``trajectory``, what was sailed to the end of a branch. ``measures`` and ``episodes`` are
read from it, ``scoring`` and ``judgement`` make marks of them, ``data`` gathers what ``sections``
and ``charts`` show, ``page`` writes it. ``rehearsal`` flies an exercise without a session, by its
reference crew or nobody; ``attainable`` asks what a careful crew could still earn.

``class_debrief`` puts the boats of a class beside one another, by a ``run_summary`` of each.

``recording_export`` gives what was sailed as columns, ``boat_page`` a page to sail on from there.

``beside``, ``evaluator`` and ``progress`` are started by name as processes of their own. Other
rooms judge a run, rehearse an exercise, or write a page; what a page consists of stays here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "attainable", "beside", "boat_page", "class_page", "controls", "episodes", "evaluator",
    "forgetting", "forms", "history", "judgement", "page", "progress",
    "progress_words", "recording_export", "rehearsal", "scoring", "tally_sheet", "tick_judge",
    "trajectory",
]
# fmt: on
