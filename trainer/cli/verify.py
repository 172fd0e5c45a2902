"""Commands that prove and measure the trainer; they take minutes to hours."""

import sys
from pathlib import Path
from typing import Any

import click

from trainer.cli.options import FILE, RECORDING, VESSEL, VESSEL_HELP


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
    from trainer.verify import page  # noqa: PLC0415
    from trainer.verify.fuzz.catalogue import choose_targets  # noqa: PLC0415
    from trainer.verify.fuzz.fuzz import Effort  # noqa: PLC0415
    from trainer.verify.fuzz.fuzz import fuzz as fuzz_all  # noqa: PLC0415
    from trainer.verify.page import Bar  # noqa: PLC0415

    wanted = choose_targets(targets)
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
@click.option("--keep", type=RECORDING, default=None, help="Keep the recording in this file.")
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
@click.option(
    "--stress",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Instead give N orders to each boat by each set within --hours.",
)
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
def soak(*, real_time: bool, seed: int, as_json: bool, **how: Any) -> None:
    """Keep a session under random orders, seas, casualties and visitors, and see what it promises.

    \b
    Example:  trainer soak
              trainer soak --real-time --minutes 30
              trainer soak --faults 100
              trainer soak --damaged 2000
              trainer soak --stress 2000 --hours 10

    Exit codes: 0 every promise kept, 1 one is broken.
    """
    from trainer.verify.page import Bar  # noqa: PLC0415
    from trainer.verify.soak.soak import Plan, page  # noqa: PLC0415
    from trainer.verify.soak.soak import as_json as text_of  # noqa: PLC0415
    from trainer.verify.soak.soak import soak as soak_session  # noqa: PLC0415

    for name in ("faults", "damaged"):
        if how[name]:
            sys.exit(try_faults(name, how[name], seed, as_json=as_json))
    if how["stress"]:
        sys.exit(try_stress(how["stress"], how["hours"], seed, as_json=as_json))
    plan = Plan(60.0 * how["minutes"] if real_time else 3600.0 * how["hours"], real_time, seed)
    with Bar("soaking", plan.ticks) as bar:
        found = soak_session(plan, how["keep"], bar.at)
    click.echo(text_of(found) if as_json else page(found))
    sys.exit(0 if found.kept else 1)


def try_stress(orders: int, hours: float, seed: int, *, as_json: bool) -> int:
    """Stress every boat by every set, and print the results. Return the exit code."""
    from trainer.verify.page import as_json as text_of  # noqa: PLC0415
    from trainer.verify.soak.stress import HEAD, row, stress  # noqa: PLC0415

    found = []
    if not as_json:
        click.echo(HEAD)
    for one in stress(orders, hours, seed):
        found.append(one)
        if not as_json:
            click.echo(row(one))
    if as_json:
        click.echo(text_of(found))
    return 0 if all(one.kept for one in found) else 1


def try_faults(what: str, times: int, seed: int, *, as_json: bool) -> int:
    """Try every fault, or damage, and print what came of it; return the exit code."""
    from trainer.verify.faults.faults import HEAD, fault_row, try_all  # noqa: PLC0415
    from trainer.verify.faults.recordings import try_damage  # noqa: PLC0415
    from trainer.verify.page import as_json as text_of  # noqa: PLC0415

    found = []
    if not as_json:
        click.echo(HEAD)
    tries = {"faults": try_all, "damaged": try_damage}[what](times, seed)
    for tried in tries:  # hours: each is told when it is known
        found.append(tried)
        if not as_json:
            click.echo(fault_row(tried))
    if as_json:
        click.echo(text_of(found))
    return 1 if any(tried.wrong for tried in found) else 0


@click.command()
@click.option("--vessel", type=VESSEL, default="bb2", show_default=True, help=VESSEL_HELP)
@click.option(
    "--seconds",
    type=click.IntRange(1, 3600),
    default=None,
    help="Of real time for each step, recorded and not, and for the orders over TCP; --latency "
    "gives four in each. [default: 10; 60 for --web]",
)
@click.option("--against-c", is_flag=True, help="Only the tick against plain C, compiled here.")
@click.option("--side-by-side", is_flag=True, help="Only how fast many boats are flown at once.")
@click.option("--same-bits", is_flag=True, help="Only whether an hour ends in the same bits.")
@click.option("--footprint", is_flag=True, help="Only the words of machine code, beside 1969.")
@click.option("--peers", is_flag=True, help="Only the tick beside JSBSim and scipy.")
@click.option("--exported", is_flag=True, help="Only an hour by the core for WebAssembly.")
@click.option("--on-time", is_flag=True, help="Only how late ticks begin, among busy processes.")
@click.option(
    "--minutes",
    type=click.FloatRange(0.05, 1440.0),
    default=0.25,
    show_default=True,
    help="Of --on-time, for a session among all that could hold it up.",
)
@click.option("--latency", is_flag=True, help="Only how soon an order is seen at an instrument.")
@click.option("--starting", is_flag=True, help="Only how soon commands answer.")
@click.option("--web", is_flag=True, help="Only stations in a browser, and what they cost.")
@click.option("--identify", is_flag=True, help="Only how fast a ship is identified.")
@click.option("--all", "everything", is_flag=True, help="All of it: some minutes.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def bench(
    vessel: str,
    seconds: int | None,
    *,
    minutes: float,
    everything: bool,
    as_json: bool,
    **parts: bool,
) -> None:
    """Measure duty cycle, work per tick, lateness and sizes on this machine.

    \b
    Example:  trainer bench --json
              trainer bench --against-c
              trainer bench --on-time --minutes 10
              trainer bench --web
              trainer bench --all --json > figures.json
    """
    import json  # noqa: PLC0415
    from dataclasses import asdict  # noqa: PLC0415

    from trainer.config.vessel import load_vessel  # noqa: PLC0415

    file = load_vessel(vessel)
    chosen = [name for name, wanted in parts.items() if wanted or everything]
    found, pages = {}, []
    if everything or not chosen:
        from trainer.verify.bench.bench import bench as measure  # noqa: PLC0415
        from trainer.verify.bench.bench import render  # noqa: PLC0415

        figures = measure(file, seconds or 10)
        pages.append(render(figures))
        found["standard"] = asdict(figures)
    if chosen:
        from trainer.verify.bench.sections import SECTIONS, Wanted  # noqa: PLC0415

        for name in chosen:
            answer = SECTIONS[name].measure(Wanted(file, seconds or 10, minutes, seconds or 60))
            pages.append("\n".join(SECTIONS[name].lines(answer)).strip())
            found[name] = asdict(answer)
    tree = found if chosen else found["standard"]
    click.echo(json.dumps(tree, indent=1) if as_json else "\n\n".join(pages))
