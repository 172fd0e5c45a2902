"""The command ``trainer boat sweep``: a study of many members.

``analysis/sweep`` flies the members, each a run of the study; here options are read and progress is
shown.
"""

from pathlib import Path
from typing import Any

import click

from trainer.cli.answers import json_of, outputs, show_progress, show_report
from trainer.cli.options import STUDY_NAME
from trainer.cli.types import Output


@click.command()
@click.argument("study", type=STUDY_NAME)
@click.option(
    "--out",
    type=Output(".parquet"),
    metavar="FILE",
    help="Parquet file of the result. [default: the study's name, here]",
)
@click.option("--members", type=click.IntRange(1), help="How many. [default: the study's]")
@click.option(
    "--member",
    type=click.IntRange(0),
    metavar="NUMBER",
    help="Fly this one alone and print it; no file.",
)
@click.option("--jobs", type=click.IntRange(1, 256), help="Processes. [default: all processors]")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Fly on the workers of this Dask scheduler, such as tcp://10.0.0.1:8786.",
)
@click.option("--measure", metavar="NAME", help="What to plot. [default: the first]")
@outputs
def sweep(study: str, member: int | None, **options: Any) -> None:
    """Fly a study: one boat many times, with some of its numbers varied.

    STUDY is the name of a shipped study or the path of a file. The result has a row for each
    member. What is finished is kept: after an interruption the same command goes on.

    \b
    Example:  trainer boat sweep turn-uncertainty --plot turn.svg
              trainer boat sweep turn-uncertainty --member 17
              trainer boat sweep ./study.toml --scheduler tcp://127.0.0.1:8786
    """
    from trainer.analysis.sweep.job import job_of, open_job
    from trainer.cli.workshop.subjects import subject_of

    job = job_of(study, options["members"], subject_of)
    if member is not None:
        _show_member(open_job(job), job, member, as_json=options["as_json"])
        return
    from trainer.analysis.sweep.report import panels, render, report_of
    from trainer.analysis.sweep.sweep import check_pyarrow

    check_pyarrow()
    out = options["out"] or Path(f"{Path(study).stem}.parquet")
    result = fly(job, out, options)
    report = report_of(open_job(job), result, str(out))
    show_report(report, render, lambda: panels(report, result, options["measure"]), options)


def fly(job: Any, out: Path, options: dict[str, Any]) -> Any:
    """Fly the members and return a table of pyarrow; show progress on a terminal."""
    from trainer.analysis.sweep.job import open_job
    from trainer.analysis.sweep.sweep import RESUME_NOTE, carry_out, cluster_crew, process_crew
    from trainer.workers import processor_count

    crew = process_crew(options["jobs"] or processor_count())
    if options["scheduler"] is not None:
        crew = cluster_crew(options["scheduler"])
    length = open_job(job).members
    try:
        with show_progress(length, "flying") as step:
            return carry_out(job, crew, out, step)
    except KeyboardInterrupt:
        click.echo(f"trainer: {RESUME_NOTE}", err=True)
        raise


def _show_member(ready: Any, job: Any, member: int, *, as_json: bool) -> None:
    """Fly one member alone and print it; ConfigError if there is no such."""
    from trainer.analysis.sweep.report import member_page
    from trainer.config.files import ConfigError, reading_recorded

    if member >= ready.members:
        raise ConfigError(f"--member {member}: members are 0 to {ready.members - 1}")
    with reading_recorded(dict(job.texts)):
        batch = ready.subject.batch(member, 1)
    lines = batch.told(0, [output.name for output in ready.subject.outputs])
    page = member_page(ready.study.heading.name, member, lines, ready.subject.outputs)
    click.echo(json_of(lines) if as_json else page)
