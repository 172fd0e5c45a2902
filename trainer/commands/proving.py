"""Proofs that anybody can run; they take minutes to hours."""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.commands.options import FILE


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
    type=FILE,
    default=Path("fuzz-corpus"),
    show_default=True,
    help="Folder of inputs worth keeping: begun from, and added to.",
)
@click.option("--jobs", type=click.IntRange(1, 64), default=1, show_default=True, help="At a time.")
@click.option("--seed", type=click.IntRange(1, 2**31 - 1), default=1, show_default=True)
@click.option("--list", "listed", is_flag=True, help="List the targets and leave.")
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
def fuzz(
    *,
    targets: tuple[str, ...],
    corpus: Path,
    jobs: int,
    listed: bool,
    as_json: bool,
    **effort: int,
) -> None:
    """Throw inputs made to break it at every reader of what others write.

    \b
    Example:  trainer fuzz --list
              trainer fuzz orders station --inputs 100000

    Needs the extra `fuzz`. Exit codes: 0 nothing but declared errors, 1 a reader failed: the input
    is saved, and given on to the next run.
    """
    from trainer.proving import page  # noqa: PLC0415
    from trainer.proving.catalogue import chosen  # noqa: PLC0415
    from trainer.proving.fuzz import Effort  # noqa: PLC0415
    from trainer.proving.fuzz import fuzz as fuzz_all  # noqa: PLC0415
    from trainer.proving.progress import Bar  # noqa: PLC0415

    wanted = chosen(targets)
    if listed:
        click.echo("\n".join(f"{target.name:12}{target.says}" for target in wanted))
        return
    with Bar("fuzzing", effort["inputs"] * len(wanted)) as bar:
        found = list(fuzz_all(wanted, corpus, Effort(**effort), jobs, bar.at))
    click.echo(page.as_json(found) if as_json else page.fuzz_page(found))
    sys.exit(1 if any(each.failure for each in found) else 0)


@click.command()
@click.option(
    "--hours",
    type=click.FloatRange(0.01, 1000.0),
    default=24.0,
    show_default=True,
    help="Of exercise time, at full speed.",
)
@click.option("--real-time", is_flag=True, help="By the clock instead, for --minutes.")
@click.option(
    "--minutes",
    type=click.FloatRange(0.1, 10_000.0),
    default=30.0,
    show_default=True,
    help="Of the clock, with --real-time.",
)
@click.option("--seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True)
@click.option("--keep", type=FILE, default=None, help="Keep the recording in this file.")
@click.option(
    "--faults",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Instead kill N sessions, and try every other fault in proportion.",
)
@click.option(
    "--damaged",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Instead damage N recordings, and let every command open them.",
)
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
def soak(*, real_time: bool, seed: int, as_json: bool, **how: Any) -> None:
    """Keep a session under random orders, seas, casualties and visitors, and see what it promises.

    \b
    Example:  trainer soak
              trainer soak --real-time --minutes 30
              trainer soak --faults 100
              trainer soak --damaged 2000

    Exit codes: 0 every promise kept, 1 one is broken.
    """
    from trainer.proving.progress import Bar  # noqa: PLC0415
    from trainer.proving.soak import Plan, page  # noqa: PLC0415
    from trainer.proving.soak import as_json as text_of  # noqa: PLC0415
    from trainer.proving.soak import soak as soak_session  # noqa: PLC0415

    for name in ("faults", "damaged"):
        if how[name]:
            sys.exit(try_faults(name, how[name], seed, as_json=as_json))
    plan = Plan(60.0 * how["minutes"] if real_time else 3600.0 * how["hours"], real_time, seed)
    with Bar("soaking", plan.ticks) as bar:
        found = soak_session(plan, how["keep"], bar.at)
    click.echo(text_of(found) if as_json else page(found))
    sys.exit(0 if found.kept else 1)


def try_faults(what: str, times: int, seed: int, *, as_json: bool) -> int:
    """Try every fault, or damage, and print what came of it; return the exit code."""
    from trainer.proving.damage import try_damage  # noqa: PLC0415
    from trainer.proving.faults import HEAD, told, try_all  # noqa: PLC0415
    from trainer.proving.page import as_json as text_of  # noqa: PLC0415

    found = []
    if not as_json:
        click.echo(HEAD)
    tries = {"faults": try_all, "damaged": try_damage}[what](times, seed)
    for tried in tries:  # hours: each is told when it is known
        found.append(tried)
        if not as_json:
            click.echo(told(tried))
    if as_json:
        click.echo(text_of(found))
    return 1 if any(tried.wrong for tried in found) else 0
