"""The page docs/conformity.md, made of configs/conformity.toml.

    python -m helpers.conformity > ../docs/conformity.md

in the folder of the tests writes it; a test compares them, and looks every test up.
"""

from trainer.config.exercise.conformity import (
    CLOSING_DECLARATION,
    LINE_STATES,
    UNREAD_MARK,
    ConformityLine,
    load_conformity,
)

HEAD = """# What STCW asks of a simulator

<!-- Made by tests/helpers/conformity.py of configs/conformity.toml; a test compares them. -->

After this page you know which demands on a ship-handling simulator this trainer meets, which in
part, and which are not for it. **{declaration}** Nobody has approved this trainer for anything.

The lines follow the STCW Code: section A-I/12 (what simulators, training and assessment must do)
and section B-I/12, paragraphs 68 and 69 (navigation and watchkeeping, ship handling). The wording
is ours; for the law read the code. Numbers marked *not checked* are from memory, because we could
not get the text of those paragraphs. We read the others at {read}.

The code is about surface ships. If a demand makes no sense in a dived boat, it is out of scope, and
the table gives the reason. If the state is *has*, the table names the test that shows it; another
test makes sure that this test exists.

```sh
trainer dev conform
```

{counts}.

"""
COLUMNS = (
    "section",
    "it asks that it",
    "state",
    "what there is",
    "what lacks",
    "test below tests/",
)


def row_of(line: ConformityLine) -> str:
    """Return a line as a row of the table."""
    how = f"[{line.how}]({line.page})" if line.page else line.how
    test = f"`{line.test}`" if line.test else ""
    section = line.section if line.read else f"{line.section} *{UNREAD_MARK}*"
    cells = (section, line.asks, line.state, how, line.lacks or "", test)
    return f"| {' | '.join(cells)} |\n".replace("|  |", "| |").replace("|  |", "| |")


def page() -> str:
    """Return docs/conformity.md."""
    lines = load_conformity()
    counts = ", ".join(
        f"{sum(line.state == each for line in lines)} {each}" for each in LINE_STATES
    )
    head = HEAD.format(
        declaration=CLOSING_DECLARATION,
        counts=f"{len(lines)} lines: {counts}",
        read=", ".join(dict.fromkeys(line.read for line in lines if line.read)),
    )
    heads = f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}\n"
    return head + heads + "".join(map(row_of, lines))


if __name__ == "__main__":
    print(page(), end="")
