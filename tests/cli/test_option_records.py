"""What a command asks of the rest of the trainer is a record, whose fields are its options."""

from dataclasses import FrozenInstanceError, fields
from typing import Any

import click
import pytest

from trainer.analysis.manoeuvres.page import ManoeuvreOptions
from trainer.analysis.manoeuvres.submarine import Rig
from trainer.cli.workshop.guide import manoeuvre
from trainer.cli.workshop.identify import identify, prbs
from trainer.identify.options import IdentifyOptions
from trainer.identify.pages.experiment import ExperimentOptions
from trainer.identify.ships.trials import TrialOptions

# the command, and the fields that it makes of several words or that mean another default
RECORDS: dict[type[Any], tuple[click.Command, set[str]]] = {
    IdentifyOptions: (identify, {"further"}),
    ExperimentOptions: (prbs, {"speed_kn", "sensors"}),
    TrialOptions: (prbs, {"sensors", "amplitude"}),
    ManoeuvreOptions: (manoeuvre, {"parameters", "rig"}),
    Rig: (manoeuvre, {"sea", "engine"}),
}


@pytest.mark.parametrize("record", RECORDS)
def test_every_field_is_an_option_of_the_command_with_its_default(record: type[Any]) -> None:
    """A field of another name would never be filled, in silence."""
    command, made = RECORDS[record]
    options = {option.name: option for option in command.params}
    own = {item.name: item.default for item in fields(record) if item.name not in made}

    assert not own.keys() - options.keys()
    usual = {name: one for name, one in own.items() if type(one) in (str, int, float)}
    assert usual == {name: options[name].default for name in usual}


def test_what_was_asked_cannot_be_changed_on_the_way() -> None:
    asked: Any = IdentifyOptions(model="1")
    with pytest.raises(FrozenInstanceError):
        asked.model = "2"
