"""Fits compiled once, of ships that are linear and of others: ``python -m helpers.fitted``.

Several processes that test fits would each compile them, for minutes.
"""

from helpers.ships import made_record
from trainer.cli.main import cli

if __name__ == "__main__":
    cli(["identify", "--example"], standalone_mode=False)
    problem, parameters, _ = made_record("mmg")
    problem.value(parameters)
