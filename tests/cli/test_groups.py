"""Commands stand in groups; what was typed before there were groups goes on."""

import re
import sys

import click
import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner
from helpers.installation import run_program
from helpers.places import environment

from trainer.cli.main import COMMAND_GROUPS, EARLIER_NAMES, cli
from trainer.config.exercise.course import AXIS_STATIONS, course
from trainer.session.crew.manning import BY_HAND, workers

# fmt: off
IN_SIGHT = [
    "run", "serve", "class", "attach", "station", "web",
    "exercises", "exercise", "casualties", "seas",
    "debrief", "recordings", "resume", "replay", "export", "identify",
    "boat", "ship", "report-1969", "dev", "help",
]
EARLIER = {  # as they were typed; a script goes on typing them
    *("vessels", "vessel", "estimate", "check", "manoeuvre", "guide", "reduce", "gains", "sea"),
    *("neutral", "thrust", "tanks", "modes", "compare", "fit", "sweep", "prbs", "decca"),
    *("steering", "bench", "check-cases", "conform", "evaluate", "instruments", "schema"),
    *("export-core", "export-fmu", "export-page"),
}
# fmt: on


def typed(*words: str) -> tuple[int, str]:
    """Return the exit code and what a command prints; of a UsageError its message."""
    result = CliRunner().invoke(cli, words)
    return result.exit_code, result.output


def command_of(spelling: str) -> click.Command:
    """Return the command that is found where these words are typed."""
    command: click.Command = cli
    with click.Context(cli) as context:
        for word in spelling.split():
            assert isinstance(command, click.Group)
            _, found, _ = command.resolve_command(context, [word])
            assert found
            command = found
    return command


def test_the_help_shows_what_is_typed_every_day_and_the_groups() -> None:
    shown = re.findall(
        r"^  ([a-z][\w-]*)  ", typed("--help")[1].partition("Train:")[2], re.MULTILINE
    )

    assert shown == IN_SIGHT


def test_every_earlier_name_is_the_command_in_its_group_and_in_no_list() -> None:
    assert set(EARLIER_NAMES) == EARLIER
    assert not EARLIER.intersection(IN_SIGHT)
    assert [
        name for name, now in EARLIER_NAMES.items() if command_of(name) is not command_of(now)
    ] == []
    assert command_of("vessel new") is command_of("boat new")
    assert typed("vessels", "--json") == typed("boat", "vessels", "--json")


@pytest.mark.parametrize(
    ("earlier", "now"),
    [(("check",), "boat check [OPTIONS]"), (("vessel", "new"), "boat new"), (("vessel",), "boat")],
)
def test_help_by_an_earlier_name_says_what_is_typed_now(earlier: tuple[str, ...], now: str) -> None:
    for words in ((*earlier, "--help"), ("help", *earlier)):
        assert f" {now}" in typed(*words)[1].splitlines()[0]


def test_only_a_fit_is_the_name_of_commands_in_two_groups() -> None:
    names = [name for group in COMMAND_GROUPS for name in group.commands]

    assert [name for name in sorted(set(names)) if names.count(name) > 1] == ["fit"]
    assert EARLIER_NAMES["fit"] == "report-1969 fit"  # as before there was a fit of boats


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("chek", "bb2"), "no command 'chek'; did you mean boat check?"),
        (("boat", "chek", "bb2"), "no command 'chek'; did you mean check?"),
        (("vessle", "new", "x.toml"), "no command 'vessle'; did you mean boat?"),
        (("steerng",), "no command 'steerng'; did you mean ship steering?"),
        (("help", "manouvre"), "no command 'manouvre'; did you mean boat manoeuvre?"),
    ],
)
def test_a_mistyped_command_is_answered_with_what_is_typed_now(
    words: tuple[str, ...], hint: str
) -> None:
    code, text = typed(*words)

    assert code == 2
    assert hint in " ".join(text.split())


@pytest.mark.parametrize("name", ["boat check", "exercise new", "identify new", "vessel new"])
def test_help_is_given_by_either_spelling(name: str) -> None:
    code, text = typed("help", *name.split())

    assert (code, text) == typed(*name.split(), "--help")
    assert text.startswith("Usage: ")
    if name == "boat check":
        assert text.partition("\n")[2] == typed("help", "check")[1].partition("\n")[2]


def test_the_shell_completes_what_is_listed_and_the_arguments_of_earlier_names() -> None:
    complete = ShellComplete(cli, {}, "trainer", "_TRAINER_COMPLETE").get_completions

    assert [each.value for each in complete([], "c")] == ["class", "casualties"]
    assert [each.value for each in complete(["boat"], "che")] == ["check", "check-cases"]
    for words in (["boat", "check"], ["check"]):
        assert [each.value for each in complete(words, "bb")] == ["bb2"]


@pytest.mark.process
def test_a_command_of_the_trainer_imports_no_workshop() -> None:
    code = "import sys\nfrom trainer.cli.main import cli\nimport trainer.session.run\n"
    code += "cli(['run', '--help'], standalone_mode=False)\nprint(*sys.modules)"
    done = run_program([sys.executable, "-c", code], env=environment())
    modules = done.stdout.split()
    assert "trainer.cli.run" in modules
    workshops = ("trainer.analysis", "trainer.identify", "trainer.cli.workshop")
    assert not [name for name in modules if name.startswith(workshops)]


def test_the_list_of_exercises_tells_length_stations_and_hand() -> None:
    lines = {line.split()[0]: line for line in typed("exercises")[1].splitlines() if line}

    assert lines["stern-plane-jam"].endswith("10 min 2 planes,speed")
    assert lines["steering-jam"].endswith("10 min 1 rudder,speed")
    assert lines["rise-jam-shallow"].endswith("10 min 3 all but rudder")
    assert lines["watch"].endswith("30 min 3 all")
    assert lines["wheel-and-course"].endswith("10 steps 1 rudder")
    assert {axis: workers(axis)[0] for axis in BY_HAND} == AXIS_STATIONS
    assert {each.stations for each in course()} >= {("helm",), ("planes", "helm"), ("ballast",)}
