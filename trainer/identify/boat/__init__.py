"""A boat from its trials: all coefficients of its ahead range fitted to records.

Begin with ``fit``, what is done in which order, then ``prior``, ``trial``, ``search``. The model is
``regressors`` and ``motion``, the likelihood ``filter``; ``report`` judges, ``figures`` makes the
bands, ``fitted_file`` writes the boat, ``page`` shows it. ``plan`` says what to sail next, of
``trial_legs``; ``planned_trial`` writes that as an exercise. ``watch`` tells by the scores of
``altered`` parts whether the boat is still the one that was fitted; ``watch_page`` shows it, and
``live`` makes the record of a session that goes on.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "figures", "fit", "instruments", "live", "page", "plan", "planned_trial", "report", "watch",
    "watch_page",
]
# fmt: on
