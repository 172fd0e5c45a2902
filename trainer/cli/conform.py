"""The command ``conform`` prints what STCW asks of a simulator, and what is here."""

from dataclasses import asdict

import click

from trainer.cli.answers import json_of


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print the lines as JSON.")
def conform(*, as_json: bool) -> None:
    """Print what STCW asks of a simulator, line by line, and what is here.

    Sections A-I/12 and B-I/12 of the code, in our own words. Self-declared, not certified.

    \b
    Example:  trainer dev conform
              trainer dev conform --json
    """
    from trainer.config.exercise.conformity import (
        CLOSING_DECLARATION,
        LINE_STATES,
        UNREAD_MARK,
        load_conformity,
    )
    from trainer.report.text import wrap

    lines = load_conformity()
    if as_json:
        click.echo(json_of([asdict(line) for line in lines]))
        return
    for line in lines:
        section = line.section if line.read else f"{line.section} ({UNREAD_MARK})"
        click.echo("\n".join(wrap(f"{section}  {line.state.upper()}: {line.asks}", "", "  ")))
        more = [line.how, line.lacks and f"Lacks: {line.lacks}", line.test and f"Test: {line.test}"]
        click.echo("\n".join(text for each in more if each for text in wrap(each)))
    counts = ", ".join(
        f"{sum(line.state == each for line in lines)} {each}" for each in LINE_STATES
    )
    click.echo(f"\n{len(lines)} lines: {counts}. {CLOSING_DECLARATION}")
