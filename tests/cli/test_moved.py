"""A command that has gone says in one line what to type now, and that is there."""

import re
import subprocess
import sys

import pytest
from helpers.lanes import sample_cases
from helpers.nursery import run_trainer
from helpers.places import CHECKOUT, environment

from trainer.cli.moved import MOVED_COMMANDS

LINES = {
    "soak": "soak is gone: from a checkout, python -m tests.soak",
    "soak --faults=10": "soak --faults is gone: from a checkout, python -m tests.faults",
    "fuzz orders --inputs 10": "fuzz is gone: from a checkout, python -m tests.fuzz",
    "bench --json --peers": "bench --peers is gone: from a checkout, python -m tests.bench --peers",
    "identify --selftest": "identify --selftest is gone: from a checkout, python -m tests.cases",
    "run --headless --core=b.so": "run --core is gone: link its library into your own program, "
    "see docs/exported-core.md",
}


@pytest.mark.process
@pytest.mark.parametrize("line", LINES)
def test_a_command_that_has_gone_says_in_one_line_what_to_type_now(line: str) -> None:
    done = run_trainer(*line.split(), env=environment())

    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"trainer: {LINES[line]}\n")


NEW = sorted({word for now in MOVED_COMMANDS.values() for word in re.findall(r"tests\.\w+", now)})


@pytest.mark.process
@pytest.mark.parametrize("module", sample_cases(NEW, "tests.cases"))
def test_what_is_typed_now_is_there_from_a_checkout(module: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", module, "--help"],
        env=environment(PYTHONPATH=CHECKOUT),
        capture_output=True,
        text=True,
        check=True,
    )

    assert done.stdout.startswith(f"Usage: python -m {module} [OPTIONS]")
    for now in MOVED_COMMANDS.values():
        if module in now:
            assert all(option in done.stdout for option in re.findall(r"--[\w-]+", now)), now
