"""``python -m tests.fuzz`` throws inputs made to break it at every reader."""

import sys
from pathlib import Path
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from helpers.progress import Bar, as_json

from fuzz.catalogue import choose_targets
from fuzz.fuzz import Effort, Found
from fuzz.fuzz import fuzz as fuzz_all
from trainer.cli.main import run_command
from trainer.cli.options import ANY_FILE

HEAD: Final = f"{'target':12}{'inputs':>12}{'paths':>7}{'kept':>7}{'seconds':>9}  verdict"


@click.command()
@click.argument("targets", nargs=-1, metavar="[TARGET]...")
@click.option(
    "--inputs",
    type=click.IntRange(1),
    default=1_000_000,
    show_default=True,
    help="For each target, those that this corpus has had before counted in.",
)
@click.option(
    "--seconds", type=click.IntRange(0), default=0, help="At most, for each. [default: no end]"
)
@click.option(
    "--corpus",
    type=ANY_FILE,
    default=Path("fuzz-corpus"),
    show_default=True,
    help="Folder of inputs worth keeping: begun from, and added to.",
)
@click.option("--jobs", type=click.IntRange(1, 64), default=1, show_default=True, help="At a time.")
@click.option("--seed", type=click.IntRange(1, 2**31 - 1), default=1, show_default=True)
@click.option("--list", "listed", is_flag=True, help="List the targets and leave.")
@click.option("--json", "json", is_flag=True, help="Print the findings as JSON.")
def fuzz(
    *,
    targets: tuple[str, ...],
    corpus: Path,
    jobs: int,
    listed: bool,
    json: bool,
    **effort: int,
) -> None:
    """Throw inputs made to break it at every reader of what others write.

    \b
    Example:  python -m tests.fuzz --list
              python -m tests.fuzz orders station --inputs 100000

    Needs atheris, of the dependency group `fuzz`. Exit codes: 0 nothing but declared errors,
    1 a reader failed: the input is saved, and given on to the next run.
    """
    wanted = choose_targets(targets)
    if listed:
        click.echo("\n".join(f"{target.name:12}{target.says}" for target in wanted))
        return
    with Bar("fuzzing", effort["inputs"] * len(wanted)) as bar:
        findings = list(fuzz_all(wanted, corpus, Effort(**effort), jobs, bar.at))
    click.echo(as_json(findings) if json else "\n".join([HEAD, *map(row, findings)]))
    sys.exit(1 if any(target.failure for target in findings) else 0)


def row(found: Found) -> str:
    """Return what came of a target, under ``HEAD``, and its failure in full."""
    counts = f"{found.inputs:>12,}{found.paths:>7}{found.kept:>7}{found.seconds:>9.0f}"
    verdict = "FAILED" if found.failure else "no exception but the declared"
    line = f"{found.target:12}{counts}  {verdict}"
    if not found.failure:
        return line
    return f"{line}\n{found.saved or 'no input saved'}\n{found.failure}"


if __name__ == "__main__":
    run_command(fuzz, "python -m tests.fuzz")
