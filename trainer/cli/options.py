"""The options that several commands share, and the record of a run made of them.

Every command takes its options from here, so that an option has one name, one default and one help
text. What a call of the Python face takes too has its kind in ``config.keywords``.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import click
from click.core import ParameterSource

from trainer.cli.types import Duration, File, Name, Number, Output, Speed
from trainer.config.keywords import (
    RUN_KEYWORDS,
    InputFile,
    OutputFile,
    Several,
    ShippedName,
)
from trainer.config.schema import Choice, Choices, Flag, Kind, Quantity, WholeNumber
from trainer.io.paths import DEFAULT_HOST, DEFAULT_PORT, PAGES_PORT
from trainer.session.past.options import RunOptions

VESSEL_HELP: Final = RUN_KEYWORDS["vessel"].form.meaning
RATING_WIDTHS: Final = ("qualified", "basic")  # see debrief.judgement

Decorator = Callable[[Any], Any]
ANY_FILE: Final = File()
RECORDING_FILE: Final = File(".trainer")
CSV_FILE: Final = File(".csv")
TOML_FILE: Final = File(".toml")
CSV_OUTPUT: Final = Output(".csv")
RRD_OUTPUT: Final = Output(".rrd")
TOML_OUTPUT: Final = Output(".toml")
HTML_OUTPUT: Final = Output(".html")
FMU_OUTPUT: Final = Output(".fmu")
PDF_OUTPUT: Final = Output(".pdf")
SVG_OUTPUT: Final = Output(".svg")
VESSEL_NAME: Final = Name("vessels")
SEA_NAME: Final = Name("seas")
EXERCISE_NAME: Final = Name("lessons", "exercises")
STUDY_NAME: Final = Name("studies")
cores_option = click.option(
    "--cores", type=click.IntRange(1, 256), help="Processors to use. [default: all]"
)
WEB_ADDRESS: Final = f"{DEFAULT_HOST}:{PAGES_PORT}"
connect_option = click.option(
    "--connect",
    "url",
    metavar="URL",
    help="tcp://HOST:PORT, the path of a local socket, or a serial line. "
    "[default: this machine's session]",
)
teletype_option = click.option(
    "--teletype", is_flag=True, help="Plain lines instead of a screen, also on a terminal."
)


def combine_options(*options: Decorator) -> Decorator:
    """Return a decorator that adds options in the order given."""

    def add(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def kind_option(
    kinds: Mapping[str, Kind], name: str, *flags: str, text: str = "", usual: str = "", **more: Any
) -> Decorator:
    """Return the option of the kind that a table has under ``name``.

    Unit, limits and meaning are those of a keyword, or of a study's key. ``text`` stands for the
    meaning, and ``usual`` tells what holds without the option.
    """
    kind, words = kinds[name], flags or (f"--{name.replace('_', '-')}",)
    head, stop, rest = (text or kind.form.meaning).partition(". ")
    unit = f" [{kind.unit}]" if isinstance(kind, Quantity) and kind.unit != "-" else ""
    told = f"{head[:1].upper()}{head[1:].removesuffix('.')}{unit}.{stop[1:]}{rest}"
    told += f" [default: {usual}]" if usual else ""
    return click.option(*words, **{"help": told, **_typed(kind), **more})


def _typed(kind: Kind) -> dict[str, Any]:
    """Return how click reads an option of a kind."""
    read: dict[str, Any] = {"type": str}  # a text
    if isinstance(kind, Several):
        read = _typed(kind.each) | {"multiple": True}
    elif isinstance(kind, Choice | Choices):
        read = {"type": click.Choice(kind.words), "multiple": isinstance(kind, Choices)}
    elif isinstance(kind, Quantity):
        limits = kind.limits
        read = {"type": Number(limits.low, limits.high, min_open=limits.open_below)}
    elif isinstance(kind, WholeNumber):
        read = {"type": click.IntRange(kind.low, kind.high)}
    elif isinstance(kind, Flag):
        read = {"is_flag": True}
    elif isinstance(kind, ShippedName):
        read = {"type": Name(*kind.endings)}
    elif isinstance(kind, InputFile):
        of_file = Output if isinstance(kind, OutputFile) else File
        read = {"type": of_file(*kind.endings), "metavar": "FILE"}
    return read


def kind_options(kinds: Mapping[str, Kind], *names: str, **defaults: Any) -> Decorator:
    """Return the options of some kinds of a table, then those with defaults."""
    usual = (kind_option(kinds, name, default=value) for name, value in defaults.items())
    return combine_options(*(kind_option(kinds, name) for name in names), *usual)


last_option = click.option(
    "--last", is_flag=True, help="The recording in the recordings' folder made last."
)


def named_recording(file: Path | None, *, last: bool) -> Path:
    """Return the recording named, or the last; UsageError unless one is asked for."""
    from trainer.debrief.trainees.history import latest_recording

    if (file is None) is not last:
        raise click.UsageError("name a recording, or say --last")
    return latest_recording() if file is None else file


method_options = combine_options(
    kind_option(
        RUN_KEYWORDS,
        "equations",
        usual="modified; full for a boat without a compact set of its own",
    ),
    kind_option(RUN_KEYWORDS, "rates", usual="lagged; exact with Runge-Kutta"),
    kind_option(RUN_KEYWORDS, "trig", default=RunOptions.trig),
)

exercise_options = combine_options(
    kind_option(RUN_KEYWORDS, "vessel", default=RunOptions.vessel),
    method_options,
    kind_option(RUN_KEYWORDS, "sea", metavar="NAME|PATH"),
    kind_option(RUN_KEYWORDS, "integrator", default=RunOptions.integrator),
    # Outside its limits the plan refuses it, as it does a vessel file's.
    kind_option(RUN_KEYWORDS, "step", type=float, usual="the vessel file's, 0.5 for bb2"),
    kind_option(RUN_KEYWORDS, "unsafe_step"),
    kind_option(RUN_KEYWORDS, "battery", default=RunOptions.battery),
    kind_option(RUN_KEYWORDS, "seed", default=RunOptions.seed),
    kind_option(RUN_KEYWORDS, "orders", "--orders", "orders_file"),
)

time_options = combine_options(
    click.option(
        "--duration", type=Duration(), help="Simulated time: 120, 10m, 1h. [default: until quit]"
    ),
    click.option("--speed", type=Speed(), default="1", help="Of time: 0.1 to 100, or max."),
    click.option(
        "--overrun",
        type=click.Choice(("catch-up", "slip", "freeze")),
        default="catch-up",
        help="What happens when a tick ends too late.",
    ),
    click.option(
        "--priority",
        type=click.Choice(("realtime", "normal")),
        default="realtime",
        help="Whether time is kept by a real-time priority and locked memory, where permitted.",
    ),
    click.option("--frozen", is_flag=True, help="Start with time frozen, until the order run."),
    click.option(
        "--verbose", is_flag=True, help="End with duty cycle, lateness, priority and memory."
    ),
    click.option(
        "--csv", "csv_path", type=CSV_OUTPUT, help="Write the state of each tick to this file."
    ),
)

recording_options = combine_options(
    kind_option(
        RUN_KEYWORDS,
        "record",
        usual="the recordings' folder, unless headless or at --speed max",
    ),
    click.option("--no-record", is_flag=True, help="Keep nothing."),
)

trainee_options = combine_options(
    click.option(
        "--trainee",
        multiple=True,
        metavar="NAME",
        help="Who is trained, kept on this machine; may be given again.",
    ),
    click.option(
        "--familiarisation",
        is_flag=True,
        help="To get to know the simulator: kept with the trainee's recordings, without marks.",
    ),
    click.option(
        "--width",
        type=click.Choice(RATING_WIDTHS),
        default="qualified",
        help="Of the bands that it is judged by; basic is half as wide again.",
    ),
)

console_options = combine_options(
    click.option(
        "--headless", is_flag=True, help="No console, no input; a progress bar and a summary."
    ),
    click.option(
        "--serial",
        "url",
        metavar="URL",
        help="Console on this pyserial port or URL instead of the terminal.",
    ),
)

rerun_options = combine_options(
    click.option("--rerun", is_flag=True, help="Show the run in Rerun's viewer while it goes on."),
    click.option(
        "--rerun-at",
        metavar="HOST:PORT",
        help="Where that viewer listens. [default: 127.0.0.1:9876, opened if it is not there]",
    ),
    click.option("--rrd", type=RRD_OUTPUT, help="Write the run to this file for Rerun."),
)

nmea_options = combine_options(
    click.option(
        "--nmea",
        multiple=True,
        metavar="URL",
        help="Send NMEA 0183 to a serial port, udp://HOST:PORT, or whoever comes to "
        "tcp://HOST:PORT; may be given again. `trainer dev instruments` lists the sentences.",
    ),
    click.option(
        "--nmea-baud",
        type=click.IntRange(50, 4_000_000),
        default=38400,
        help="Of its serial ports.",
    ),
    click.option(
        "--nmea-rate",
        type=click.FloatRange(0.1, 50.0),
        default=2.0,
        metavar="HZ",
        help="Sets of sentences a second.",
    ),
    click.option(
        "--nmea-sentences",
        metavar="NAMES",
        help="Only these, such as RMC,HDT,XDR. [default: all but VDR,VBW,INDBT,INDPT]",
    ),
    click.option(
        "--nmea-orders",
        is_flag=True,
        help="Take its orders at TCP ports also with --token, which its sentences cannot give.",
    ),
    click.option(
        "--nmea-record",
        type=Output(".nmea", ".txt"),
        help="Keep the sentences in this file, at that rate of the boat's own time.",
    ),
    click.option(
        "--origin",
        default="25,-45",
        metavar="LAT,LON",
        help="Where on the Earth the boat begins, in degrees, north and east positive.",
    ),
)


def port_options(*, listen: str | None, socket: str | None) -> Decorator:
    """Return the options that say where stations are, with the defaults of two of them."""
    return combine_options(
        click.option(
            "--line",
            "lines",
            multiple=True,
            metavar="ROLE=URL",
            help="A station on a serial port or pyserial URL; may be given again.",
        ),
        click.option(
            "--baud", type=click.IntRange(50, 4_000_000), default=9600, help="Of the serial ports."
        ),
        click.option(
            "--listen",
            default=listen,
            show_default=listen is not None,
            metavar="HOST:PORT",
            help=f"Let stations in by TCP, such as {DEFAULT_HOST}:{DEFAULT_PORT}, or none.",
        ),
        click.option(
            "--socket",
            default=socket,
            show_default=False,
            metavar="PATH",
            help="Let stations in at this local socket, or none. [default: this user's]",
        ),
        click.option(
            "--token",
            multiple=True,
            default=(),
            metavar="[ROLE=]WORD",
            help="Word that stations at sockets have to give, of one role or of all; may be given "
            "again.",
        ),
        nmea_options,
    )


page_options = combine_options(
    click.option(
        "--cert", "--web-cert", "cert", type=ANY_FILE, help="Certificate of the pages, for https."
    ),
    click.option("--key", "--web-key", "key", type=ANY_FILE, help="Its key."),
    click.option(
        "--public-url",
        metavar="URL",
        help="Where browsers find the pages, behind a reverse proxy.",
    ),
    click.option(
        "--proxy",
        multiple=True,
        default=(),
        metavar="ADDRESS",
        help="Trust this proxy, or network of proxies, to name clients (X-Forwarded-For); may be "
        "given again.",
    ),
)

web_run_options = combine_options(
    click.option("--web", "browse", is_flag=True, help="Stations in a browser, which is opened."),
    click.option(
        "--web-at",
        "web",
        metavar="HOST:PORT",
        help=f"Where these pages are. [default: {WEB_ADDRESS}, or any free port]",
    ),
    page_options,
)

web_serve_options = combine_options(
    click.option(
        "--web",
        metavar="HOST:PORT",
        help=f"Serve stations for browsers there, such as {WEB_ADDRESS}.",
    ),
    page_options,
)


connect_options = combine_options(
    connect_option, click.option("--token", help="The word that this session asks for.")
)


class_options = combine_options(
    click.option(
        "--course",
        type=TOML_FILE,
        help="Class file by whose course `next` goes on, once the marks of its row are reached.",
    ),
    # A program that begins a session, and is to outlive none of it, holds its input open.
    click.option("--owned", is_flag=True, hidden=True),
)


def run_options(options: Mapping[str, Any]) -> RunOptions:
    """Return the options of the command under way, and which of them were given."""
    return RunOptions(**options, given=options_given())


def options_given() -> frozenset[str]:
    """Return the names of the options given to the command under way."""
    context = click.get_current_context()
    source = context.get_parameter_source
    return frozenset(name for name in context.params if source(name) is not ParameterSource.DEFAULT)


def flags_given(names: Iterable[str]) -> str:
    """Return those of the options of these names that were given, as one types them."""
    given = options_given() & {*names}
    options = click.get_current_context().command.params
    return ", ".join(option.opts[-1] for option in options if option.name in given)


def without_console(options: RunOptions) -> RunOptions:
    """Return the options for a session without a console of its own."""
    return replace(options, headless=True, url=None, serve=True)
