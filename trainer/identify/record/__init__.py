"""Records of a ship under helm: read, examined, guessed, and their study.

Begin with ``measurements``, a record as models take it, and ``study``, a study file. ``sources``
read records, ``readings`` tell each channel's own, ``findings`` examine them, ``evidence`` compares
channels by ``motion_laws``, ``contradictions`` says what mends them; ``columns`` and ``proposal``
guess at a foreign file; ``track`` gives sway velocity. All modules are open.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "columns", "contradictions", "evidence", "findings", "frames", "logs", "measurements",
    "motion_laws", "proposal", "readings", "sources", "study", "study_records", "track",
]
# fmt: on
