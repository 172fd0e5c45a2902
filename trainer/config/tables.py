"""CSV files as other programs write them: separators, decimal signs, units, times.

Records for identification and runs of ``trainer report-1969`` are read by it. What a cell means is
decided by its whole column, because one cell alone is ambiguous: 1,234 is two numbers.
"""

import csv
import math
import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, time
from itertools import islice, pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError, nearest, quote
from trainer.config.units import KNOWN_UNITS, spell_unit
from trainer.io.outputs import note_input

Numbers = NDArray[np.float64]
EMPTY_CELLS: Final = ("", "nan", "na", "null", "-")
# Separators that no number has come first: of two that fit equally, the first is taken.
COLUMN_SEPARATORS: Final = {"\t": "tabs", ";": '";"', ",": '","'}
HEADINGS_EXAMPLE: Final = "such as t, rudder, heading"
SEPARATOR_ROWS: Final = 40  # [rows] that tell the separator
MAX_NUMBER: Final = 1e15  # of a number; what is beyond it is none that was measured
MOST_SHARED: Final = 100_000  # cells that are looked for among those before
DAY_S: Final = 86400.0  # [s]
EVEN_STEP_TOLERANCE: Final = 1e-3  # [-] of an interval: what differs less is at one interval
MIN_CLOCK_ROWS: Final = 20  # rows, to judge a clock
MIN_REPEATS: Final = 3  # [times] that must repeat before a clock counts as rounded
MIN_REPEATED_SHARE: Final = 0.02  # [-] of all times, likewise
CLOCK_SLACK: Final = 0.6  # [-] of what a clock is rounded to, that a time may be off
DECIMAL_COMMA: Final = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")  # a number with a decimal comma
DECIMAL_POINT: Final = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")
GROUPED_NUMBER: Final = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")  # or three decimals
UNGROUPED_NUMBER: Final = re.compile(
    r"[+-]?(?:\d{4,}(?:[.,]\d+)?|\d*[.,](?:\d\d?|\d{4,})|0*[.,]\d+)"
)
LINE: Final = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+\Z")
COMMENT_LINE: Final = re.compile(r"(?:^|[\r\n])[^\S\r\n]*(?:#|%|//)")
COMMENT_MARK: Final = re.compile(r"\s*(?:#|%|//)")  # of a line
SEPARATOR_LINE: Final = re.compile(r"sep=([,;\t])[ \t]*(?=[\r\n])", re.IGNORECASE)  # Excel's
UTC_ENDING: Final = re.compile(r"\s*(?:UTC|GMT)$", re.IGNORECASE)
UNIT_IN_BRACKETS: Final = re.compile(
    r"(.*\S)\s*(?:\[(.*)\]|\((.*)\))"
)  # rudder [deg], rudder (deg)
ANGLE_PATTERN: Final = re.compile(  # 54.5, 54 30.0, 54-30.0 N, N54\u00b030'00\", 5430.0 of ddmm
    r"([NSEW]?)\s*([+-]?\d+(?:[.,]\d*)?)\s*(?:[\u00b0\s-]\s*(\d+(?:[.,]\d*)?)\s*['\u2032]?"
    r"\s*(?:(\d+(?:[.,]\d*)?)\s*[\"\u2033])?)?\s*\u00b0?\s*([NSEW]?)",
    re.IGNORECASE,
)
Rows = list[tuple[int, list[str]]]


@dataclass(frozen=True)
class CsvTable:
    """The cells of a CSV file below its heading; ``lines`` as people count."""

    path: Path
    heads: tuple[str, ...]
    units: tuple[str, ...]  # as ``spell_unit``, "" where the file says none; known or not
    lines: Sequence[int]
    cells: Sequence[Sequence[str]]
    told: tuple[str, ...]  # how it was read, where that had to be guessed

    @property
    def names(self) -> tuple[str, ...]:
        """Return the headings without known units, if they still differ without them."""
        parted = zip(self.heads, map(part_heading, self.heads), strict=True)
        bare = [name if unit in KNOWN_UNITS else head for head, (name, unit) in parted]
        return tuple(
            short if bare.count(short) == 1 else head
            for short, head in zip(bare, self.heads, strict=True)
        )

    def has(self, name: str) -> bool:
        """Return whether there is a column of that heading, with its unit or without."""
        return name in self.heads or name in self.names

    def index(self, name: str, use: str = "") -> int:
        """Return the index of a column; ConfigError with the nearest name if there is none."""
        for names in (self.heads, self.names):
            if name in names:
                return names.index(name)
        wanted = f" for {use}" if use else ""
        raise ConfigError(
            f"{self.path}: no column {quote(name)}{wanted}{nearest(name, self.names)}; "
            f"it has {', '.join(self.names)}"
        )

    def texts(self, index: int) -> list[str]:
        """Return the cells of a column."""
        return [row[index] for row in self.cells]

    def numbers(self, index: int) -> Numbers:
        """Return a column, NaN where it is empty. ConfigError naming the row of what is none."""
        texts = self.texts(index)
        try:
            numbers = np.array(texts, str).astype(float)
        except ValueError:  # empty cells, or one that is no number
            numbers = np.array([math.inf])
        if (np.abs(numbers) <= MAX_NUMBER).all():
            return numbers
        return np.array([self.number(row, index, text) for row, text in enumerate(texts)], float)

    def known(self, index: int) -> Numbers:
        """Return a column whose cells are all numbers; ConfigError naming the row of one not."""
        numbers = self.numbers(index)
        if (missing := np.isnan(numbers)).any():
            raise self.wrong(int(np.argmax(missing)), index, "must be a number")
        return numbers

    def number(self, row: int, index: int, text: str) -> float:
        """Return what one cell says, NaN if it is empty. ConfigError if it is no number."""
        try:
            number = float(text)
        except ValueError:
            # Infinity is beyond MAX_NUMBER, so that a text that is no number is refused below.
            number = math.nan if text.casefold() in EMPTY_CELLS else math.inf
        if abs(number) > MAX_NUMBER:
            left, _, right = text.replace(" ", "").rpartition(",")
            readings = f"is it {left}{right} or {left}.{right}? " if left.isdigit() else ""
            remedy = f": {readings}write it without a sign between thousands" if left else ""
            if ":" in text:
                remedy = ", or a time such as 2026-11-28T08:00:00, 2026-11-28 08:00:00 or 08:00:00"
            raise self.wrong(row, index, f"must be a number, or empty{remedy}")
        return number

    def angles(self, index: int, unit: str) -> Numbers:
        """Return latitudes or longitudes in degrees, in radians if ``unit`` is rad; ConfigError.

        A cell is a number, degrees and minutes together if ``unit`` is ddmm, or degrees with
        minutes and seconds, and N, S, E or W.
        """
        rows = range(len(self.cells))
        return np.array([self._angle(row, index, unit) for row in rows], float)

    def _angle(self, row: int, index: int, unit: str) -> float:
        """Return the angle of one cell; NaN if it is empty. ConfigError if it is none."""
        text = self.cells[row][index]
        match = ANGLE_PATTERN.fullmatch(text)
        if match is None or (unit == "ddmm" and "," in text and GROUPED_NUMBER.match(text)):
            return self.number(row, index, text)
        before, whole, *parts, after = match.groups()
        size, minutes, seconds = (float((x or "0").replace(",", ".")) for x in (whole, *parts))
        size = abs(size)
        if unit == "ddmm" and not any(parts):
            size, minutes = size // 100.0, size % 100.0
        limit = math.pi if unit == "rad" else 180.0
        size += (minutes + seconds / 60.0) / 60.0
        if minutes >= 60.0 or size > limit:
            remedy = 'unit = "ddmm" is degrees and minutes' if unit == "deg" else f"is it {unit}?"
            remedy += f"; where it stands for no reading say missing = [{whole}]"
            raise self.wrong(row, index, f"must be at most {limit:.4g}, minutes below 60; {remedy}")
        half = (before or after).upper()
        return -size if half in ("S", "W") or (not half and whole.startswith("-")) else size

    def without(self, index: int, codes: Collection[float]) -> "CsvTable":
        """Return the table with a column's cells that say one of these numbers empty."""
        absent = [_is_number(text) and float(text) in codes for text in self.texts(index)]
        pairs = zip(self.cells, absent, strict=True)
        cells = [[*row[:index], "", *row[index + 1 :]] if no else row for row, no in pairs]
        return replace(self, cells=cells)

    @property
    def repeats(self) -> NDArray[np.bool_]:
        """Return for each row whether it repeats the one before it."""
        same = [row == before for before, row in pairwise(self.cells)]
        return np.array([False, *same])

    def is_clock(self, index: int) -> bool:
        """Return whether a column has dates or times of day, not numbers."""
        first = next((text for text in self.texts(index) if text.casefold() not in EMPTY_CELLS), "")
        return _moment(first) is not None and not _is_number(first)

    def seconds(self, index: int) -> Numbers:
        """Return ISO 8601 times from the first one [s], beyond midnight too. ConfigError."""
        moments = []
        for row, text in enumerate(self.texts(index)):
            moment = _moment(text)
            if moment is None:
                raise self.wrong(row, index, "must be a time by ISO 8601, as the first is")
            moments.append(moment)
        since = np.array([(moment - moments[0]).total_seconds() for moment in moments])
        # Times without dates begin like 23: or 9:, and go back by a day at midnight.
        if ":" in self.cells[0][index][:3]:
            since = np.unwrap(since, period=DAY_S)
        return since

    def wrong(self, row: int, index: int, text: str) -> ConfigError:
        """Return what is wrong with a cell."""
        name, cell = self.names[index], quote(self.cells[row][index])
        return ConfigError(f"{self.path}: row {self.lines[row]}: {name} = {cell}: {text}")


def read_table(path: Path) -> CsvTable:
    """Return the table in a CSV file. ConfigError naming row and column of what is wrong."""
    text, remarks = _decoded(path)
    said = SEPARATOR_LINE.match(text)
    text = _without_comments(text[said.end() if said else 0 :], remarks)
    separator = said[1] if said else _separator(text)
    if separator != ",":
        remarks.append(f"columns by {COLUMN_SEPARATORS[separator]}")
    try:
        lines = csv.reader(_lines(text), delimiter=separator)
        heads = tuple(name.strip() for name in next(filter(None, lines), []))
        rows, same = list[tuple[int, list[str]]](), dict[str, str]()
        for row in filter(None, lines):
            # a cell that stands in many rows is one text
            cells = [same.setdefault(cell, cell) for cell in map(str.strip, row)]
            rows.append((lines.line_num, cells))
            if len(same) > MOST_SHARED:
                same.clear()
    except csv.Error as error:
        raise ConfigError(f"{path}: is not a CSV text: {error}") from error
    _check_heading(path, heads, text)
    del text, lines  # of a long record they are as large as its numbers
    size = max(_bare_size(heads), max((_bare_size(row) for _, row in rows), default=0))
    heads = heads[:size]
    for _, row in rows:  # a line may end in separators
        del row[size:]
    twice = [name for name in dict.fromkeys(heads) if name and heads.count(name) > 1]
    if twice:
        raise ConfigError(f"{path}: column {quote(twice[0])} is given twice")
    # take empty rows off the end
    count = len(rows)
    while rows and not any(rows[-1][1]):
        rows.pop()
    if len(rows) < count:
        remarks.append(f"{count - len(rows)} empty last rows left out")
    _check_fields(path, heads, rows, separator)
    units = _units(heads, rows, remarks)
    if separator != ",":
        _check_thousands(path, heads, rows)
        _mend_commas(path, heads, rows, remarks)
    return CsvTable(
        path, heads, units, [n for n, _ in rows], [row for _, row in rows], tuple(remarks)
    )


def _lines(text: str) -> Iterator[str]:
    """Yield the lines of a text with their ends, without a copy of it."""
    return (line[0] for line in LINE.finditer(text))


def _without_comments(text: str, told: list[str]) -> str:
    """Return a text, its lines of comment empty; one just above numbers is their heading."""
    marked = any(mark in text for mark in ("#", "%", "//"))
    if not marked or not COMMENT_LINE.search(text):
        return text
    lines = [*_lines(text)]
    marks = {i for i, line in enumerate(lines) if COMMENT_MARK.match(line)}
    first = next((i for i, line in enumerate(lines) if line.strip() and i not in marks), 0)
    if marks and any(_is_value(cell.strip()) for cell in re.split("[\t;,]", lines[first])):
        marks.discard(first - 1)
    for i in marks:
        lines[i] = "\n"
    told += [f"{len(marks)} lines of comment left out"] if marks else []
    return "".join(lines)


def _bare_size(cells: Sequence[str]) -> int:
    """Return how many cells there are without the empty last ones."""
    if cells and cells[-1].strip():
        return len(cells)
    return next((i for i in range(len(cells), 0, -1) if cells[i - 1].strip()), 0)


def _decoded(path: Path) -> tuple[str, list[str]]:
    """Return the text of a file, and its encoding if that is not UTF-8. ConfigError."""
    try:
        note_input(path)
        data = path.read_bytes()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        return data.decode("utf-16" if wide else "utf-8-sig"), ["UTF-16"] if wide else []
    except UnicodeDecodeError as error:
        if wide or b"\0" in data:
            raise ConfigError(f"{path}: is not a CSV text: {error}") from error
    return data.decode("cp1252", errors="replace"), ["letters of Windows"]


def _separator(text: str) -> str:
    """Return the separator that gives most rows as many fields as the heading."""

    def agreeing(separator: str) -> int:
        try:
            rows = csv.reader(_lines(text), delimiter=separator)
            first = [row for _, row in zip(range(SEPARATOR_ROWS), rows, strict=False) if row]
        except csv.Error:
            return 0
        size = _bare_size(first[0]) if first else 0
        return sum(_bare_size(row) <= size <= len(row) for row in first) if size > 1 else 0

    best = max(COLUMN_SEPARATORS, key=agreeing)
    return best if agreeing(best) > 1 else ","


def _check_heading(path: Path, heads: Sequence[str], text: str) -> None:
    """Check that the first line can be the headings of columns; ConfigError if it is none."""
    if not heads:
        raise ConfigError(f"{path}: is empty; headings of columns belong there, {HEADINGS_EXAMPLE}")
    first = next((n for n, line in enumerate(_lines(text), 1) if line.strip()), 1)
    if len(heads) > 1 and all(map(_is_number, heads)):
        raise ConfigError(
            f"{path}: line {first}: numbers; the headings of columns belong there, "
            f"{HEADINGS_EXAMPLE}"
        )
    if len(heads) == 1 and heads[0].count("|"):
        raise ConfigError(f'{path}: "|" parts columns: write commas, semicolons or tabs instead')
    beyond = [*islice(_lines(text), first, first + SEPARATOR_ROWS)]
    for separator in COLUMN_SEPARATORS.keys() - {","}:  # which numbers may have within
        sizes = Counter(line.count(separator) + 1 for line in beyond if line.strip())
        size, count = sizes.most_common(1)[0] if sizes else (1, 0)
        if len(heads) == 1 and size > 1 and 2 * count > sizes.total():
            raise ConfigError(
                f"{path}: line {first}: one heading, and rows of {size} columns: write the "
                f"headings of all columns there, {HEADINGS_EXAMPLE}, and leave out other text"
            )


def _check_fields(path: Path, heads: Sequence[str], rows: Rows, separator: str) -> None:
    """Check that each row has as many fields as the heading; ConfigError with the first."""
    wrong = [(line, len(row)) for line, row in rows if len(row) != len(heads)]
    if not wrong:
        return
    line, size = wrong[0]
    remedy = ""
    if separator == "," and 2 * len(wrong) > len(rows) and all(n > len(heads) for _, n in wrong):
        remedy = (
            ': is "," both between columns and within numbers? '
            'write ";" between columns, or decimal points'
        )
    elif line == rows[-1][0] and size < len(heads):
        remedy = ": the last line is cut short: take it out"
    raise ConfigError(f"{path}: row {line}: has {size} fields, the heading {len(heads)}{remedy}")


def part_heading(head: str) -> tuple[str, str]:
    """Return a heading without brackets, and what stands in them, "" if it has none."""
    match = UNIT_IN_BRACKETS.fullmatch(head)
    return (match[1], spell_unit(match[2] or match[3] or "")) if match else (head, "")


def _units(heads: Sequence[str], rows: Rows, told: list[str]) -> tuple[str, ...]:
    """Return the units by column. Take off a row of units under the heading."""
    units = [part_heading(head)[1] for head in heads]
    if not KNOWN_UNITS.isdisjoint(units):
        told.append("units of the heading")
    cells = rows[0][1] if rows else []
    named = {spell_unit(cell) for cell in cells if cell.casefold() not in EMPTY_CELLS}
    if not KNOWN_UNITS.isdisjoint(named) and not any(map(_is_value, cells)):
        told.append(f"units of row {rows[0][0]}")
        units = [spell_unit(cell) or unit for cell, unit in zip(cells, units, strict=True)]
        del rows[0]
    return tuple(units)


def _is_value(cell: str) -> bool:
    return _is_number(cell) or bool(DECIMAL_COMMA.fullmatch(cell)) or _moment(cell) is not None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _moment(text: str) -> datetime | None:
    """Return a date with a time, or a time of day, by ISO 8601; None if it is neither."""
    text = UTC_ENDING.sub("Z", text)
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        try:
            moment = datetime.combine(datetime(1, 1, 2, tzinfo=UTC), time.fromisoformat(text))
        except ValueError:
            return None
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)


def _check_thousands(path: Path, heads: Sequence[str], rows: Rows) -> None:
    """Check that signs within numbers are decimal ones; ConfigError with both readings."""
    # three decimals beside whole numbers: programs print all alike, or cut zeros off the end
    for index, head in enumerate(heads):
        cells = [(line, row[index]) for line, row in rows]
        groups = [one for one in cells if GROUPED_NUMBER.fullmatch(one[1])]
        rounded = any(text.endswith("0") for _, text in groups)
        wholes = [
            (n, x) for n, x in cells if x.lstrip("+-").isdecimal() and (rounded or x.strip("+-0"))
        ]
        if groups and wholes and not any(UNGROUPED_NUMBER.fullmatch(text) for _, text in cells):
            (line, text), (at, whole) = groups[0], wholes[0]
            readings = f"is it {re.sub('[.,]', '', text)} or {text.replace(',', '.')}?"
            raise ConfigError(
                f"{path}: row {line}: {head} = {quote(text)}, row {at}: {quote(whole)}: {readings} "
                "write the column without a sign between thousands, or all with as many decimals"
            )


def _mend_commas(path: Path, heads: Sequence[str], rows: Rows, told: list[str]) -> None:
    """Write decimal points for decimal commas. ConfigError if there are both."""
    example = _first_like(DECIMAL_COMMA, rows)
    if example is None:
        return
    other = _first_like(DECIMAL_POINT, rows)
    if other is not None:
        (line, i, text), (at, j, number) = example, other
        raise ConfigError(
            f"{path}: row {line}: {heads[i]} = {quote(text)}, row {at}: {heads[j]} = "
            f"{quote(number)}: decimal commas and decimal points: write all numbers one way"
        )
    told.append("decimal commas")
    for _, row in rows:
        row[:] = [cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell for cell in row]


def _first_like(pattern: re.Pattern[str], rows: Rows) -> tuple[int, int, str] | None:
    """Return line, index and text of the first cell like a pattern; None if there is none."""

    def cells() -> Iterator[tuple[int, int, str]]:
        for line, row in rows:
            for index, cell in enumerate(row):
                if pattern.fullmatch(cell):
                    yield line, index, cell

    return next(cells(), None)


def rebuild_times(t: Numbers, same: NDArray[np.bool_]) -> tuple[Numbers, str]:
    """Return even times [s] in place of those of a rounded clock, and a remark.

    Other times come back as they are, with "". An even time differs from the clock by about half of
    its last printed step at most. ``same`` marks the rows that repeat the one before them: a time
    that repeats in such rows only is a repeated record, not a rounded clock.
    """
    steps = np.diff(t)
    rises = len(t) >= MIN_CLOCK_ROWS and bool(np.isfinite(t).all() and (steps >= 0.0).all())
    if not rises or np.ptp(steps) <= EVEN_STEP_TOLERANCE * np.mean(steps):
        return t, ""
    repeated = np.append(False, steps == 0.0)
    count = np.count_nonzero(repeated)
    if 0 < count < max(MIN_REPEATS, MIN_REPEATED_SHARE * len(t)) or (
        count and same[repeated].all()
    ):
        return t, ""
    for printed in _resolutions(t, repeats=bool(count)):
        slope, start = np.polyfit(np.arange(len(t)), t, 1, w=1.0 / printed)
        even = start + slope * np.arange(len(t))
        if (np.abs(t - even) <= CLOCK_SLACK * printed).all():
            return even, f"rounded times, {count} of them repeated: rebuilt every {slope:.6g} s"
    return t, ""


def _resolutions(t: Numbers, *, repeats: bool) -> Iterator[Numbers]:
    """Yield the steps that a clock may be rounded to at each row.

    First it is one step for all rows, then a number of digits, as a program prints floats: a step
    that grows with the time.
    """
    steps = np.diff(t)
    digits = [np.format_float_scientific(x, unique=True, trim="-") for x in np.round(t, 9)]
    counts = [len(text.partition("e")[0].replace(".", "").lstrip("-")) for text in digits]
    powers = np.floor(np.log10(np.maximum(np.abs(t), 1e-9)))
    finest = 10.0 ** float(np.min(powers + 1 - np.array(counts), where=t != 0.0, initial=9))
    yield np.full_like(t, steps[steps > 0.0].min() if repeats else finest)
    yield np.maximum(10.0 ** (powers + 1 - max(counts)), finest)
