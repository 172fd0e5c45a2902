"""A command that has gone says in one line what to type now, and that is there."""

import re
import sys

import pytest
from helpers.installation import run_program
from helpers.places import CHECKOUT, environment

from trainer.cli import main
from trainer.cli.moved import MOVED_COMMANDS

LINES = {
    "soak": "soak is gone: from a checkout, python -m tests.soak",
    "soak --faults=10": "soak --faults is gone: from a checkout, python -m tests.faults",
    "dev bench --web": "bench --web is gone: from a checkout, python -m tests.bench --web",
    "run --headless --core=b.so": "run --core is gone: link its library into your own program, "
    "see docs/exported-core.md",
}


@pytest.mark.parametrize("line", LINES)
def test_a_command_that_has_gone_says_in_one_line_what_to_type_now(
    line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["trainer", *line.split()])

    with pytest.raises(SystemExit) as ended:
        main.main()

    assert (ended.value.code, capsys.readouterr()) == (2, ("", f"trainer: {LINES[line]}\n"))


HELP = """import runpy, sys
for module in sys.argv[1:]:
    sys.argv[1:] = ["--help"]
    try:
        runpy.run_module(module, run_name="__main__")
    except SystemExit:
        print("", flush=True)
"""


@pytest.mark.process
def test_what_is_typed_now_is_there_from_a_checkout() -> None:
    typed = {word for now in MOVED_COMMANDS.values() for word in re.findall(r"tests\.\w+", now)}
    done = run_program([sys.executable, "-c", HELP, *typed], env=environment(PYTHONPATH=CHECKOUT))

    pages = {page.split()[0]: page for page in done.stdout.split("Usage: python -m ")[1:]}
    assert pages.keys() == typed
    for now in MOVED_COMMANDS.values():
        for module in re.findall(r"tests\.\w+", now):
            assert all(option in pages[module] for option in re.findall(r"--[\w-]+", now)), now
