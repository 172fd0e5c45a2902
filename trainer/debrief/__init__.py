"""A recording is judged as an exercise: measures, marks, a page.

Begin with ``passage``, what was sailed. ``marks`` are made from it, ``ticks`` counts them while a
run is flown, and ``attainable`` asks what a careful crew could still earn. ``page`` writes all of
it, ``trainees`` puts runs beside one another, ``live`` serves a session that goes on.

Other rooms judge a run, rehearse an exercise, or write a page.
"""

# The rooms that other rooms may use.
__all__ = ["attainable", "live", "marks", "page", "passage", "ticks", "trainees"]
