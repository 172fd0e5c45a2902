"""Identification of steering dynamics: from a recording to coefficients, and back to sea.

    from trainer import identify

    ship = identify.fit({"t": t, "rudder": delta, "yaw_rate": r}, model="nomoto2", length=120,
                        speed=12)
    ship.K, ship.T1, ship.predict(other), ship.summary()

Nothing is imported before one of the names is used. docs/python.md has more.

The rooms in here each know those before them: ``kernels`` (numbers only), ``model``, ``record``,
``fitting``, ``judge``, then ``ships`` (those that are not linear), ``boat`` (those that dive) and
``pages``. Begin with
``record.study``, what is asked, and ``judge.fitted``, which carries it out. ``options`` are the
command's, ``experiment`` flies a record, ``monte_carlo`` many, ``fitted_ship`` is the face above.
How a fit is found and judged stays here; other rooms use records, ships, boats and pages.
"""

__all__ = ["FittedShip", "ManoeuvringShip", "fit"]
PYTHON_FACE = tuple(__all__)  # the names for users' programs; those below are modules
# The modules that other rooms may use.
__all__ += ["boat", "monte_carlo", "options", "pages", "record", "sheet", "ships"]

TYPE_CHECKING = False  # type checkers take it for true
if TYPE_CHECKING:
    from trainer.identify.fitted_ship import FittedShip, ManoeuvringShip, fit
else:

    def __getattr__(name: str) -> object:
        """Return a public name, its module imported now."""
        if name not in PYTHON_FACE:
            raise AttributeError(f"module 'trainer.identify' has no attribute {name!r}")
        from importlib import import_module  # noqa: PLC0415

        return getattr(import_module("trainer.identify.fitted_ship"), name)
