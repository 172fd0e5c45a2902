"""``python -m tests.simulation`` plays whole sessions by seeds, and shrinks what breaks a law."""

import concurrent.futures
import functools
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parents[1]))  # packages of tests/ go by their own names

from helpers.progress import Bar

from simulation.chains import compare
from simulation.class_play import play_class
from simulation.lost import find_loss
from simulation.milestones import MILESTONES, SAID_MILESTONES, never_reached, reach_table
from simulation.play import play
from simulation.script import read_script, write_script
from simulation.seeds import Played, breaks_law, explore, play_seed
from simulation.shrink import shrink
from simulation.weights import WEIGHTS_PATH, read_weights, weigh, write_weights
from trainer.cli.main import run_command

SEEDS_AHEAD: Final = 50  # of each process, before the oldest are told


@click.command()
@click.option("--seeds", type=click.IntRange(1), default=100, show_default=True, metavar="N")
@click.option(
    "--from", "first", type=click.IntRange(0), default=1, show_default=True, metavar="SEED"
)
@click.option(
    "--minutes", type=click.FloatRange(0.01), default=None, help="End after so many, at the latest."
)
@click.option(
    "--seconds",
    type=click.FloatRange(1.0),
    default=40.0,
    show_default=True,
    help="That a process lives, at most.",
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, metavar="N")
@click.option(
    "--reached", "table", is_flag=True, help="Print how many seeds reached each milestone."
)
@click.option(
    "--explore",
    "explores",
    is_flag=True,
    help="Go on from where scripts come for the first time, instead of a new seed each time.",
)
@click.option(
    "--weigh",
    "weighs",
    is_flag=True,
    help="Write into weights.toml how often each action is to be drawn, by what is reached.",
)
@click.option(
    "--compare",
    "compared",
    type=click.FloatRange(0.1),
    default=None,
    metavar="SECONDS",
    help="Instead compare plain seeds and exploring by chains of three events.",
)
@click.option(
    "--class",
    "of_class",
    is_flag=True,
    help="Instead play classes of three sessions in one sea.",
)
@click.option(
    "--play",
    "script",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    default=None,
    help="Instead play this script.",
)
def simulation(
    *,
    seeds: int,
    first: int,
    minutes: float | None,
    seconds: float,
    jobs: int,
    table: bool,
    explores: bool,
    weighs: bool,
    compared: float | None,
    of_class: bool,
    script: Path | None,
) -> None:
    """Play whole sessions on a machine of one thread: stations, kills, power cuts, disks.

    A seed that breaks a law is shrunk to a script, which is written into this folder.

    \b
    Example:  python -m tests.simulation --seeds 500
              python -m tests.simulation --from 31 --seeds 1
              python -m tests.simulation --seeds 500 --explore
              python -m tests.simulation --class --seeds 200
              python -m tests.simulation --play simulation-31.json

    Exit codes: 0 every law held, 1 one is broken, or with --reached a milestone was never reached.
    """
    if script:
        sys.exit(play_script(script))
    if of_class:
        sys.exit(play_classes(range(first, first + seeds)))
    if compared:
        click.echo("\n".join(compare(compared, first)))
        return
    until = time.monotonic() + 60.0 * minutes if minutes else None
    totals: Counter[str] = Counter()
    reached: Counter[str] = Counter()
    broken, samples = [], []
    with Bar("playing", seeds) as bar:
        plain = play_seeds(range(first, first + seeds), seconds, jobs)
        for played in explore(first, seeds, seconds) if explores else plain:
            totals.update(played.counts)
            reached.update(played.sample.reached)
            samples.append(played.sample)
            bar.at("seeds", totals["seeds"])
            if played.breaches:
                broken.append(played)
                tell_breaches(played)
            if until and time.monotonic() > until:
                break
    analyse(broken)  # last, since all processes would wait for it
    told = ", ".join(f"{count} {what}" for what, count in totals.items())
    seeds_broken = ", ".join(str(each.seed) for each in broken)
    verdict = f"BROKEN by the seeds {seeds_broken}" if broken else "every law held"
    if table:
        click.echo("\n".join(reach_table(reached, totals["seeds"])))
    click.echo(f"from seed {first}: {told}: {verdict}")
    if weighs:
        counts = {name: reached[name] for name in (*MILESTONES, *SAID_MILESTONES)}
        write_weights(weigh(samples, read_weights()), counts, totals["seeds"])
        click.echo(f"{WEIGHTS_PATH.name}: written")
    lacking = never_reached(reached) if table else []
    if lacking:
        click.echo(f"NEVER REACHED: {', '.join(lacking)}")
    sys.exit(1 if broken or lacking else 0)


def play_seeds(seeds: range, seconds: float, jobs: int) -> Iterator[Played]:
    """Yield what came of each seed, in order."""
    play_one = functools.partial(play_seed, longest=seconds)
    if jobs == 1:
        yield from map(play_one, seeds)
        return
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(jobs, context) as pool:
        many = SEEDS_AHEAD * jobs
        for begin in range(0, len(seeds), many):
            yield from pool.map(play_one, seeds[begin : begin + many])


def play_classes(seeds: range) -> int:
    """Play classes, and print what they break. Return the exit code."""
    totals: Counter[str] = Counter()
    broken = []
    with Bar("playing", len(seeds)) as bar:
        for seed in seeds:
            played = play_class(seed)
            totals.update(played.counts)
            bar.at("classes", totals["classes"])
            if played.breaches:
                broken.append(seed)
                click.echo(f"seed {seed} breaks {played.breaches[0]}")
    told = ", ".join(f"{count} {what}" for what, count in totals.items())
    verdict = f"BROKEN by the seeds {broken}" if broken else "every law held"
    click.echo(f"from seed {seeds[0]}: {told}: {verdict}")
    return 1 if broken else 0


def tell_breaches(played: Played) -> None:
    """Print what a seed has broken."""
    for breach in played.breaches:
        click.echo(f"seed {played.seed} breaks {breach}")


def analyse(broken: list[Played]) -> None:
    """Print when each of these seeds was lost; write their scripts, shrunk."""
    for played in broken:
        law = played.breaches[0].law
        script = played.script
        loss = find_loss(script, law)
        for moment in loss.curve:
            click.echo(f"seed {played.seed}, broken {moment}")
        if loss.lost:
            click.echo(f"seed {played.seed} is lost at {loss.lost.words!r}, tick {loss.lost.tick}")
        small = shrink(loss.cut, functools.partial(breaks_law, law=law))
        path = Path(f"simulation-{played.seed}.json")
        write_script(small, path)
        click.echo(
            f"{path}: of {script.acts} lines {small.acts} are left, of {len(script.lives)} "
            f"processes {len(small.lives)}; once mended, keep it in tests/simulation/kept"
        )


def play_script(path: Path) -> int:
    """Play a script of a file, and print what it breaks. Return the exit code."""
    breaches = play(read_script(path)).breaches
    for breach in breaches:
        click.echo(f"{path} breaks {breach}")
    if not breaches:
        click.echo(f"{path}: every law held")
    return 1 if breaches else 0


if __name__ == "__main__":
    run_command(simulation, "python -m tests.simulation")
