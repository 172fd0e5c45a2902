"""``trainer boat new``: a vessel file written out, every key with unit and meaning.

The numbers are those of a shipped boat, at another length by Froude's law (``similarity``).
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from textwrap import wrap
from typing import Any, Final

from trainer.config.boat.coefficients import FORCE_AXES
from trainer.config.boat.similarity import formula, law_of, scaled_table
from trainer.config.boat.vessel import (
    DOCUMENTARY_TABLES,
    HEADING_FIELDS,
    OPTIONAL_TABLES,
    VESSEL_RECORDS,
    parse_vessel,
    with_defaults,
)
from trainer.config.files import (
    as_typed,
    format_key,
    parse_toml,
    path_named,
    read_text,
    toml_value,
    write_once,
)
from trainer.config.schema import Kind, NamedNumbers, Rows, Table, kinds_of
from trainer.core.terms import COEFFICIENTS

MAX_LINE_COLUMNS: Final = 100
SAME_SIZE: Final = 1.0  # factor of a copy
PRIME_NOTE: Final = "[-] times rho/2, the power of L and the motion told behind each; absent: zero"
DEPTH_KEYS: Final = ("max_depth_m", "test_depth_m")  # the first given is the deepest to be ordered
LAWS_NOTE: Final = """\
# Laws: Froude's similarity. The water and gravity stay; lengths go as L, areas as L^2, masses and
# volumes as L^3, moments of inertia as L^5, times and speeds as L^0.5, rates as L^-0.5. What has no
# unit stays: coefficients, angles, shares. "estimate" marks what no such law holds for.
# In brackets: unit, and the law by which the value follows the length."""


class TemplateWriter:
    """Writes the tables of a boat, ``factor`` times as long [-] as its source."""

    def __init__(self, factor: float) -> None:
        """Remember the factor; 1 is a copy."""
        self._factor = factor

    def table(self, name: str, record: type[Any], table: Mapping[str, Any]) -> Iterator[str]:
        """Yield a table and those inside it, keys in the order of the record."""
        summary = (record.__doc__ or "").partition("\n")[0]
        yield from ("", f"# {'-' * 72}", f"# {summary}", f"[{name}]")
        yield from self._keys(name, record, table, comments=True)
        yield from self._inner(name, record, table)

    def _keys(
        self, name: str, record: type[Any], table: Mapping[str, Any], *, comments: bool
    ) -> Iterator[str]:
        """Yield the keys of a table that are values, then those for the reader."""
        kinds = kinds_of(record)
        for key, kind in kinds.items():
            if isinstance(kind, Rows | Table | NamedNumbers):
                continue
            note = self._note(name, key, kind) if comments else ""
            if key in table:
                yield from _line(f"{key} = {toml_value(table[key])}", note)
            elif comments:
                yield from _line(f"# {key} =", note)
        for key, value in table.items():
            if key not in kinds:
                yield f"{format_key(key)} = {toml_value(value)}"

    def _inner(self, name: str, record: type[Any], table: Mapping[str, Any]) -> Iterator[str]:
        """Yield the tables inside a table."""
        for key, kind in kinds_of(record).items():
            inside, value = f"{name}.{key}", table.get(key)
            if isinstance(kind, Table) and value is not None:
                yield from ("", f"[{inside}]")
                yield from self._keys(inside, kind.record, value, comments=True)
            elif isinstance(kind, NamedNumbers) and value is not None:
                yield from ("", f"[{inside}]   {self._note(name, key, kind)}")
                yield from (f"{word} = {toml_value(each)}" for word, each in value.items())
            elif isinstance(kind, Rows):
                for i, row in enumerate(value or ()):
                    yield from ("", f"[[{inside}]]")
                    yield from self._keys(inside, kind.record, row, comments=i == 0)
                    yield from self._inner(inside, kind.record, row)

    def _note(self, table: str, key: str, kind: Kind) -> str:
        """Return the comment on a key: unit, law and meaning."""
        unit, limits, meaning, _ = kind.form
        law = law_of(table, key, kind)
        words = f"{unit}, {formula(law.power)}" if law.power and self._factor != SAME_SIZE else unit
        reason = f"; {law.reason}" if law.reason and self._factor != SAME_SIZE else ""
        if isinstance(kind, NamedNumbers):
            meaning = kind.each.meaning  # its names stand below
        elif unit == "word":
            meaning = f"{limits}; {meaning}"
        return f"# [{words}] {meaning}{reason}"


def _line(text: str, note: str) -> Iterator[str]:
    """Yield a key with its comment behind it, or above it where the line is too long."""
    if len(text) + len(note) + 3 > MAX_LINE_COLUMNS:
        yield from wrap(note, MAX_LINE_COLUMNS, subsequent_indent="# ", break_on_hyphens=False)
        yield from filter(None, (text,))
    else:
        yield f"{text}   {note}".strip()


def scaled_vessel(given: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """Return the tables of a boat ``factor`` times as long [-], by Froude's law.

    Keys for the reader are left out, because they describe the source. The start is no deeper than
    the deepest order.
    """
    table: dict[str, Any] = {
        key: value
        for key, value in given.items()
        if key not in (*VESSEL_RECORDS, *DOCUMENTARY_TABLES)
    }
    for name, record in VESSEL_RECORDS.items():
        if name in given:
            table[name] = scaled_table(record, given[name], name, factor)
    deepest = [table["vessel"][key] for key in DEPTH_KEYS if key in table["vessel"]]
    if deepest:
        table["run"]["start_depth_m"] = min(table["run"]["start_depth_m"], deepest[0])
    return table


def vessel_text(source: str, length: float | None, name: str | None) -> str:
    """Return the text of a new vessel file. It is ``source`` scaled to a length [m], None: a copy.

    Without a ``name`` it has its source's. ConfigError if there is no such boat.
    """
    path = path_named(source, "vessels")
    text = read_text(path)
    file = parse_vessel(text, path)
    content = parse_toml(text, path.name)
    table, _ = with_defaults(content)
    for table_name in (
        "compact",
        "compensation",
    ):  # a set that the source lacks is none of the copy's
        if table_name not in content:
            table.pop(table_name, None)
    factor = SAME_SIZE if length is None else length / file.hull.length
    if factor != SAME_SIZE:
        table = scaled_vessel(table, factor)
        table["vessel"]["length"] = length
        table["scale"] = "full"
        table["source"] = {
            "scaled_from": f"{path.name}: {file.name}, {file.hull.length:g} m",
            "law": "Froude's similarity, docs/vessel-files.md",
        }
    table["name"] = name or file.name
    return "\n".join((*_opening(path, file.hull.length, length), *_body(table, factor))) + "\n"


def _opening(path: Path, source: float, length: float | None) -> Iterator[str]:
    """Yield the comment at the top; lengths in [m]."""
    if length is None or length == source:
        yield f"# A copy of {path.name} by `trainer boat new`: each key with unit and meaning."
    else:
        yield f"# {path.name} scaled from {source:g} m to {length:g} m by `trainer boat new`."
        yield LAWS_NOTE
    yield f"# The comments of {path.name} say where the source's numbers are from."
    yield "# A line that begins with # and a key shows what may be said besides."
    yield "# Next: trainer boat check FILE; trainer run --vessel FILE"


def _body(table: Mapping[str, Any], factor: float) -> Iterator[str]:
    """Yield the file below its first comment."""
    writer = TemplateWriter(factor)
    yield f"schema = {toml_value('gertler-hagen-2510/1')}"
    yield from (f"{key} = {toml_value(table[key])}" for key in HEADING_FIELDS if key in table)
    for name in DOCUMENTARY_TABLES:
        if name in table:
            yield from ("", f"[{name}]   # for the reader")
            yield from (f"{format_key(k)} = {toml_value(v)}" for k, v in table[name].items())
    for name, record in VESSEL_RECORDS.items():
        if name in table:
            yield from writer.table(name, record, table[name])
        elif name in OPTIONAL_TABLES:
            summary = (record.__doc__ or "").partition("\n")[0]
            yield from ("", f"# [{name}]   # the source has none. {summary}")
    yield from _compensation(table)
    yield from _coefficients(table["coefficients"])


def _compensation(table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the factors of the compact sets, if the file has its own."""
    for name, factors in table.get("compensation", {}).items():
        yield from ("", f"[compensation.{name}]   # [-] factors on what the set keeps; 0: dropped")
        yield from (f"{key} = {toml_value(each)}" for key, each in factors.items())


def _coefficients(given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the coefficients by axis, each with what it multiplies."""
    flat: dict[str, Any] = {}
    for key, value in given.items():
        flat |= value if isinstance(value, Mapping) else {key: value}
    for axis in FORCE_AXES:
        terms = [term for term in COEFFICIENTS if term.equation == axis]
        yield from ("", f"[coefficients.{axis}]   # {PRIME_NOTE}")
        for term in terms:
            if term.key in flat:
                note = f"# L^{term.power}: {term.multiplies}"
                yield from _line(f"{term.key} = {toml_value(flat[term.key])}", note)
        absent = [term.key for term in terms if term.key not in flat]
        if absent:
            yield from _line("", f"# absent: {', '.join(absent)}")


def write_new(path: Path, source: str, length: float | None, name: str | None) -> str:
    """Write a new vessel file; return what to type next.

    ConfigError if the file is there, or the boat would be refused.
    """
    text = vessel_text(source, length, name or (path.stem if length else None))
    parse_vessel(text, path)
    write_once(path, text)
    return f"{path} written; next: trainer boat check {as_typed(path)}"
