"""The commands that write a boat for other programs, and as one page.

``export-core``, ``export-fmu`` and ``export-page``. ``boat/export`` compiles the core and links it,
``web/single_file`` puts the page together; here options become a boat at its start.
"""

import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click

from trainer.cli.options import (
    FMU_OUTPUT,
    HTML_OUTPUT,
    RECORDING_FILE,
    SEA_NAME,
    VESSEL_HELP,
    VESSEL_NAME,
    combine_options,
    kind_option,
    method_options,
    run_options,
)
from trainer.cli.types import Choice, Output, text_option
from trainer.config.keywords import RUN_KEYWORDS
from trainer.session.past.options import RunOptions

# Those of the table of targets, which is not read for a list of commands; the first, the default,
# runs on the most machines.
# fmt: off
CPU_NAMES = (
    "x86-64-v2", "x86-64-v3", "x86-64-v4", "native", "aarch64", "riscv64", "cortex-m7", "wasm32",
    "shipped",
)
# fmt: on
NATIVE_PLATFORM_NAMES = ("linux-x86_64", "linux-aarch64", "windows-x86_64")  # likewise; of `all`
UNIT_PLATFORM_NAMES = (*NATIVE_PLATFORM_NAMES, "wasm")

boat_options = combine_options(
    click.option("--vessel", type=VESSEL_NAME, default="bb2", help=VESSEL_HELP),
    method_options,
    click.option("--integrator", default="adams2", help="As for trainer run."),
    click.option("--step", type=float, help="Step in s. [default: the vessel's]"),
    click.option("--unsafe-step", is_flag=True, help="Export even where the step is not stable."),
    kind_option(RUN_KEYWORDS, "sea", default="calm", metavar="NAME|PATH", text="of the start"),
    kind_option(RUN_KEYWORDS, "seed", default=1),
)
VISITOR_STATION = "visitor"
# fmt: off
STATION_ROLES = (
    "instructor", "pilot", "helm", "planes", "ballast", "diving", "observer", VISITOR_STATION,
)
# fmt: on


def targets_text() -> str:
    """Return the processors that the core can be compiled for, a line each."""
    from trainer.boat.export.targets import list_targets

    return "\n".join(list_targets())


@click.command(name="export-core")
@click.argument("directory", type=Output())
@boat_options
@click.option(
    "--cpu",
    type=Choice(CPU_NAMES),
    default=CPU_NAMES[0],
    help="Processors that the code is for; shipped: those of the objects that the trainer ships.",
)
@text_option(
    "--list", targets_text, "List these processors, and what this installation lacks for each."
)
@click.option("--json", "as_json", is_flag=True, help="Print what was written as JSON.")
def export_core(directory: Path, *, cpu: str, as_json: bool, **options: Any) -> None:
    """Write the compiled tick of a boat as a C library that needs no Python.

    \b
    Example:  trainer boat export-core core --vessel bb2
              cc -O2 -ffp-contract=off -o host core/host.c core/trainer_core.o && ./host 7200

    DIRECTORY gets trainer_core.o, libtrainer_core.so, trainer_core.h and host.c, a host to begin
    with. The bits are the trainer's. Exit code 1 when no C compiler could link the library. With
    --cpu cortex-m7 it gets board.c, the start of a program, and no library. With --cpu wasm32 it
    gets core.wasm, boat.json and host.mjs, a host for node. With --cpu shipped it gets the objects
    that this program runs, for all platforms and boats.
    """
    import json

    if cpu == "shipped":
        from trainer.boat.export.library import make_folder
        from trainer.boat.export.objects import write_shipped

        make_folder(directory)
        click.echo(json.dumps(write_shipped(directory), indent=1))
        return
    if cpu == "wasm32":
        from trainer.boat.export.library import export_wasm, render_wasm

        module = export_wasm(boat_at_start(run_options(options)), directory)
        summary = asdict(module)
        click.echo(json.dumps(summary, indent=1) if as_json else render_wasm(module, directory))
        return

    from trainer.boat.export.library import LIBRARY_FILE, add_library, render_export, write_core
    from trainer.boat.export.targets import NoCompilerError
    from trainer.boat.platforms import CPU_TARGETS

    exported = write_core(boat_at_start(run_options(options)), directory, cpu)
    missing = ""
    # The object file is useful by itself. So it stays, even if no C compiler links the library.
    files = exported.files
    try:
        if not CPU_TARGETS[cpu].board:  # which alone has no libraries
            add_library(directory, cpu)
            files += (LIBRARY_FILE,)
    except NoCompilerError as error:
        missing = str(error)
    figures = {**asdict(exported), "files": files}
    click.echo(
        json.dumps(figures, indent=1) if as_json else render_export(exported, directory, files, cpu)
    )
    if missing:
        click.echo(f"trainer: {missing}", err=True)
        sys.exit(1)


@click.command(name="export-fmu")
@click.argument("file", type=FMU_OUTPUT)
@click.option(
    "--fmi",
    type=click.Choice(["2", "3", "both"]),
    default="2",
    help="The version of the standard; both: the unit of 3.0 beside the other, as NAME-fmi3.fmu.",
)
@click.option(
    "--platform",
    "platforms",
    type=Choice((*UNIT_PLATFORM_NAMES, "all")),
    multiple=True,
    help="Systems that the unit is for; may be given again. all: the first three; wasm: by a draft "
    "of the standard, FMI 3 alone. [default: this machine's]",
)
@boat_options
def export_fmu(file: Path, *, fmi: str, platforms: tuple[str, ...], **options: Any) -> None:
    """Write a boat as a functional mock-up unit (FMI), for other simulators.

    \b
    Example:  trainer boat export-fmu bb2.fmu --vessel bb2
              trainer boat export-fmu bb2.fmu --sea sea-state-4 --seed 7
              trainer boat export-fmu bb2.fmu --fmi 3

    It is for co-simulation, with no Python inside. The bits are the trainer's. The simulator may
    choose another sea state, its direction and the seed. It needs a C compiler for each platform.
    """
    from trainer.boat.export.fmu import fmu_bytes
    from trainer.config.files import write_over

    chosen = run_options(options)
    sea = boat_at_start(chosen).sea  # a sea that this step and boat can have
    boat = boat_at_start(replace(chosen, sea="calm"))
    beside = file.with_name(f"{file.stem}-fmi3{file.suffix}")
    versions = {"2": {file: 2}, "3": {file: 3}, "both": {file: 2, beside: 3}}
    named = {name for name in platforms if name != "all"}
    names = named.union(NATIVE_PLATFORM_NAMES if "all" in platforms else ())
    units = {path: fmu_bytes(boat, sea, version, names) for path, version in versions[fmi].items()}
    for path, whole in units.items():
        write_over(path, whole)
        click.echo(f"{boat.file.name}: {path}, {len(whole):,} bytes")


@click.command(name="export-page")
@click.argument("file", type=HTML_OUTPUT)
@click.option("--vessel", type=VESSEL_NAME, help=f"{VESSEL_HELP} [default: bb2]")
@click.option("--sea", type=SEA_NAME, metavar="NAME|PATH", help="[default: calm]")
@click.option("--seed", type=click.IntRange(0, 2**53 - 1), help="[default: 1]")
@click.option("--recording", type=RECORDING_FILE, help="What was flown, to be seen and taken over.")
@click.option(
    "--station",
    type=click.Choice(STATION_ROLES),
    default=STATION_ROLES[0],
    help="The station that the page is.",
)
def export_page(file: Path, *, recording: Path | None, station: str, **options: Any) -> None:
    """Write one HTML file with a boat inside, which any browser flies with no network.

    \b
    Example:  trainer boat export-page boat.html --vessel bb2
              trainer boat export-page drill.html --recording drill.trainer
              trainer boat export-page kiosk.html --station visitor

    Marks are not judged there. With a recording its time line can be dragged and the boat taken
    over at any moment, to the bits of trainer resume. Station visitor is the kiosk.
    """
    from trainer.debrief.page.boat_page import boat_of_visitors, write_page

    page_options = {name: value for name, value in options.items() if value is not None}
    if recording is not None and page_options:
        raise click.UsageError(
            f"--recording has its own boat: leave out --{next(iter(page_options))}"
        )
    chosen = replace(RunOptions(vessel="bb2"), **page_options, given=frozenset(page_options))
    boat, visitors = None, None
    if station == VISITOR_STATION:
        if recording is not None:
            raise click.UsageError("a visitor dives from the start: leave out --recording")
        boat, visitors = boat_of_visitors(chosen)
    elif recording is None:
        boat = boat_at_start(chosen)
    write_page(file, page_text(boat, recording, station, visitors))


def page_text(
    boat: Any, recording: Path | None, station: str, visitors: dict[str, Any] | None = None
) -> str:
    """Return a station's page with a boat or a recording inside."""
    from trainer.debrief.page.boat_page import page_of
    from trainer.web.single_file import single_file

    parts = page_of(boat, recording, station, visitors)
    return single_file(station, parts.boat, parts.core, parts.title)


def boat_at_start(options: RunOptions) -> Any:
    """Return the boat of these options at its start; ConfigError if there is none."""
    from trainer.boat.boat import Boat
    from trainer.config.boat.vessel import load_vessel
    from trainer.config.files import ConfigError
    from trainer.config.world.sea import load_sea
    from trainer.session.doors.warm_up import refuse_unstable, warm_boat
    from trainer.session.past.plan import choose_method
    from trainer.units import KNOT

    file = load_vessel(options.vessel)
    sea = load_sea(options.sea or "calm")
    if sea.world:
        raise ConfigError(
            f"{sea.path.name}: [{next(iter(sea.world))}]: an exported boat and a page have none; "
            "leave it out, or run it by trainer run"
        )
    boat = Boat(file, choose_method(file, options))
    warm_boat(boat)
    if not options.unsafe_step:
        refuse_unstable(boat)
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0, options.seed)
    boat.put_to_sea(sea)
    return boat
