"""Records of a ship under helm: read, examined, guessed, and their study.

Begin with ``measurements``, a record as models take it, and ``study``, a study file. ``sources``
read records, ``findings`` examine them, ``columns`` and ``proposal`` guess at a foreign file;
``frames`` are arrays of the Python face; ``track`` gives sway velocity. ``codes``,
numbers that mean no reading, stay here.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "columns", "findings", "frames", "measurements", "proposal", "sources", "study",
    "study_records", "track",
]
# fmt: on
