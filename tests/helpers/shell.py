"""What documents and help pages show is typed into a shell, in an empty folder."""

import os
import shlex
import subprocess
import sys
from itertools import groupby
from pathlib import Path

import click

from helpers.installation import run_program
from helpers.nursery import run_trainer
from helpers.places import CHECKOUT, environment
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.io.paths import PAGES_PORT

Done = subprocess.CompletedProcess[str]
TIMEOUT = 600.0  # [s] on a machine that is busy
SHELL_SIGNS = frozenset("|&;<>()$`*?[]{}~\\\n")  # by which a shell does more than call a program
FILES = {
    "turn.txt": "30 rudder right 15\n",
    "states.jsonl": '{"u": 5, "v": 0, "w": 0, "p": 0, "q": 0, "r": 0, "phi": 0, "theta": 0, '
    '"psi": 0, "z": 60, "delta_r": 0, "delta_s": 0, "delta_b": 0, "u_c": 5}\n',
}


def shell_environment(**more: str) -> dict[str, str]:
    """Return the environment of a shell that finds the trainer that is tested."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    return environment(PATH=path, BROWSER="true", **more)  # which opens nothing


def typed(line: str, folder: Path, says: str, **more: str) -> Done:
    """Type a command into a shell in that folder, and what it reads; return what it did."""
    if words := trainer_words(line):
        own = shell_environment(**more)
        return run_trainer(*words, typed=says, cwd=folder, env=own, timeout=TIMEOUT)
    return subprocess.run(
        ["sh", "-c", line],
        cwd=folder,
        env=shell_environment(**more),
        input="" if "printf" in line else says,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )


def trainer_words(line: str) -> list[str]:
    """Return what a line passes to the trainer where it asks a shell for nothing else; or none."""
    try:
        words = shlex.split(line, comments=True)
    except ValueError:
        return []
    if words[:1] != ["trainer"] or SHELL_SIGNS & set(line):
        return []
    return words[1:]


def ran(line: str, folder: Path) -> Done:
    """Run a command of the documents in a folder, the long ones shorter; return what it did."""
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    if "bench" in line and "--seconds" not in line:
        line = line.replace("trainer dev bench", "trainer dev bench --seconds 1", 1)
    if "trainer run" in line and "--web" in line:
        line = f"{line} --duration 1"
    if "--priority" in line:
        line = f"{line} --speed max"
    if "serve" in line:
        usual = str(PAGES_PORT)  # another test may have it now
        line = f"{line.replace(usual, '0')} --duration 1 --listen 127.0.0.1:0"
    beside = {"PYTHONPATH": CHECKOUT} if "python -m tests." in line else {}
    return typed(line, folder, "status\nquit\n", **beside)


HEAVY = ("numba", "numpy", "textual", "trainer.core", "trainer.boat")


def imported(words: tuple[str, ...], folder: Path | None = None, **more: str) -> set[str]:
    """Return the names of all modules that a command imports."""
    loaded = run_program(
        [sys.executable, "-X", "importtime", "-m", "trainer", *words],
        cwd=folder,
        env=environment(**more),
    ).stderr
    return {line.rpartition("|")[2].strip() for line in loaded.splitlines()}


def understand(line: str) -> list[str]:
    """Read the trainer's commands of a shell line, as it would; return their names.

    What is no command or option of theirs raises click.UsageError. Files need not be there.
    """
    words = shlex.split(line, comments=True)
    parts = [list(part) for ends, part in groupby(words, {"&&", "|", ";"}.__contains__) if not ends]
    return [name_of(part[1:]) for part in parts if part[0] == "trainer"]


def name_of(words: list[str]) -> str:
    """Return the name of the command that these words are; click.UsageError for none."""
    ends = [place for place, word in enumerate(words) if word in {"<", ">", ">>", "2>"}]
    said = words[: ends[0] if ends else None]
    if said in (["--help"], ["--version"], []):
        return "trainer"
    names = []
    with click.Context(cli, info_name="trainer") as top:
        command: click.Command = cli
        while isinstance(command, click.Group) and said and said[0] not in {"-h", "--help"}:
            name, found, said = command.resolve_command(top, said)
            assert found
            command = found
            names.append(str(name))
        try:
            command.make_context(" ".join(names), said, parent=top)
        except click.MissingParameter:
            raise
        except (click.BadParameter, ConfigError, click.exceptions.Exit):
            pass  # of a file that is not there; or all that was asked for is help
    return " ".join(names)
