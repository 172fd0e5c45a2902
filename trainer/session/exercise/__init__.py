"""An exercise: its steps, its aids, its end, and its marks.

Begin with ``conduct``, which has all parts of it. ``exercise`` is its end, ``step_guide`` leads
through a lesson, ``training`` through the course; ``hints`` and ``aids`` help, ``reference_flight``
flies the reference crew beside. ``terms`` has what is settled before it begins. ``damage_watch``
watches the hull, ``evaluation`` says what can still be earned, ``marks`` what was.
"""

# The modules that other rooms may use.
__all__ = ["aids", "conduct", "evaluation", "exercise", "marks", "reference_flight", "terms"]
