"""An exercise is proved before a crew has it.

Begin with ``exercise_page``: a new file, and the page that says what an exercise is worth.
``stated`` flies what its texts say, ``validation`` asks whether its marks order skill, by the crews
of ``trainees`` and their ``lateness``, ``people`` whether they tell persons apart, by model
``operators``. The commands use pages; crews and statements stay here.
"""

# The modules that other rooms may use.
__all__ = ["exercise_page", "people", "validation"]
