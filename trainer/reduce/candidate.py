"""A boat that flies by a compact set in the making."""

from collections.abc import Iterable
from typing import Final

from trainer.core.vessel import BASIC_DROPS, EXTRA_TERMS, KEPT, compact_record
from trainer.files.vessel_file import VesselFile
from trainer.fitout import body, thrust_rows
from trainer.guide.programme import Leg, own_method
from trainer.study.manoeuvres.flight import Flight, fly
from trainer.study.manoeuvres.submarine import Submarine
from trainer.units import KNOT

# What the crew commands stays at its strength: no manoeuvre moves bow planes by themselves, and a
# boat without rudder drag would pass many a test.
CONTROLS: Final = (*("X_drdr", "X_dsds", "X_dbdb", "Y_dr", "Z_ds", "Z_db", "M_ds", "M_db", "N_dr"),)
FIXED: Final = ("X_dbdb", "Z_db", "M_db")
ADDED_MASSES: Final = tuple(name for name in (*KEPT, *EXTRA_TERMS) if name.endswith("dot"))


def terms(file: VesselFile, equations: str) -> tuple[str, ...]:
    """Return the coefficients of this hull that the compact kernel has room for."""
    dropped = BASIC_DROPS if equations == "basic" else ()
    return tuple(
        name for name in (*KEPT, *EXTRA_TERMS) if file.coefficients[name] and name not in dropped
    )


class Candidate:
    """A submarine whose compact constants are the full set's times factors that can change."""

    def __init__(self, file: VesselFile, equations: str) -> None:
        """Fit the boat out."""
        self.terms = terms(file, equations)
        self._file = file
        self._boat = Submarine(file, own_method(file, equations))
        self._body = body(file)
        self._rows, self._eta = thrust_rows(file)

    def take(self, factors: Iterable[float]) -> None:
        """Fly by these factors from now on, by term."""
        prime = {
            name: self._file.coefficients[name] * float(factor)
            for name, factor in zip(self.terms, factors, strict=True)
        }
        record = compact_record(self._body, {**prime, **self._rows}, self._eta)
        self._boat.boat.records.compact[:] = record

    def fly(self, leg: Leg, beside: Flight) -> Flight:
        """Return the flight of a leg beside the full set's; ConfigError if it cannot start."""
        return fly(self._boat, leg.manoeuvre, leg.speed_kn * KNOT, beside.events)
