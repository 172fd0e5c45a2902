"""An open, real-time submarine ship-control trainer.

    import trainer

    boat = trainer.Boat("bb2", speed=10, depth=60)
    boat.order("depth 80")
    boat.run(900)
    boat.state["z"]

Nothing is imported before a name is used: a run on an exported core needs neither numba nor its
cache. The page docs/python.md has examples of every name.
"""

__version__ = "0.3.0"
__all__ = [
    "Answer",
    "Boat",
    "ExerciseFleet",
    "Fleet",
    "Recording",
    "Snapshot",
    "TrainerError",
    "exercises",
    "fit_boat",
    "identify_ship",
    "manoeuvre",
    "read_recording",
    "seas",
    "sweep",
    "vessels",
]

TYPE_CHECKING = False  # type checkers take it for true; the module typing takes its time
if TYPE_CHECKING:
    from trainer.api.boat import Boat, Snapshot
    from trainer.api.calls import (
        Answer,
        exercises,
        fit_boat,
        identify_ship,
        manoeuvre,
        seas,
        sweep,
        vessels,
    )
    from trainer.api.exercise_fleet import ExerciseFleet
    from trainer.api.fleet import Fleet
    from trainer.config.files import ConfigError as TrainerError
    from trainer.debrief.passage.recording_export import Recording, read_recording
else:
    _MODULE_BY_NAME = {  # the module of each name; others are in calls
        **dict.fromkeys(
            ("Recording", "read_recording"), "trainer.debrief.passage.recording_export"
        ),
        **dict.fromkeys(("Boat", "Snapshot"), "trainer.api.boat"),
        "ExerciseFleet": "trainer.api.exercise_fleet",
        "Fleet": "trainer.api.fleet",
        "TrainerError": "trainer.config.files",
    }

    def __getattr__(name: str) -> object:
        """Return a public name, its module imported now."""
        if name not in __all__:
            raise AttributeError(f"module 'trainer' has no attribute {name!r}")
        import gc  # noqa: PLC0415  a run on an exported core needs none
        from importlib import import_module  # noqa: PLC0415  likewise

        collecting = gc.isenabled()
        gc.disable()  # what is imported stays: to look for garbage there is a tenth of a start
        try:
            module = import_module(_MODULE_BY_NAME.get(name, "trainer.api.calls"))
        finally:
            if collecting:
                gc.enable()
        found: object = getattr(module, "ConfigError" if name == "TrainerError" else name)
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
