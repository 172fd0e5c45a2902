"""What the command line tells when the machine, or what is typed, does not do."""

import errno
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest
from helpers.nursery import run_trainer
from helpers.places import environment

import trainer
from trainer.cli import main

Typed = Callable[..., str]


def typed(*words: str, folder: Path, memory: int | None = None) -> tuple[int, str, str]:
    """Run a command of the trainer in a folder; return exit code, stdout and stderr.

    ``memory`` [kB] is what it may have, as ``ulimit -v`` sets it.
    """
    limit = f"ulimit -v {memory}; " if memory else ""
    done = subprocess.run(
        ["sh", "-c", f'{limit}exec "$@"', "sh", sys.executable, "-m", "trainer", *words],
        cwd=folder,
        env=environment(),
        capture_output=True,
        timeout=600,
        check=False,
    )
    out, told = (each.decode(errors="replace") for each in (done.stdout, done.stderr))
    return done.returncode, out, told


@pytest.mark.process
@pytest.mark.parametrize("closed", [pytest.param("2>&-", marks=pytest.mark.slow), "<&- >&- 2>&-"])
def test_closed_standard_streams_change_no_exit_code_and_nothing_that_is_written(
    tmp_path: Path, closed: str
) -> None:
    fly = "--duration 2 --speed max --no-record --socket none"
    commands = {
        f"serve steady-course --listen 127.0.0.1:0 {fly}": 0,
        "run steady-course --headless --duration 5 --speed max --record q.trainer": 0,
        "debrief q.trainer --html d.html": 0,
        "identify no-such.toml": 2,
    }
    trainer_of = f'"{sys.executable}" -m trainer'
    script = "\n".join(f'{trainer_of} {words} $CLOSED; echo "$?" >> codes' for words in commands)
    subprocess.run(
        ["sh", "-c", script.replace("$CLOSED", closed)],
        cwd=tmp_path,
        env=environment(XDG_STATE_HOME=str(tmp_path)),
        stdout=subprocess.DEVNULL,
        timeout=600,
        check=True,
    )
    codes = (tmp_path / "codes").read_text(encoding="utf-8").split()
    assert dict(zip(commands, map(int, codes), strict=True)) == commands
    assert (tmp_path / "d.html").stat().st_size > 10_000


@pytest.mark.process
def test_a_headless_run_ends_with_its_debrief_and_the_run_beside_it(tmp_path: Path) -> None:
    fly = ("run", "steady-course", "--headless", "--speed", "max", "--duration", "20")

    code, out, _ = typed(*fly, "--debrief", "it.html", folder=tmp_path)
    again = typed("debrief", "it.trainer", "--html", "again.html", folder=tmp_path)
    refused = [
        typed(*words, "--debrief", "no.html", folder=tmp_path)
        for words in (fly[:2], (*fly, "--no-record"))
    ]

    assert (code, again[0]) == (0, 0)
    assert "it.html" in out
    assert (tmp_path / "it.html").read_bytes() == (tmp_path / "again.html").read_bytes()
    assert {each[0] for each in refused} == {2}
    assert all("--debrief goes with --headless and a recording" in each[2] for each in refused)
    assert not (tmp_path / "no.trainer").exists()
    *_, twice = typed(*fly, "--debrief", "it.html", folder=tmp_path)
    assert "--debrief it.html: it.trainer is there already; give another name" in twice


@pytest.fixture
def fallen(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Typed:
    """Give what runs the command line into an exception, and returns what is told."""

    def run(error: BaseException, limit: int = resource.RLIM_INFINITY) -> str:
        def fall(**_: object) -> None:
            raise error

        monkeypatch.setattr(main, "cli", fall)
        monkeypatch.setattr(resource, "getrlimit", lambda _: (limit, limit))
        with pytest.raises(SystemExit) as ended:
            main.main()
        assert ended.value.code == 1
        return capsys.readouterr().err

    return run


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), "No space left on device"),
        (OSError(errno.EACCES, "Permission denied", "x.csv"), "x.csv: Permission denied"),
        (OSError("cannot load libllvmlite.so."), "cannot load libllvmlite.so"),
        (OSError(), "OSError"),
        (MemoryError(), "out of memory"),
    ],
)
def test_what_the_system_refused_is_told_with_its_cause(
    error: Exception, told: str, fallen: Typed
) -> None:
    assert fallen(error) == f"trainer: {told}\n"


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError("cannot load libllvmlite.so"), "cannot load libllvmlite.so"),
        (MemoryError(), "out of memory"),
        (SystemError("error return without exception set"), "out of memory"),
        (ImportError("libx.so: failed to map segment"), "libx.so: failed to map segment"),
    ],
)
def test_a_process_with_little_memory_is_told_how_to_have_more(
    error: Exception, told: str, fallen: Typed
) -> None:
    limit = "; this process may have 338 MB (ulimit -v 330000): give it more\n"

    assert fallen(error, 330_000 * 1024) == f"trainer: {told}{limit}"


def test_a_fault_of_the_program_itself_is_told_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    def fall(**_: object) -> None:
        raise ImportError("no name of that kind")

    monkeypatch.setattr(main, "cli", fall)
    with pytest.raises(ImportError):
        main.main()


@pytest.mark.process
@pytest.mark.parametrize("memory", [330_000, 250_000, 150_000])
def test_a_run_without_enough_memory_ends_at_once_in_one_line(memory: int, tmp_path: Path) -> None:
    words = ("run", "--headless", "--speed", "max", "--duration", "1")

    code, _, told = typed(*words, folder=tmp_path, memory=memory)

    assert code == 1
    assert told == (
        "trainer: out of memory; this process may have "
        f"{memory * 1024 / 1e6:.0f} MB (ulimit -v {memory}): give it more\n"
    )


@pytest.mark.parametrize("group", ["exercise", "boat", "ship", "report-1969", "dev"])
def test_the_help_of_a_group_lists_its_commands(group: str) -> None:
    command = main.cli.commands[group]
    assert isinstance(command, click.Group)
    context = click.Context(command, info_name=group, parent=click.Context(main.cli))
    _, _, listed = command.get_help(context).partition("Commands:")

    assert [line.split()[0] for line in listed.splitlines() if line[:3].strip()[:1].isalpha()] == [
        *command.commands
    ]


@pytest.mark.process
@pytest.mark.parametrize("words", [(), ("boat",), ("ship",), ("report-1969",), ("dev",)])
def test_lists_of_commands_need_none_of_the_workshops(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    shutil.copytree(
        Path(main.__file__).parents[1],
        tmp_path / "trainer",
        ignore=shutil.ignore_patterns("analysis", "identify", "workshop", "__pycache__"),
    )

    code, listed, told = typed(*words, "--help", folder=tmp_path)

    assert (code, told) == (0, "")
    assert listed == typed(*words, "--help", folder=tmp_path.parent)[1]


def test_a_word_that_lacks_is_told_in_one_line_with_the_choices(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["trainer", "station"])

    with pytest.raises(SystemExit) as ended:
        main.main()

    told = capsys.readouterr().err
    assert ended.value.code == 2
    assert told.startswith("trainer: Missing argument 'ROLE'. Choose from: instructor, helm, ")
    assert told.count("\n") == 1
    assert "\\" not in told


@pytest.mark.process
def test_a_file_whose_name_is_not_utf8_is_recorded_debriefed_and_listed(tmp_path: Path) -> None:
    name = os.fsdecode(b"nam\xff.trainer")
    with trainer.Boat(record=tmp_path / "run.trainer") as boat:
        boat.run(20)
    shutil.copy(tmp_path / "run.trainer", tmp_path / name)
    for words in (
        ("debrief", name),
        ("debrief", name, "--json"),
        ("debrief", name, "--html", "fly.html", "--fly"),
        ("recordings", "."),
        ("export", name, "--csv", os.fsdecode(b"nam\xff.csv")),
        ("replay", name),
    ):
        done = run_trainer(*words, cwd=tmp_path, env=environment())
        assert (done.returncode, done.stderr) == (0, ""), words

    page = (tmp_path / os.fsdecode(b"nam\xff.html")).read_text(encoding="utf-8")
    assert r"nam\udcff.trainer" in page


def test_a_refusal_is_broken_between_words_on_a_terminal_and_one_line_in_a_pipe(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    told = "no exercise 'bb3'; shipped: air-bank-failure, backing, bottoming, canyon"
    with pytest.raises(SystemExit):
        main.leave_with(2, told)
    assert capfd.readouterr().err == f"trainer: {told}\n"
    monkeypatch.setattr(os, "get_terminal_size", lambda _stream: os.terminal_size((40, 24)))
    with pytest.raises(SystemExit):
        main.leave_with(2, told)
    lines = capfd.readouterr().err.splitlines()
    assert max(map(len, lines)) <= 40
    assert " ".join(line.strip() for line in lines) == f"trainer: {told}"
