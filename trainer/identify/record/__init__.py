"""Records of a ship under helm: read, examined, guessed, and their study.

Begin with ``measurements``, a record as models take it, and ``study``, a study file. ``sources``
read records, ``findings`` examine them, ``signs`` compare channels, ``columns`` and ``proposal``
guess at a foreign file; ``track`` gives sway velocity. All modules are open.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "columns", "findings", "measurements", "proposal", "readings", "signs", "sources", "study",
    "study_records", "track",
]
# fmt: on
