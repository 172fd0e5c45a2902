"""The commands of the workshops: boats made and proved, ships found from recordings.

``main`` finds them by name. Nothing of the trainer's own commands uses them, so that nobody who
trains waits for a workshop. Begin with ``vessel`` for boats, with ``identify`` for ships.
"""

# The modules that other rooms may use.
# fmt: off
__all__ = [
    "bench", "check_cases", "estimate", "fit_boat", "guide", "identify", "learn", "plan_trial",
    "programs", "sweep", "vessel", "watch_boat",
]
# fmt: on
