"""Text for a terminal, 79 columns of ASCII: paragraphs, numbers and tables.

Every program's page is made with it. 79 columns of ASCII fit any terminal and printer, and two
pages can be compared line by line.
"""

import textwrap
from collections.abc import Iterable, Sequence
from typing import Final

PAGE_WIDTH: Final = 79  # [columns]
INDENT: Final = "  "


def ascii_text(text: str) -> str:
    """Return ``text`` in ASCII."""
    return text.encode("ascii", "replace").decode()


def wrap(text: str, first: str = INDENT, rest: str = 2 * INDENT) -> list[str]:
    """Return ``text`` in lines of the page."""
    return textwrap.wrap(ascii_text(text), PAGE_WIDTH, initial_indent=first, subsequent_indent=rest)


def items(texts: Iterable[str]) -> list[str]:
    """Return a list of texts in lines of the page, each after a dash."""
    return [line for text in texts for line in wrap(f"- {text}")]


def format_number(number: float | None, form: str = ".3f") -> str:
    """Return ``number`` as text, '-' for none."""
    return "-" if number is None else format(number, form)


def cut_text(text: str, width: int) -> str:
    """Return ``text`` in ``width`` characters of ASCII; its end if not all of it fits."""
    text = ascii_text(text)
    return text if len(text) <= width else "..." + text[3 - width :]


def root_text(real: float, imaginary: float) -> str:
    """Return a root [1/s], or a pair of roots, as text."""
    return f"{real:+.5f}" + (f" +-{imaginary:.5f}i" if imaginary else "")


def titled_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return a table under a title, a blank line before."""
    return ["", title, *table(heads, rows)]


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], indent: str = INDENT) -> list[str]:
    """Return a table. The first column is to the left, the others to the right, two spaces between.

    A head may be of two lines with a newline between.
    """
    lines = [ascii_text(head).split("\n") for head in heads]
    deep = max(map(len, lines))
    top = [[*[""] * (deep - len(cell)), *cell] for cell in lines]
    cells = [*([cell[i] for cell in top] for i in range(deep)), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heads))]
    return [
        (
            indent
            + "  ".join(
                cell.rjust(width) if i else cell.ljust(width)
                for i, (cell, width) in enumerate(zip(row, widths, strict=True))
            )
        ).rstrip()
        for row in cells
    ]
