"""The options of a run, as a record: those of ``trainer run``, ``serve`` and ``resume``.

``cli`` fills it from the command line; ``plan`` and ``run`` read it.
"""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The options of ``trainer run``, ``serve`` and ``resume``; their help explains each.

    ``given`` names those that the user gave: they overrule what an exercise sets.
    """

    # what is run
    exercise: str | None = None  # name or path
    vessel: str = "bb2"
    equations: str | None = None  # None: the boat's own
    rates: str | None = None
    trig: str = "exact"
    sea: str | None = None
    integrator: str = "adams2"
    step: float | None = None  # [s]
    unsafe_step: bool = False
    battery: str = "drained"  # or endless
    seed: int = 1
    width: str = "qualified"  # of the bands that it is judged by
    trainee: tuple[str, ...] = ()  # names
    course: Path | None = None  # class file by which ``next`` goes on
    familiarisation: bool = False  # these get to know the simulator: there are no marks
    orders_file: Path | None = None
    # its time
    duration: float | None = None  # [s]
    speed: float = 1.0  # of time; infinite at full speed
    overrun: str = "catch-up"
    priority: str = "realtime"
    frozen: bool = False
    train: bool = False  # the console is that of who trains alone
    instruct: bool = False  # it is the instructor's, without being asked
    verbose: bool = False  # its summary has duty cycle and lateness
    until_left: bool = False
    # what is kept
    csv_path: Path | None = None
    record: Path | None = None
    no_record: bool = False
    debrief: Path | None = None  # the page, written by the command once the run is over
    rerun: bool = False
    rerun_at: str | None = None
    rrd: Path | None = None
    # who attends
    headless: bool = False
    serve: bool = False  # stations are let in though there is no console
    url: str | None = None  # of the console
    lines: tuple[str, ...] = ()
    baud: int = 9600
    listen: str | None = None
    socket: str | None = None
    token: tuple[str, ...] = ()
    browse: bool = False  # pages for browsers, one of which is opened
    web: str | None = None  # where the pages are
    cert: Path | None = None  # of the pages, for https
    key: Path | None = None
    public_url: str | None = None  # of the pages, where a proxy stands before them
    proxy: tuple[str, ...] = ()  # those that are trusted
    nmea: tuple[str, ...] = ()
    nmea_baud: int = 38400
    nmea_rate: float = 2.0  # [Hz]
    nmea_sentences: str | None = None
    nmea_orders: bool = False
    nmea_record: Path | None = None
    origin: str = "25,-45"
    # beside the options
    given: frozenset[str] = frozenset()
