"""A command that has gone says in one line what to type now."""

import subprocess
import sys

import pytest
from helpers.places import environment

LINES = {
    "run --core libtrainer_core.so --headless": "run --core is gone: link its library into",
    "run --headless --core=libtrainer_core.so": "run --core is gone: link its library into",
}


@pytest.mark.parametrize("line", LINES)
def test_a_command_that_has_gone_says_in_one_line_what_to_type_now(line: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "trainer", *line.split()],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )

    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"trainer: {LINES[line]}")
    assert done.stderr.count("\n") == 1
