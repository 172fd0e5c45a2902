"""Records described by their fields: unit, limits and meaning, and reading one from a table.

Every reader of files in the trainer is made of it. Every table of every configuration file is such
a record: a frozen, keyword-only dataclass whose fields carry their kind as metadata. From this one
description come the check of a file and its messages, the JSON Schema for editors, and the tables
of keys in the documents.
"""

import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, asdict, dataclass, field, fields, make_dataclass
from functools import cache
from typing import Any, NamedTuple, Protocol, TypeVar

from trainer.config.files import (
    MIN_NONZERO_SIZE,
    ConfigError,
    Position,
    as_table,
    collecting,
    nearest,
    raise_problems,
)

Record = TypeVar("Record")
MAX_TABLE_DEPTH = 20  # of tables within tables that nobody reads
JSON_SCHEMA_DRAFT = "https://json-schema.org/draft/2020-12/schema"


@dataclass(frozen=True)
class NumberLimits:
    """An interval of numbers; the lower end itself is outside when ``open_below``."""

    low: float
    high: float
    open_below: bool

    def __contains__(self, value: float) -> bool:
        return (self.low < value if self.open_below else self.low <= value) and value <= self.high

    def __str__(self) -> str:
        if not self.open_below:
            return f"{self.low:g} to {self.high:g}"
        return f"above {self.low:g}" + (f" to {self.high:g}" if self.high < math.inf else "")

    @property
    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of a number within."""
        low = "exclusiveMinimum" if self.open_below else "minimum"
        ends = {"maximum": self.high} if self.high < math.inf else {}
        return {"type": "number", low: self.low, **ends}


def within(low: float, high: float) -> NumberLimits:
    """Return the interval from ``low`` to ``high``, ends included."""
    return NumberLimits(low, high, open_below=False)


def above(low: float, high: float = math.inf) -> NumberLimits:
    """Return the interval above ``low``, to ``high`` included."""
    return NumberLimits(low, high, open_below=True)


class KeyForm(NamedTuple):
    """A kind among the keys, and the JSON Schema of its values, without the meaning."""

    unit: str
    range: str
    meaning: str
    schema: dict[str, Any]


class Kind(Protocol):
    """The kind of a field's value: its check, and its form."""

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""

    def read(self, key: str, value: object, position: Position) -> object:
        """Return the checked value; ConfigError if it is wrong."""


@dataclass(frozen=True)
class Quantity:
    """One finite number in a unit, within limits, 0 or of a ``least`` size."""

    unit: str
    limits: NumberLimits
    meaning: str
    least: float = MIN_NONZERO_SIZE

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm(self.unit, str(self.limits), self.meaning, self.limits.schema)

    def read(self, key: str, value: object, position: Position) -> float:
        """Return the number [unit]; ConfigError if it is none or outside the limits."""
        unit = "" if self.unit == "-" else f" {self.unit}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigError(position.wrong(key, value, f"must be a number, {self.limits}{unit}"))
        number = float(value) if abs(value) <= sys.float_info.max else math.inf
        if not math.isfinite(number):
            raise ConfigError(position.wrong(key, value, f"must be finite, {self.limits}{unit}"))
        if number not in self.limits:
            raise ConfigError(position.wrong(key, value, f"must be {self.limits}{unit}"))
        if 0.0 < abs(number) < self.least:
            least = f"must be 0, or {self.least:g}{unit} or more in size, {self.limits}{unit}"
            raise ConfigError(position.wrong(key, value, least))
        return number


@dataclass(frozen=True)
class WholeNumber:
    """One whole number."""

    low: int
    high: int
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        schema = {"type": "integer", "minimum": self.low, "maximum": self.high}
        return KeyForm("whole number", f"{self.low} to {self.high}", self.meaning, schema)

    def read(self, key: str, value: object, position: Position) -> int:
        """Return the number; ConfigError if it is none, or outside the limits."""
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not (whole and isinstance(value, int) and self.low <= value <= self.high):
            message = f"must be a whole number, {self.low} to {self.high}"
            raise ConfigError(position.wrong(key, value, message))
        return value


@dataclass(frozen=True)
class Quantities:
    """A list of ``fewest`` to ``most`` numbers of one kind."""

    each: Quantity
    fewest: int
    most: int

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        unit, limits, meaning, schema = self.each.form
        listed = list_schema(schema, self.fewest, self.most)
        return KeyForm(unit, f"{self._count} numbers, {limits}", meaning, listed)

    @property
    def _count(self) -> str:
        return f"{self.fewest}" if self.fewest == self.most else f"{self.fewest} to {self.most}"

    def read(self, key: str, value: object, position: Position) -> tuple[float, ...]:
        """Return the numbers; ConfigError naming the first that is wrong."""
        if not isinstance(value, list) or not self.fewest <= len(value) <= self.most:
            raise ConfigError(
                position.wrong(key, value, f"must be a list of {self._count} numbers")
            )
        return tuple(self.each.read(f"{key}[{i}]", item, position) for i, item in enumerate(value))


@dataclass(frozen=True)
class Text:
    """One printable line, not empty."""

    longest: int
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        schema = {"type": "string", "minLength": 1, "maxLength": self.longest}
        return KeyForm("text", f"1 to {self.longest} characters", self.meaning, schema)

    def read(self, key: str, value: object, position: Position) -> str:
        """Return the line; ConfigError if it is empty, too long or not printable."""
        if not isinstance(value, str) or not value.isprintable():
            raise ConfigError(position.wrong(key, value, "must be one line of text"))
        if not 1 <= len(value) <= self.longest:
            raise ConfigError(
                position.wrong(key, value, f"must have 1 to {self.longest} characters")
            )
        return value


@dataclass(frozen=True)
class LongText(Text):
    """Some lines of text."""

    def read(self, key: str, value: object, position: Position) -> str:
        """Return the text; ConfigError if it is empty, too long or not printable."""
        good = isinstance(value, str) and value.replace("\n", "").isprintable()
        if not isinstance(value, str) or not good or not 1 <= len(value.strip()) <= self.longest:
            raise ConfigError(
                position.wrong(
                    key, value, f"must be printable text of 1 to {self.longest} characters"
                )
            )
        return value.strip()


@dataclass(frozen=True)
class Choice:
    """One of a few words."""

    words: tuple[str, ...]
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm("word", " or ".join(self.words), self.meaning, {"enum": [*self.words]})

    def read(self, key: str, value: object, position: Position) -> str:
        """Return the word; ConfigError if it is none of them."""
        if not isinstance(value, str) or value not in self.words:
            raise ConfigError(position.wrong(key, value, f"must be {' or '.join(self.words)}"))
        return value


@dataclass(frozen=True)
class Flag:
    """True or false."""

    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm("word", "true or false", self.meaning, {"type": "boolean"})

    def read(self, key: str, value: object, position: Position) -> bool:
        """Return the word; ConfigError if it is neither."""
        if not isinstance(value, bool):
            raise ConfigError(position.wrong(key, value, "must be true or false"))
        return value


@dataclass(frozen=True)
class Texts:
    """A list of printable lines."""

    each: Text
    most: int

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        _, _, meaning, schema = self.each.form
        return KeyForm("texts", f"0 to {self.most}", meaning, list_schema(schema, 0, self.most))

    def read(self, key: str, value: object, position: Position) -> tuple[str, ...]:
        """Return the lines; ConfigError naming the first that is wrong."""
        if not isinstance(value, list) or len(value) > self.most:
            message = f"must be a list of {self.most} texts at most"
            raise ConfigError(position.wrong(key, value, message))
        return tuple(self.each.read(f"{key}[{i}]", item, position) for i, item in enumerate(value))


@dataclass(frozen=True)
class Choices:
    """A list of some of a few words, each at most once."""

    words: tuple[str, ...]
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        schema = {"type": "array", "items": {"enum": [*self.words]}, "uniqueItems": True}
        return KeyForm("words", f"some of {', '.join(self.words)}", self.meaning, schema)

    def read(self, key: str, value: object, position: Position) -> tuple[str, ...]:
        """Return the words; ConfigError if one is unknown or given twice."""
        listed = value if isinstance(value, list) else [value]
        unknown = [str(item) for item in listed if item not in self.words]
        if unknown or not isinstance(value, list):
            like = nearest(unknown[0], self.words) if unknown else ""
            text = f"must list some of {', '.join(self.words)}{like}"
            raise ConfigError(position.wrong(key, value, text))
        if len(set(value)) < len(value):
            raise ConfigError(position.wrong(key, value, "must not name one twice"))
        return tuple(value)


@dataclass(frozen=True)
class NamedNumbers:
    """A table of numbers of one kind under given names, all of them necessary."""

    each: Quantity
    names: tuple[str, ...]

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        unit, limits, meaning, schema = self.each.form
        table = object_schema(dict.fromkeys(self.names, schema), self.names)
        return KeyForm(unit, limits, f"{meaning}: {', '.join(self.names)}", table)

    def read(self, key: str, value: object, position: Position) -> dict[str, float]:
        """Return number by name; ConfigError if a name is unknown or lacking."""
        record = _record_of(key, self)
        return asdict(read_record(record, value, position.inside(key), ()))


@cache
def _record_of(key: str, kind: NamedNumbers) -> type[Any]:
    """Return the class of records with these names.

    It is cached, because to make a class takes as long as to read a file.
    """
    return make_dataclass(
        key,
        [(name, float, field(metadata={"kind": kind.each})) for name in kind.names],
        frozen=True,
        kw_only=True,
    )


@dataclass(frozen=True)
class Rows:
    """An array of ``fewest`` to ``most`` tables, each one record."""

    record: type[Any]
    documentary: tuple[str, ...]
    fewest: int
    most: int
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        row = record_schema(self.record, self.documentary)
        listed = list_schema(row, self.fewest, self.most)
        return KeyForm("tables", f"{self.fewest} to {self.most}", self.meaning, listed)

    def read(self, key: str, value: object, position: Position) -> tuple[Any, ...]:
        """Return the records in the order of the file; ConfigError with all that is wrong."""
        return tuple(
            read_record(self.record, row, position.inside(f"{key}[{i}]"), self.documentary)
            for i, row in enumerate(self.listed(key, value, position))
        )

    def listed(self, key: str, value: object, position: Position) -> list[Any]:
        """Return the rows as they are written; ConfigError if these are no such list."""
        if not isinstance(value, list) or not self.fewest <= len(value) <= self.most:
            text = f"must be {self.fewest} to {self.most} tables [[{position.inside(key).table}]]"
            raise ConfigError(position.wrong(key, value, text))
        return value


@dataclass(frozen=True)
class Table:
    """One table inside another, described by a record."""

    record: type[Any]
    meaning: str

    @property
    def documentary(self) -> tuple[str, ...]:
        """Return the keys that are for the reader."""
        return ("note",)

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm("table", "1", self.meaning, record_schema(self.record, self.documentary))

    def read(self, key: str, value: object, position: Position) -> Any:
        """Return the record; ConfigError with all that is wrong."""
        return read_record(self.record, value, position.inside(key), self.documentary)


def required(*kind: Any) -> Any:
    """Return a necessary field of a kind, or of a quantity's unit, limits and meaning."""
    return field(metadata=_metadata(kind))


def optional(*kind: Any) -> Any:
    """Return a field as ``required``, or None where the file does not say."""
    return field(default=None, metadata=_metadata(kind))


def with_default(value: Any, *kind: Any) -> Any:
    """Return a field as ``required``, or ``value`` where the file does not say."""
    return field(default=value, metadata=_metadata(kind))


def _metadata(kind: tuple[Any, ...]) -> dict[str, Kind]:
    """Return what ``kind_of`` reads; most fields are quantities, so their three words suffice."""
    return {"kind": Quantity(*kind) if len(kind) > 1 else kind[0]}


def kind_of(item: Field[Any]) -> Kind:
    """Return the kind of a field that ``required`` or ``optional`` made."""
    kind: Kind = item.metadata["kind"]
    return kind


def kinds_of(record: type[Any]) -> dict[str, Kind]:
    """Return the kind of each key of a record, by name, in the record's order."""
    return {item.name: kind_of(item) for item in fields(record)}


def list_schema(each: Mapping[str, Any], fewest: int, most: int) -> dict[str, Any]:
    """Return the JSON Schema of a list of ``fewest`` to ``most`` values."""
    return {"type": "array", "items": dict(each), "minItems": fewest, "maxItems": most}


def object_schema(keys: Mapping[str, Mapping[str, Any]], needed: Iterable[str]) -> dict[str, Any]:
    """Return the JSON Schema of a table: its keys with their schemas, and none besides."""
    return {
        "type": "object",
        "properties": {key: dict(schema) for key, schema in keys.items()},
        "required": [*needed],
        "additionalProperties": False,
    }


def describe_kind(kind: Kind) -> dict[str, Any]:
    """Return the JSON Schema of a kind with unit and meaning, which editors show."""
    unit, _, meaning, schema = kind.form
    message = meaning if isinstance(kind, Text | Choice | Rows | Table) else f"[{unit}] {meaning}"
    return {"description": message, **schema}


def record_schema(
    record: type[Any], documentary: Iterable[str], supplied: Iterable[str] = ()
) -> dict[str, Any]:
    """Return the JSON Schema of a table that is read as a ``record``.

    ``documentary`` names keys that may hold anything; ``supplied`` those that a file of defaults
    gives where the user's does not.
    """
    known = {key: describe_kind(kind) for key, kind in kinds_of(record).items()}
    free = {key: {"description": "for the reader"} for key in documentary}
    needed = [item.name for item in fields(record) if item.default is MISSING]
    return object_schema({**known, **free}, [key for key in needed if key not in {*supplied}])


def file_schema(
    title: str, keys: Mapping[str, Mapping[str, Any]], needed: Iterable[str]
) -> dict[str, Any]:
    """Return the JSON Schema, draft 2020-12, of a file of these keys and tables."""
    return {"$schema": JSON_SCHEMA_DRAFT, "title": title, **object_schema(keys, needed)}


def find_infinite(value: object, key: str, position: Position, depth: int = 0) -> list[str]:
    """Return where a value for the reader holds nan or an infinite number."""
    if isinstance(value, float) and not math.isfinite(value):
        return [position.wrong(key, value, "must be finite")]
    inner: Iterable[tuple[str, object]] = ()
    if isinstance(value, Mapping):
        inner = ((f"{key}.{name}", item) for name, item in value.items())
    elif isinstance(value, list):
        inner = ((f"{key}[{i}]", item) for i, item in enumerate(value))
    if inner and depth > MAX_TABLE_DEPTH:
        return [position.problem(f"{key}: is nested too deeply")]
    return [
        wrong for name, item in inner for wrong in find_infinite(item, name, position, depth + 1)
    ]


def read_record(
    record: type[Record], table: object, position: Position, documentary: Iterable[str]
) -> Record:
    """Return ``table`` as a ``record``, leaving out documentary keys; ConfigError with all faults.

    ``record`` is a dataclass with keyword-only fields, each with a kind.
    """
    content = as_table(table, position)
    items: tuple[Field[Any], ...] = fields(record)  # type: ignore[arg-type]
    known = [item.name for item in items]
    problems = [
        position.wrong(key, value, f"no such key{nearest(key, known)}")
        for key, value in content.items()
        if key not in known and key not in documentary
    ]
    for key in documentary:
        problems += find_infinite(content.get(key), key, position)
    lacking = [item.name for item in items if item.default is MISSING and item.name not in content]
    if lacking:
        problems.append(position.problem(f"lacks {', '.join(lacking)}"))
    values = {}
    for item in items:
        if item.name in content:
            with collecting(problems):
                values[item.name] = kind_of(item).read(item.name, content[item.name], position)
    raise_problems(problems)
    return record(**values)
