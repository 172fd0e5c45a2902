"""Exercises and classes, read into records, and what is said of them.

Begin with ``exercise`` and its ``steps``. ``score_rules`` has the measures, ``condition`` the
quantities that are watched; ``class_file`` is many boats in one sea, ``check_case`` and
``conformity`` what is proved of all.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "baseline", "check_case", "class_course", "class_file", "condition", "conformity", "course",
    "derived", "exercise", "file_schemas", "loss_words", "outcome", "progress",
    "reference_crew", "score_rules", "stated", "steps",
]
# fmt: on
