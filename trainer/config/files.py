"""Configuration files: finding, reading and parsing them, and the messages when they are wrong.

A message is one line: file, table, key, value, and what is wrong with it.

A recording keeps the texts of the files that were read, because a replay needs them when the files
have changed or gone. Their key is ``configs/...`` for a shipped file, wherever it lies, and the
path given for others.
"""

import json
import math
import re
import tomllib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn

from trainer.io.outputs import note_input, open_new, renew_whole, write_whole

MAX_FILE_BYTES = 1_000_000  # [byte]
MAX_LINE_LETTERS = 10_000  # [characters]; tomllib takes minutes over 100,000 dotted parts
MIN_NONZERO_SIZE: Final = 1e-12  # of a number that is not 0, in any unit
MAX_QUOTED_LETTERS = 60  # [characters] of a value, a key or a table in a message
MAX_NESTED_TABLES: Final = 20  # tables and lists within one another; ours have 5
MAX_WHOLE_NUMBER: Final = 2**63  # as TOML has it; Python takes any length, and float() does not
MAX_PROBLEMS = 20  # problems of one file that a message lists
SHIPPED_PREFIX: Final = "configs/"  # what the keys of shipped files begin with
# Shipped files that old recordings and sweeps have read, and that say nothing more.
ABANDONED_FILES: Final = frozenset({"configs/terms_2510.toml"})
OWN_FILE_EXAMPLES: Final = {  # what one of a kind is called, and an example of the user's own
    "exercises": ("exercise", "./drill.toml"),
    "hulls": ("hull", "./hull.toml"),
    "seas": ("sea", "./storm.toml"),
    "ships": ("ship", "./ship.toml"),
    "studies": ("study", "./study.toml"),
    "vessels": ("vessel", "./boat.toml"),
}
CHOOSING_OPTIONS: Final = {"seas": "--sea", "vessels": "--vessel"}
LESSONS_FOLDER: Final = "lessons"  # of the exercises that lead a trainee step by step
_remembered: ContextVar[dict[str, str] | None] = ContextVar("remembered", default=None)
_recorded: ContextVar[Mapping[str, str] | None] = ContextVar("recorded", default=None)
TABLE_HEADER: Final = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]")
KEY_VALUE_LINE: Final = re.compile(r"\s*([\w-]+)\s*=\s*(.*)")
PROBLEM_SCOPE: Final = re.compile(r"(?:\[(?P<table>[^ ]+)\] )?(?:(?P<key>[\w-]+)(?:\[\d+\])? = )?")


class ConfigError(ValueError):
    """The user's file or name is wrong. ``problems`` holds one line each, the text the first."""

    def __init__(self, *problems: str) -> None:
        more = len(problems) - MAX_PROBLEMS
        rest = [f"... and {more} more"] if more > 0 else []
        super().__init__("\n".join([*problems[:MAX_PROBLEMS], *rest]))
        self.problems = problems


@contextmanager
def collecting(problems: list[str]) -> Iterator[None]:
    """Add the problems of a ConfigError inside the block to ``problems`` and go on."""
    try:
        yield
    except ConfigError as error:
        problems.extend(error.problems)


def raise_problems(problems: Collection[str]) -> None:
    """Raise ConfigError with the problems, if there are any."""
    if problems:
        raise ConfigError(*problems)


class Position(NamedTuple):
    """Where a value stands: file name, and table ('' at the top level)."""

    file: str
    table: str

    def inside(self, name: str) -> "Position":
        """Return the position of the table ``name`` within this one."""
        return Position(self.file, f"{self.table}.{name}" if self.table else name)

    def problem(self, text: str) -> str:
        """Return the one-line message ``text`` about this table."""
        table = self.table if len(self.table) <= MAX_QUOTED_LETTERS else quote(self.table)
        return f"{self.file}: [{table}] {text}" if table else f"{self.file}: {text}"

    def wrong(self, key: str, value: object, text: str) -> str:
        """Return the one-line message ``text`` about ``key = value``."""
        return self.problem(f"{quote_key(key)} = {quote(value)}: {text}")


def as_table(value: object, position: Position) -> Mapping[str, Any]:
    """Return ``value``; ConfigError if it is no table."""
    if not isinstance(value, Mapping):
        raise ConfigError(position.problem(f"must be a table, not {quote(value)}"))
    return value


def format_key(key: str) -> str:
    """Return ``key`` as TOML writes it, on one line."""
    return key if re.fullmatch(r"[\w\[\].-]+", key) else quote(key)


def quote_key(key: str) -> str:
    """Return ``key`` for a message, of readable length."""
    return format_key(key) if len(key) <= MAX_QUOTED_LETTERS else quote(key)


def quote(value: object) -> str:
    """Return ``value`` about as TOML writes it, on one line of readable length."""
    try:
        text = repr(value) if isinstance(value, float) else json.dumps(value, default=str)
    # Python prints no integers of thousands of digits, and nothing that is nested a thousand deep
    except (ValueError, RecursionError):
        text = "(too long to show)"
    return text if len(text) <= MAX_QUOTED_LETTERS else text[: MAX_QUOTED_LETTERS - 3] + "..."


def nearest(name: str, known: Iterable[str]) -> str:
    """Return '. Nearest is ...' for the known name most like ``name``, or '' if none is."""
    typed, by_fold = name.casefold(), {word.casefold(): word for word in known}
    match = [each for each in by_fold if sorted(each.split("_")) == sorted(typed.split("_"))][:1]
    match = match or get_close_matches(typed, by_fold, n=1, cutoff=0.6)
    if not match:  # the beginning of a longer name
        beginnings = {word[: len(typed)]: word for word in reversed(by_fold)}
        begun = get_close_matches(typed, beginnings, n=1, cutoff=0.75)
        match = [beginnings[each] for each in begun]
    return f"; nearest is {by_fold[match[0]]}" if match else ""


def offer_known(name: str, known: Collection[str]) -> str:
    """Return the known name most like one that is not, and all of them."""
    return f"{nearest(name, known)}; there are {', '.join(known)}"


@contextmanager
def remembering() -> Iterator[dict[str, str]]:
    """Yield a table of the texts, by key, that this thread reads inside the block."""
    texts: dict[str, str] = {}
    before = _remembered.set(texts)
    try:
        yield texts
    finally:
        _remembered.reset(before)


@contextmanager
def reading_recorded(texts: Mapping[str, str]) -> Iterator[None]:
    """Read from ``texts`` instead of files inside the block, in this thread only."""
    before = _recorded.set(texts)
    try:
        yield
    finally:
        _recorded.reset(before)


def key_of(path: Path) -> str:
    """Return the key under which the text of a file is remembered."""
    folder = _shipped_folder("")
    if path.is_relative_to(folder):
        return SHIPPED_PREFIX + path.relative_to(folder).as_posix()
    key = str(path)
    return f"./{key}" if key.startswith(SHIPPED_PREFIX) else key  # a file of the user's own


def path_of(key: str) -> Path:
    """Return the path of that key's file on this machine, if it is there."""
    return _shipped_folder("") / key.removeprefix(SHIPPED_PREFIX) if is_shipped(key) else Path(key)


def is_shipped(key: str) -> bool:
    """Return whether a key is that of a shipped file."""
    return key.startswith(SHIPPED_PREFIX)


def shipped_names(kind: str) -> tuple[str, ...]:
    """Return the names of the shipped files of ``kind``, such as 'vessels', sorted."""
    texts = _recorded.get()
    if texts is None:
        return _without_companions(path.stem for path in _shipped_folder(kind).glob("*.toml"))
    folder = f"{SHIPPED_PREFIX}{kind}/" if kind else SHIPPED_PREFIX
    names = (key.removeprefix(folder) for key in texts if key.startswith(folder))
    return _without_companions(name.removesuffix(".toml") for name in names if "/" not in name)


def shipped_tables(kind: str, beginning: str = "") -> dict[str, dict[str, Any]]:
    """Return shipped files by name, unchecked, because the checks load the core; ConfigError."""
    return {
        name: parse_toml(read_text(shipped_path(kind, name)), f"{name}.toml")
        for name in shipped_names(kind)
        if name.startswith(beginning)
    }


def _without_companions(names: Iterable[str]) -> tuple[str, ...]:
    """Return the names sorted, without those of files kept beside others: jam.baseline."""
    return tuple(sorted(name for name in names if "." not in name))


def shipped_path(kind: str, name: str) -> Path:
    """Return the path of a shipped file, '' being the top folder's kind. ConfigError if none is."""
    kind = _folder_of(kind, name)
    names = shipped_names(kind)
    if name not in names:
        raise ConfigError(
            f"no shipped file {name!r} among {kind or 'configs'}{nearest(name, names)}; "
            f"there are: {', '.join(names)}"
        )
    return _shipped_folder(kind) / f"{name}.toml"


def _folder_of(kind: str, name: str) -> str:
    """Return the folder of a shipped file: exercises that are lessons have their own."""
    is_lesson = kind == "exercises" and name in shipped_names(LESSONS_FOLDER)
    return LESSONS_FOLDER if is_lesson else kind


def is_path(name: str) -> bool:
    """Return whether a name is that of a user's file: with a separator, or .toml."""
    return name.endswith(".toml") or "/" in name or "\\" in name


def path_named(name_or_path: str, kind: str) -> Path:
    """Return where a file of ``kind`` is, a shipped one by its name. ConfigError if none is."""
    if is_path(name_or_path):
        return Path(name_or_path)
    names = shipped_names(_folder_of(kind, name_or_path))
    if name_or_path not in names:
        one, example = OWN_FILE_EXAMPLES[kind]
        near = nearest(name_or_path, names) or _as_another_kind(name_or_path)
        raise ConfigError(
            f"no {one} {quote(name_or_path)}{near}; "
            f"shipped: {', '.join(names)}; give a file of your own as a path, such as {example}"
        )
    return shipped_path(kind, name_or_path)


def _as_another_kind(name: str) -> str:
    """Return what a name stands for elsewhere or nearly does, and the option for it, if any."""
    for kind, option in CHOOSING_OPTIONS.items():
        names, one = shipped_names(kind), OWN_FILE_EXAMPLES[kind][0]
        if name in names:
            return f"; that is a {one} ({option} {name})"
        if near := nearest(name, names).removeprefix("; nearest is "):
            return f"; nearest is the {one} {near} ({option} {near})"
    return ""


def relative_name(path: Path, name: str) -> str:
    """Return a shipped file's name unchanged, and a path as seen from ``path``'s folder."""
    return str(path.parent / name) if is_path(name) else name


@cache
def _shipped_folder(kind: str) -> Path:
    """Return the folder inside the installed package, or the one of a source tree."""
    package = Path(__file__).parents[1]
    installed = package / "configs"
    return (installed if installed.is_dir() else package.parent / "configs") / kind


def read_text(path: Path) -> str:
    """Return the text of a file; ConfigError if it is no readable, small UTF-8 text."""
    return read_kept(path, _text_on_disk)


def read_kept(path: Path, read: Callable[[Path], str]) -> str:
    """Return the text that ``read`` makes of a file, or the recorded text. Remember it."""
    key, texts = key_of(path), _recorded.get()
    if texts is None:
        text = read(path)
    else:
        key = key if key in texts else _shipped_key(path, texts)
        text = texts[key]
    remembered = _remembered.get()
    if remembered is not None:
        remembered[key] = text
    return text


def text_if_there(path: Path) -> str | None:
    """Return the text of a file, or None if there is none. ConfigError as in ``read_text``."""
    texts = _recorded.get()
    if texts is None:
        return read_text(path) if path.exists() else None
    try:
        return read_text(path)
    except ConfigError:
        return None


def _shipped_key(path: Path, texts: Mapping[str, str]) -> str:
    """Return the key of a shipped file by its path on another machine; ConfigError if none is."""
    for key in filter(is_shipped, texts):
        if path.as_posix().endswith(f"/{key}"):
            return key
    raise ConfigError(f"{path}: is not among the files recorded: {', '.join(texts)}")


def _text_on_disk(path: Path) -> str:
    try:
        note_input(path)
        with path.open("rb") as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except IsADirectoryError as error:
        raise ConfigError(f"{path}: is a directory, not a file") from error
    except FileNotFoundError as error:
        raise ConfigError(f"{path}: there is no such file") from error
    except (OSError, ValueError) as error:  # ValueError: a NUL character in the path
        reason = getattr(error, "strerror", None) or error
        raise ConfigError(f"{quote(str(path))}: cannot be read: {reason}") from error
    if len(data) > MAX_FILE_BYTES:
        raise ConfigError(f"{path}: is larger than the limit of {MAX_FILE_BYTES} bytes; not read")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text (byte {error.start} is wrong)") from error


def write_once(path: Path, text: str) -> None:
    """Write a text to a new file. ConfigError if the file is there or cannot be made."""
    try:
        with open_new(path) as file:
            file.write(text.encode())
    except FileExistsError:
        raise ConfigError(f"{path} is there already: give a new name") from None
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def write_over(path: Path, content: str | bytes) -> None:
    """Write a file whole, over what was there. ConfigError if it cannot be written."""
    try:
        write_whole(path, content)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def renew_file(path: Path, text: str) -> None:
    """Write a text over a file that was read, to change it. ConfigError if it cannot be written."""
    try:
        renew_whole(path, text)
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None


def as_typed(path: Path) -> str:
    """Return a path as the commands take it. A bare name would be that of a shipped file."""
    bare = path.suffix != ".toml" and len(path.parts) == 1
    return f"./{path}" if bare else str(path)


def lines_of(text: str) -> dict[tuple[str, str], int]:
    """Return the line of each key by table and key. A table has its line with no key.

    A table of an array has its place in it: orders[2]. Tables within tables are not looked into.
    """
    line_numbers: dict[tuple[str, str], int] = {}
    table, counts, fence = "", dict[str, int](), ""
    for number, line in enumerate(text.split("\n"), start=1):
        if fence:
            fence = "" if fence in line else fence
            continue
        if head := TABLE_HEADER.match(line):
            table = head[2]
            if head[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = f"{table}[{counts[table]}]"
            line_numbers.setdefault((table, ""), number)
        elif key := KEY_VALUE_LINE.match(line):
            line_numbers.setdefault((table, key[1]), number)
            mark = key[2][:3]
            fence = mark if mark in ('"""', "'''") and mark not in key[2][3:] else ""
    return line_numbers


def number_problems(problems: Iterable[str], text: str, file: str) -> list[str]:
    """Return messages about a file in their order. Each has its line where that can be told."""
    lines, head = lines_of(text), f"{file}: "
    messages_by_line = [(_line_of(each, lines, head), each) for each in problems]
    messages_by_line.sort(key=lambda each: each[0])
    return [
        each.replace(head, f"{head}line {number}: ", 1) if number else each
        for number, each in messages_by_line
    ]


def _line_of(problem: str, lines: Mapping[tuple[str, str], int], head: str) -> int:
    """Return the line that a message is about, 0 where it cannot be told, or it says so."""
    if not problem.startswith(head) or problem.startswith(f"{head}line "):
        return 0
    about = problem.removeprefix(head)
    match = PROBLEM_SCOPE.match(about)
    table, key = (match["table"] or "", match["key"] or "") if match else ("", "")
    number = lines.get((table, key)) or lines.get((table, "")) or lines.get((key, ""))
    return number or lines.get((f"{key}[0]", "")) or 0


def json_text(value: Any, indent: int | None = None) -> str:
    """Return a value as JSON; an infinite number, or none, is null."""
    return json.dumps(_numbers_alone(value), indent=indent, allow_nan=False)


def _numbers_alone(value: Any) -> Any:
    """Return a value with None for each number within it that JSON has no word for."""
    if isinstance(value, dict):
        return {key: _numbers_alone(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_numbers_alone(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def no_constant(name: str) -> NoReturn:
    """Refuse NaN and the infinities, which Python's JSON takes; to be its ``parse_constant``."""
    raise ValueError(f"{name} is no number")


def parse_toml(text: str, file: str) -> dict[str, Any]:
    """Return the tables of a TOML text. ConfigError with file and line if it is none."""
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > MAX_LINE_LETTERS:
            raise ConfigError(
                f"{file}: line {number}: is longer than {MAX_LINE_LETTERS} characters"
            )
    try:
        tables = tomllib.loads(text)
    except RecursionError as error:
        raise ConfigError(f"{file}: is nested too deeply") from error
    except ValueError as error:
        raise ConfigError(f"{file}: {_toml_reason(str(error), text)}") from error
    _refuse_extremes(tables, file)
    return tables


def _refuse_extremes(tables: Mapping[str, Any], file: str) -> None:
    """Raise ConfigError for a key of very many parts, or a whole number that is none of TOML's."""
    level: list[tuple[str, Any]] = [*tables.items()]
    for _ in range(MAX_NESTED_TABLES):
        for key, value in level:
            if isinstance(value, int) and not -MAX_WHOLE_NUMBER <= value < MAX_WHOLE_NUMBER:
                raise ConfigError(f"{file}: {quote_key(key)}: a whole number has 19 digits at most")
        level = [
            (f"{key}.{name}", each)
            for key, value in level
            if isinstance(value, Mapping | list)
            for name, each in (value.items() if isinstance(value, Mapping) else enumerate(value))
        ]
    if level:
        raise ConfigError(
            f"{file}: {quote_key(level[0][0])}: {MAX_NESTED_TABLES} parts of a key, tables and "
            "lists within one another are the most"
        )


def _toml_reason(message: str, text: str) -> str:
    """Return tomllib's complaint with the line first, and duplicates in plain words."""
    match = re.fullmatch(r"(.*) \(at line (\d+), column \d+\)", message, re.DOTALL)
    if message.startswith("Exceeds the limit"):  # of digits; it has advice to programmers
        lines = enumerate(text.split("\n"), start=1)
        number = next((number for number, line in lines if re.search(r"[\d_]{4300}", line)), 1)
        return f"line {number}: a whole number has 19 digits at most"
    if match is None:
        return f"is not valid TOML: {message}"
    # Splitting at "\n" only, as tomllib counts; str.splitlines knows more separators.
    line = text.split("\n")[int(match[2]) - 1].strip()
    if match[1].startswith(("Cannot overwrite", "Cannot declare")):
        key = line if line.startswith("[") else line.split("=")[0].strip()
        return f"line {match[2]}: {quote_key(key)} is given twice"
    return f"line {match[2]}: is not valid TOML: {match[1]}{_value_hint(line)}"


def _value_hint(line: str) -> str:
    """Return how TOML writes the value of a line: a decimal comma, a unit, a text, a yes."""
    value = line.partition("=")[2].partition("#")[0].strip()
    if comma := re.fullmatch(r"(-?\d+),(\d+)", value):
        return f"; a number has a decimal point: {comma[1]}.{comma[2]}"
    if number := re.fullmatch(r"(-?[\d.]+)\s*[A-Za-z/%]+\d?", value):
        return f"; a number has no unit behind it: {number[1]}"
    if value.lower() in ("yes", "no", "true", "false"):
        return f"; write {'true' if value.lower() in ('yes', 'true') else 'false'}"
    return f"; a text has quotes: {quote(value)}" if re.match(r"[A-Za-z][^\"']*$", value) else ""


def toml_value(value: Any, form: str = "") -> str:
    """Return a value as TOML writes it; a float too small to read is 0."""
    if isinstance(value, Mapping):
        inside = (f"{format_key(key)} = {toml_value(each, form)}" for key, each in value.items())
        return f"{{ {', '.join(inside)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(each, form) for each in value)}]"
    if isinstance(value, str | bool):  # JSON leaves the sign of deletion, which TOML does not take
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, float):
        return format(0.0 if abs(value) < MIN_NONZERO_SIZE else value, form)
    return str(value)
