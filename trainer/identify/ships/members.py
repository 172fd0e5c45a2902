"""Members of a study that sail an identified ship, one by one."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.analysis.sweep.batch import Batch, fly_each
from trainer.analysis.sweep.manoeuvres import ALONE, manoeuvre_of, speed_of
from trainer.analysis.sweep.outputs import Output, asked_of, read_off
from trainer.analysis.sweep.records import ManoeuvreTable
from trainer.analysis.sweep.study import Study
from trainer.config.files import ConfigError, Place
from trainer.config.schema import read_record
from trainer.identify.ships.ship_file import read_ship
from trainer.identify.ships.vehicle import IdentifiedShip

OF_BOATS: Final = {
    "method": ("equations", "rates", "trig", "integrator"),
    "manoeuvre": ("depth_kept", "controls", "trim", "law"),
}


class Sailing:
    """The members of a study that sail a manoeuvre."""

    chunk = ALONE

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member cannot sail."""
        self.study = study
        self.trial, self.flight = self._sailed(study.draws.middle())

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return what is kept of each member. ConfigError if the study asks for what is not."""
        return asked_of(self.study, self.flight, self.trial.measures(self.flight))

    def batch(self, first: int, count: int) -> Batch:
        """Return what becomes of ``count`` members from ``first`` on."""
        return fly_each(self.study.draws, first, count, len(self.outputs), self._numbers)

    def _numbers(self, drawn: Mapping[str, Any], seed: int) -> list[float]:
        """Return the numbers of one member; ConfigError why there are none."""
        del seed  # nothing is random in calm water
        manoeuvre, flight = self._sailed(drawn)
        if flight.lost:
            raise ConfigError(flight.lost)
        return read_off(self.outputs, flight, manoeuvre.measures(flight))

    def _sailed(self, drawn: Mapping[str, Any]) -> tuple[Manoeuvre, Flight]:
        """Return manoeuvre and flight of one member; ConfigError if it cannot begin."""
        tables, path = self.study.varied(drawn), self.study.path
        inside = Place(path.name, "manoeuvre")
        table = read_record(ManoeuvreTable, tables["manoeuvre"], inside, ())
        _check_words(self.study, table)
        named = Path(self.study.heading.vessel or "")
        ship = IdentifiedShip(read_ship(tables["vessel"], named), self.study.method.step_s)
        manoeuvre = manoeuvre_of(table, ship)
        return manoeuvre, fly(ship, manoeuvre, speed_of(table, ship.speed_kn))


def _check_words(study: Study, table: ManoeuvreTable) -> None:
    """Check that a study has no words for boats alone; ConfigError with all it has."""
    given = {"method": asdict(study.method), "manoeuvre": asdict(table)}
    problems = [
        Place(study.path.name, where).wrong(key, given[where][key], "is for boats, not for ships")
        for where, keys in OF_BOATS.items()
        for key in keys
        if given[where][key] is not None
    ]
    if problems:
        raise ConfigError(*problems)
