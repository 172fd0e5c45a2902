"""An exercise: its steps, its aids, its end, and its marks.

Begin with ``conduct``, which has all parts of it. ``exercise`` is its end, ``step_guide`` leads
through a lesson, ``training`` through the course; ``hints`` and ``aids`` help, ``second_boat``
flies the reference crew beside. ``hull`` watches the hull, ``evaluation`` says what can still be
earned, ``marks`` what was.
"""

# The modules that other rooms may use.
__all__ = ["aids", "conduct", "evaluation", "exercise", "marks", "second_boat", "training"]
