"""Identification of steering dynamics: from a recording to coefficients, and back to sea.

    from trainer import identify

    ship = identify.fit({"t": t, "rudder": delta, "yaw_rate": r}, model="nomoto2", length=120,
                        speed=12)
    ship.K, ship.T1, ship.predict(other), ship.summary()

Nothing is imported before one of the names is used. docs/python.md has more.
"""

__all__ = ["FittedShip", "ManoeuvringShip", "fit"]

TYPE_CHECKING = False  # type checkers take it for true
if TYPE_CHECKING:
    from trainer.identify.fitted_ship import FittedShip, ManoeuvringShip, fit
else:

    def __getattr__(name: str) -> object:
        """Return a public name, its module imported now."""
        if name not in __all__:
            raise AttributeError(f"module 'trainer.identify' has no attribute {name!r}")
        from importlib import import_module  # noqa: PLC0415

        return getattr(import_module("trainer.identify.fitted_ship"), name)
