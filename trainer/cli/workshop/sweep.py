"""The command ``trainer boat sweep``: a study of many members.

``analysis/sweep`` flies the members, each a run of the study; here options are read and progress is
shown.
"""

from pathlib import Path
from typing import Any

import click

from trainer.cli.answers import json_of, outputs, show_report
from trainer.cli.options import STUDY_NAME, kind_option
from trainer.config.keywords import SWEEP_KEYWORDS


@click.command()
@click.argument("study", type=STUDY_NAME)
@kind_option(SWEEP_KEYWORDS, "out", usual="the study's name, here")
@kind_option(SWEEP_KEYWORDS, "members", usual="the study's")
@click.option(
    "--member",
    type=click.IntRange(0),
    metavar="NUMBER",
    help="Fly this one alone and print it; no file.",
)
@kind_option(SWEEP_KEYWORDS, "jobs", usual="all processors")
@kind_option(SWEEP_KEYWORDS, "scheduler", metavar="ADDRESS")
@click.option(
    "--part",
    metavar="I/N",
    help="Fly this share of the members into the folder --parts, and make no result.",
)
@click.option(
    "--parts", type=Path, metavar="FOLDER", help="Of --part; all parts may share it at once."
)
@click.option(
    "--join", type=Path, metavar="FOLDER", help="Make the result of the parts in this folder."
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
              trainer boat sweep ./study.toml --part 3/64 --parts ./parts
              trainer boat sweep ./study.toml --join ./parts --out result.parquet
    """
    from trainer.analysis.sweep.job import job_of, open_job
    from trainer.api.programs import fly_sweep
    from trainer.api.subjects import subject_of

    job = job_of(study, options["members"], subject_of)
    if member is not None:
        _show_member(open_job(job), job, member, as_json=options["as_json"])
        return
    from trainer.analysis.sweep.report import panels, render, report_of
    from trainer.analysis.sweep.sweep import check_pyarrow, join_chunks

    check_pyarrow()
    if options["part"] is not None or options["parts"] is not None:
        fly_part(job, options)
        return
    out = options["out"] or Path(f"{Path(study).stem}.parquet")
    if options["join"] is None:
        result = fly_sweep(job, out, options["jobs"], options["scheduler"])
    else:
        result = join_chunks(job, options["join"], out)
    report = report_of(open_job(job), result, str(out))
    show_report(report, render, lambda: panels(report, result, options["measure"]), options)


def fly_part(job: Any, options: dict[str, Any]) -> None:
    """Fly one share of a study into the folder of its parts; ConfigError."""
    from trainer.analysis.sweep.sweep import Share, fly_share, members_in, process_crew
    from trainer.api.programs import show_members
    from trainer.config.files import ConfigError, quote
    from trainer.workers import processor_count

    part, folder = options["part"], options["parts"]
    if part is None or folder is None:
        raise ConfigError("--part I/N and --parts FOLDER go together, such as --part 3/64")
    for name in ("out", "join", "scheduler", "plot"):
        if options[name] is not None:
            raise ConfigError(f"--part: makes no result, so --{name} is for --join")
    number, _, count = part.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise ConfigError(f"--part {quote(part)}: must be such as 3/64, from 1/64 to 64/64")
    share = Share(int(number), int(count))
    chunks = share.chunks(job)
    with show_members(sum(members_in(job, index) for index in chunks)) as step:
        fly_share(job, process_crew(options["jobs"] or processor_count()), share, folder, step)
    members = sum(members_in(job, index) for index in chunks)
    click.echo(f"part {share}: {members} members in {len(chunks)} chunks are in {folder}")


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
