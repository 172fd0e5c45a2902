"""The command that prints what nobody, the crew and a learner earn in an exercise."""

import click

LEARNED_GENERATIONS = 40


@click.command()
@click.argument("exercise")
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=1,
    show_default=True,
    help="Of the strategy: the same one learns the same, to the bit.",
)
@click.option(
    "--generations",
    type=click.IntRange(1, 100_000),
    default=LEARNED_GENERATIONS,
    show_default=True,
    help="Of 256 flights each.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
def learn(exercise: str, seed: int, generations: int, *, as_json: bool) -> None:
    """Print what nobody aboard, the reference crew and a learned policy earn.

    \b
    Example:  trainer dev learn first-depth-change --seed 1
              trainer dev learn steady-course --generations 20
    """
    import json
    from dataclasses import asdict

    from trainer.analysis.learning import baselines, lines

    found = baselines(exercise, seed, generations)
    click.echo(json.dumps(asdict(found), indent=1) if as_json else "\n".join(lines(found)))
