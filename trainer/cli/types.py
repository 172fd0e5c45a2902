"""Types of the command line: they read and complete commands, names, files and times.

Commands name them as click's types of parameters. Click's own complete no shipped names by Tab, do
not answer a mistyped word with the nearest, and know no 1h30m.
"""

import difflib
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import click
from click.shell_completion import CompletionItem

HELP_LINES_PATH: Final = Path(__file__).with_name("help-lines.txt")  # python -m helpers.help_lines
PLAIN_NAME: Final = re.compile(r"[\w./~+:@%-]+")  # a name that no shell has to quote


@cache
def help_lines() -> Mapping[str, str]:
    """Return the first sentence of each command's help, by its place."""
    text = HELP_LINES_PATH.read_text(encoding="utf-8")
    return {place: line for place, _, line in (row.partition(" ") for row in text.splitlines())}


class FoundCommands(MutableMapping[str, click.Command]):
    """Commands by name, each imported from its place when it is asked for.

    So who types one command waits for no other, and the trainer needs neither workshop.
    """

    def __init__(self) -> None:
        self.places: dict[str, str] = {}  # such as ``trainer.cli.run.run``, by name
        self._found: dict[str, click.Command] = {}

    def add(self, place: str | click.Command) -> str:
        """Add a command, or its place; return its name."""
        if isinstance(place, click.Command):
            self[place.name or ""] = place
            return place.name or ""
        # named as click names a command by its function
        name = place.rpartition(".")[2].removesuffix("_command").replace("_", "-")
        self.places[name] = place
        return name

    def line(self, name: str) -> str:
        """Return the first sentence of a command's help; no module is imported for it."""
        listed = help_lines().get(self.places.get(name, ""))
        return listed or self[name].get_short_help_str(200)

    def __getitem__(self, name: str) -> click.Command:
        if name not in self._found:
            module, _, attribute = self.places[name].rpartition(".")
            self._found[name] = getattr(import_module(module), attribute)
        return self._found[name]

    def __setitem__(self, name: str, command: click.Command) -> None:
        self.places[name], self._found[name] = "", command

    def __delitem__(self, name: str) -> None:
        del self.places[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)

    def __len__(self) -> int:
        return len(self.places)


class Commands(click.Group):
    """A group that lists its commands by section. It answers a mistyped one with the nearest."""

    def __init__(self, *args: Any, places: Iterable[str] = (), **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.commands = self.found = FoundCommands()
        for place in places:
            self.found.add(place)
        self.sections: dict[str, list[str]] = {}
        # What is typed now, by a name that is no longer listed.
        self.earlier_names: Mapping[str, str] = {}

    def add_section(self, title: str, places: Iterable[str | click.Command]) -> None:
        """Add commands, or their places, to be listed under ``title``."""
        self.sections[title] = [*map(self.found.add, places)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each section's commands with the first sentence of their help."""
        del ctx
        width = max(map(len, self.commands))
        for title, names in (self.sections or {"Commands": [*self.commands]}).items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(width), self.found.line(name)) for name in names])

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return the arguments after the group's own options. None at all mean --help."""
        return super().parse_args(ctx, args or ["--help"])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command and its name of today; UsageError if there is none."""
        name = args[0]
        unknown = self.get_command(ctx, name) is None and not name.startswith("-")
        if unknown and not ctx.resilient_parsing:
            ctx.fail(f"no command {name!r}{self.nearest(name)}")
        typed, command, rest = super().resolve_command(ctx, args)
        return self.earlier_names.get(name, typed), command, rest

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name or an earlier one, None for no command."""
        name, _, below = self.earlier_names.get(cmd_name, cmd_name).partition(" ")
        command = super().get_command(ctx, name)
        return (
            command.get_command(ctx, below) if isinstance(command, Commands) and below else command
        )

    def nearest(self, name: str) -> str:
        """Return the hint at the command of the nearest name, "" if none is near."""
        near = difflib.get_close_matches(name, [*self.commands, *self.earlier_names], 1)
        return f"; did you mean {self.earlier_names.get(near[0], near[0])}?" if near else ""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order they are written."""
        del ctx
        return list(self.commands)


class ParentCommand(click.Command):
    """A command that has others below it, each by its first word."""

    def __init__(self, *args: Any, **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.commands: dict[str, click.Command] = {}

    def below(self, command: click.Command) -> click.Command:
        """Add a command; return it."""
        self.commands[command.name or ""] = command
        return command

    def make_context(
        self, info_name: str | None, args: list[str], *given: Any, **more: Any
    ) -> click.Context:
        """Return the context of this command, or of the one below it that is typed."""
        if args and args[0] in self.commands:
            below = self.commands[args[0]]
            return below.make_context(f"{info_name} {args[0]}", args[1:], *given, **more)
        return super().make_context(info_name, args, *given, **more)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that was typed: this one, or the one below it."""
        return super().invoke(ctx) if ctx.command is self else ctx.command.invoke(ctx)


def text_option(flag: str, text: Callable[[], str], told: str) -> Callable[[Any], Any]:
    """Return the option that prints a text and ends the command, whatever else is typed."""

    def show(ctx: click.Context, _param: click.Parameter, value: bool) -> None:  # noqa: FBT001
        if value and not ctx.resilient_parsing:
            click.echo(text())
            ctx.exit()

    return click.option(
        flag, is_flag=True, is_eager=True, expose_value=False, callback=show, help=told
    )


SPOKEN_TIME: Final = re.compile(
    r"(\d+(?:\.\d+)?)\s*(h(?:ours?|rs?)?|m(?:in(?:ute)?s?)?|s(?:ec(?:ond)?s?)?)\b[\s,]*(?:and\b)?\s*"
)


class Duration(click.ParamType[float]):
    """A time: 90, 90s, 10m, 1h, 1h30m. It answers other wordings with the nearest of these."""

    name = "duration"
    units = {"h": 3600.0, "m": 60.0, "s": 1.0}  # noqa: RUF012 (read only)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return seconds."""
        if isinstance(value, float):
            return value
        text = str(value).strip().lower()
        text += "s" if re.fullmatch(r"\d+(\.\d*)?", text) else ""
        parts = re.fullmatch(r"((\d+(?:\.\d*)?)h)?((\d+(?:\.\d*)?)m)?((\d+(?:\.\d*)?)s)?", text)
        if not text or not parts:
            wording = self._nearest(text)
            near = f"; did you mean {wording}?" if wording else ""
            self.fail(f"{value!r} is not a time such as 90, 10m or 1h30m{near}", param, ctx)
        amounts = (parts[2], parts[4], parts[6])
        total = sum(float(a) * u for a, u in zip(amounts, self.units.values(), strict=True) if a)
        if total <= 0.0:
            self.fail(f"{value!r}: a run lasts longer than 0 s", param, ctx)
        return total

    def _nearest(self, text: str) -> str:
        """Return the wording of a time in other words, such as 1 hour. "": none."""
        said = re.sub(r"(?<=\d),(?=\d)", ".", re.sub(r"\ban?\b", "1", text))
        amounts = {unit[0]: number for number, unit in SPOKEN_TIME.findall(said)}
        whole = not SPOKEN_TIME.sub("", said)
        return "".join(f"{amounts[unit]}{unit}" for unit in self.units if whole and unit in amounts)


class Speed(click.ParamType[float]):
    """A speed of time: 0.1 to 100, or max."""

    name = "speed"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the factor, infinity for max."""
        text = str(value).strip().lower()
        if text in ("max", "inf"):
            return math.inf
        try:
            factor = float(text.removeprefix("x"))
        except ValueError:
            factor = math.nan
        if not 0.1 <= factor <= 100.0:
            self.fail(f"{value!r} is not a speed of time: 0.1 to 100, or max", param, ctx)
        return factor


class File(click.Path):
    """The path of a file; Tab completes folders and the files with certain endings."""

    def __init__(self, *endings: str, dir_okay: bool = True) -> None:
        super().__init__(path_type=Path, dir_okay=dir_okay)
        self.endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path; UsageError if it cannot be both this and what else is named."""
        from trainer.io.outputs import SameFileError

        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if param is not None and ctx is not None and not ctx.resilient_parsing:
            try:
                self.take(path, param, ctx)
            except SameFileError as lost:
                self.fail(str(lost), param, ctx)
        return path

    def take(self, path: Path, param: click.Parameter, ctx: click.Context) -> None:
        """Note the file as an input. SameFileError if another parameter writes it."""
        from trainer.io.outputs import note_input

        del param, ctx
        note_input(path)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the files that the word typed so far can become."""
        del ctx, param
        return complete_files(incomplete, self.endings)


class Output(File):
    """The path of a file that is written, not an input or another kind."""

    def take(self, path: Path, param: click.Parameter, ctx: click.Context) -> None:
        """Promise the file until the command ends. SameFileError if an input would be lost."""
        from trainer.config.files import ConfigError
        from trainer.config.keywords import refuse_output
        from trainer.io.outputs import promising

        readers = (
            f"; {name_typed(each)} {path} reads it"
            for each in ctx.command.params
            if isinstance(each, click.Option)
            and type(each.type) is File
            and path.suffix.lower() in each.type.endings
        )
        try:
            refuse_output(path, self.endings, "".join(readers))
        except ConfigError as wrong:
            self.fail(str(wrong), param, ctx)
        ctx.with_resource(promising(path, name_typed(param)))


def name_typed(param: click.Parameter) -> str:
    """Return what a parameter is called where it is typed: --csv, or FILE."""
    return max(param.opts, key=len) if param.opts[0][0] == "-" else param.human_readable_name


class Name(click.ParamType[str]):
    """The name of a shipped file, or the path of a file; Tab completes both."""

    name = "text"

    def __init__(self, *kinds: str) -> None:
        self.kinds = kinds

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name; that of a file is an input. UsageError if another would write it."""
        from trainer.config.files import is_path
        from trainer.io.outputs import SameFileError, note_input

        name = super().convert(value, param, ctx)
        if is_path(name):
            try:
                note_input(Path(name))
            except SameFileError as lost:
                self.fail(str(lost), param, ctx)
        return name

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the shipped names, with their titles, and the files that the word can become."""
        del ctx, param
        from trainer.config.files import shipped_tables

        names = [
            CompletionItem(name, help=str(table.get("name", "")))
            for kind in self.kinds
            for name, table in shipped_tables(kind, incomplete).items()
        ]
        return names + complete_files(incomplete, (".toml",), alone=not names)


class Choice(click.Choice[str]):
    """One of some words. It answers a mistyped one with the nearest."""

    def get_invalid_choice_message(self, value: Any, ctx: click.Context | None) -> str:
        """Return the message about a wrong word: the right words, and the nearest."""
        from trainer.config.files import nearest

        message = super().get_invalid_choice_message(value, ctx).removesuffix(".")
        return message + nearest(str(value), map(str, self.choices))


class Word(click.ParamType[str]):
    """One of some words, which the command itself checks; Tab completes it."""

    name = "text"

    def __init__(self, words: Iterable[str]) -> None:
        self.words = tuple(words)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the words that begin as the word typed so far."""
        del ctx, param
        return [CompletionItem(word) for word in self.words if word.startswith(incomplete)]


def complete_files(
    incomplete: str, endings: tuple[str, ...], *, alone: bool = True
) -> list[CompletionItem]:
    """Return the files with those endings, and the folders, for a half-typed word.

    Without an ending any file fits. Names that a shell has to quote are left to the shell, which
    knows how; so are folders where nothing else fits. ``alone`` says that these files are all there
    is to offer: a shell that is left to complete would hide other words.
    """
    if not endings:
        return [CompletionItem(incomplete, type="file")]
    head, tail = os.path.split(incomplete)
    names = sorted(each for each in _entries(head) if each.startswith(tail) and _shown(each, tail))
    files = [name for name in names if name.endswith(endings)]
    others = (name for name in names if name not in files)
    folders = [f"{name}/" for name in others if (Path(head).expanduser() / name).is_dir()]
    paths = [os.path.join(head, name) for name in (*files, *folders)]  # noqa: PTH118 keeps ./ and ~
    if not all(map(PLAIN_NAME.fullmatch, paths)):
        return [CompletionItem(incomplete, type="file")] if alone else []
    if folders and not files and alone:
        return [CompletionItem(incomplete, type="dir")]
    return [CompletionItem(each) for each in paths]


def _entries(folder: str) -> list[str]:
    try:
        return [path.name for path in Path(folder).expanduser().iterdir()]
    except (OSError, RuntimeError):  # RuntimeError: ~nobody
        return []


def _shown(name: str, typed: str) -> bool:
    """Return whether to offer a name. A hidden one needs its dot typed."""
    return typed.startswith(".") or not name.startswith(".")


class Number(click.FloatRange):
    """A number within limits, and not "nan".

    click's own limits let "nan" pass, because no comparison with it is true.
    """

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value!r} is not a number", param, ctx)
        return number

    def _describe_range(self) -> str:
        """Return the limits for a help page, "" where there are none; click says "x<=None"."""
        bounded = self.min is not None or self.max is not None
        return super()._describe_range() if bounded else ""


AHEAD_SPEED_TYPE: Final = Number(0.0, 60.0, min_open=True)  # [kn] ahead
SPEED_TYPE: Final = Number(0.0, 60.0)  # [kn] rest included
