"""How the command line reads what is typed: commands, times and speeds of time."""

import difflib
import math
import re
from collections.abc import Iterable
from typing import Any

import click


class Commands(click.Group):
    """A group that lists its commands by section, and answers a mistyped one with the nearest."""

    def __init__(self, *args: Any, **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.sections: dict[str, list[click.Command]] = {}

    def add_section(self, title: str, commands: Iterable[click.Command]) -> None:
        """Add commands, to be listed under ``title``."""
        self.sections[title] = list(commands)
        for command in self.sections[title]:
            self.add_command(command)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each section's commands with the first sentence of their help."""
        del ctx
        width = max(len(command.name or "") for command in self.commands.values())
        for title, commands in self.sections.items():
            with formatter.section(title):
                formatter.write_dl(
                    [
                        ((command.name or "").ljust(width), command.get_short_help_str(200))
                        for command in commands
                    ]
                )

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Return what is left of the arguments once the group's own options are taken."""
        return super().parse_args(ctx, args or ["--help"])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command; UsageError naming the nearest if there is none of that name."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            near = difflib.get_close_matches(name, self.list_commands(ctx), 1)
            hint = f"; did you mean {near[0]}?" if near else ""
            ctx.fail(f"no command {name!r}{hint}")
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order they are written."""
        del ctx
        return list(self.commands)


class Duration(click.ParamType[float]):
    """A time: 90, 90s, 10m, 1h, 1h30m."""

    name = "duration"
    units = {"h": 3600.0, "m": 60.0, "s": 1.0}  # noqa: RUF012 (read only)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return seconds."""
        if isinstance(value, float):
            return value
        text = str(value).strip().lower()
        if re.fullmatch(r"\d+(\.\d*)?", text):
            return self._positive(float(text), value, param, ctx)
        parts = re.fullmatch(r"((\d+(?:\.\d*)?)h)?((\d+(?:\.\d*)?)m)?((\d+(?:\.\d*)?)s)?", text)
        if not text or not parts:
            self.fail(f"{value!r} is not a time such as 90, 10m or 1h30m", param, ctx)
        amounts = (parts[2], parts[4], parts[6])
        total = sum(float(a) * u for a, u in zip(amounts, self.units.values(), strict=True) if a)
        return self._positive(total, value, param, ctx)

    def _positive(self, seconds: float, value: Any, param: Any, ctx: Any) -> float:
        if seconds <= 0.0:
            self.fail(f"{value!r}: a run lasts longer than 0 s", param, ctx)
        return seconds


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
