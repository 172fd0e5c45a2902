"""Tab completes commands, names and files, in the shells that click knows."""

import contextlib
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers.installation import run_program
from helpers.shell import HEAVY, imported, shell_environment

from trainer.analysis.manoeuvres.catalogue import MANOEUVRES
from trainer.cli import run as run_commands
from trainer.cli.main import cli
from trainer.cli.workshop import guide
from trainer.config.files import shipped_names
from trainer.session.stations.roles import ROLES


def completed(folder: Path, *words: str) -> list[str]:
    """Return what Tab offers after these words in a folder: type,word each."""
    asked = {"COMP_WORDS": "\n".join(("trainer", *words)), "COMP_CWORD": str(len(words))}
    with contextlib.chdir(folder):
        return asked_by_shell("bash_complete", **asked).split()


def asked_by_shell(wanted: str, **asked: str) -> str:
    """Return what the trainer prints where a shell asks it for this."""
    own = {"_TRAINER_COMPLETE": wanted, **asked}
    done = CliRunner().invoke(cli, [], prog_name="trainer", env=own, catch_exceptions=False)
    assert (done.exit_code, done.stderr) == (0, "")
    return done.stdout


def words_of(offered: list[str]) -> list[str]:
    """Return the words among what is offered, without those that the shell itself completes."""
    return [each.removeprefix("plain,") for each in offered if each.startswith("plain,")]


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (("check", ""), "vessels"),
        (("run", "--vessel", ""), "vessels"),
        (("run", ""), "lessons exercises"),
        (("exercise", "new", "x.toml", "--from", ""), "lessons exercises"),
        (("sea", ""), "seas"),
        (("run", "--sea", ""), "seas"),
        (("sweep", ""), "studies"),
    ],
)
def test_shipped_names_are_offered(tmp_path: Path, words: tuple[str, ...], kind: str) -> None:
    assert words_of(completed(tmp_path, *words)) == [
        name for each in kind.split() for name in shipped_names(each)
    ]


def test_manoeuvres_and_roles_are_offered_and_are_all_there_are(tmp_path: Path) -> None:
    assert words_of(completed(tmp_path, "manoeuvre", "")) == list(MANOEUVRES)
    assert words_of(completed(tmp_path, "manoeuvre", "turn")) == ["turn", "turning-circle"]
    people = [name for name in ROLES if name != "class"]
    assert words_of(completed(tmp_path, "station", "")) == people
    assert tuple(MANOEUVRES) == guide.MANOEUVRE_NAMES
    assert tuple(people) == run_commands.STATION_ROLES


def test_a_file_is_offered_by_its_ending_a_folder_with_it_and_what_is_quoted_left_to_the_shell(
    tmp_path: Path,
) -> None:
    for name in ("boat.toml", "bill.trainer", ".hidden.toml", "b.txt", "my drill.trainer"):
        (tmp_path / name).touch()
    (tmp_path / "boats").mkdir()

    assert words_of(completed(tmp_path, "check", "b")) == ["bb2", "boat.toml", "boats/"]
    assert words_of(completed(tmp_path, "check", "./b")) == ["./boat.toml", "./boats/"]
    assert words_of(completed(tmp_path, "check", ".h")) == [".hidden.toml"]
    assert words_of(completed(tmp_path, "replay", "b")) == ["bill.trainer", "boats/"]
    assert completed(tmp_path, "replay", "bo") == ["dir,bo"]
    assert completed(tmp_path, "replay", "my") == ["file,my"]
    assert completed(tmp_path, "export-core", "b") == ["file,b"]
    assert completed(tmp_path, "check", "nowhere/b") == []
    assert completed(tmp_path, "check", "~no_such_user/b") == []


def test_a_command_that_is_not_there_is_no_error_while_it_is_typed(tmp_path: Path) -> None:
    assert words_of(completed(tmp_path, "exer")) == ["exercises", "exercise"]
    assert completed(tmp_path, "nothing-like-it", "x") == []


@pytest.mark.process
def test_completion_loads_no_core(tmp_path: Path) -> None:
    words = {"COMP_WORDS": "trainer run ", "COMP_CWORD": "2"}
    names = imported((), tmp_path, _TRAINER_COMPLETE="bash_complete", **words)

    assert "trainer.config.files" in names
    assert not names.intersection(HEAVY)


@pytest.mark.process
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_is_told_how_to_complete(tmp_path: Path, shell: str) -> None:
    told = asked_by_shell(f"{shell}_source")

    assert f"{shell}_complete" in told
    if shutil.which(shell):
        (tmp_path / "completion").write_text(told)
        subprocess.run([shell, "-n", str(tmp_path / "completion")], check=True)


@pytest.mark.process
@pytest.mark.skipif(os.name != "posix" or not shutil.which("bash"), reason="no bash here")
def test_bash_completes_by_the_line_that_the_documents_show(tmp_path: Path) -> None:
    script = """
        eval "$(_TRAINER_COMPLETE=bash_source trainer)"
        COMP_WORDS=(trainer boat manoeuvre zig) COMP_CWORD=3
        _trainer_completion trainer
        echo "${COMPREPLY[@]}"
    """
    done = run_program(["bash", "-c", script], cwd=tmp_path, env=shell_environment())

    assert done.stdout.split() == ["zigzag-10", "zigzag-20"]
