"""The cost of a class: many boats at once, each with stations attached.

``python -m tests.bench --class 8`` measures it, in a class that ``trainer class`` begins. At each
boat an instructor, the planes and an observer are attached as programs, and the planes give orders.
Memory is proportional (PSS): what processes share is counted once among them. A boat is its session
and the process that judges what could be earned.
"""

import asyncio
import contextlib
import itertools
import os
import re
import statistics
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from bench.helm import START_TIMEOUT_S
from bench.on_time import END_TIMEOUT_S
from trainer.analysis.bench.delays import TRAINER_COMMAND
from trainer.analysis.bench.ticks import load_line
from trainer.config.files import ConfigError
from trainer.io import client
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.io.serial_line import LinkError

CLASS_EXERCISE: Final = "depth-changes"
STATION_CHANNELS: Final = {  # who is attached at each boat, and what each wants to see
    "instructor": ("motion", "orders", "time", "ledger"),
    "planes": ("gauges", "orders", "diving", "time"),
    "observer": ("gauges", "time"),
}
PLANE_ORDERS: Final = ("stern planes dive 2", "stern planes rise 2")
ORDER_PAUSE_S: Final = 0.1  # between orders, from boat to boat: as hands do
ANSWER_TIMEOUT_S: Final = 10.0
TICKS_FIELD, MISSED_FIELDS = 2, (4, 6, 7)  # of the channel ledger: overruns, slipped, gaps
BOAT_SOCKET: Final = re.compile(r"class: boat \d+: trainer attach --connect (\S+)")
PROCESS_FILE: Final = Path("/proc/self/smaps_rollup")
BYTES_PER_KIB: Final = 1024.0
BYTES_PER_MB: Final = 1e6


class NoProcessFiguresError(ConfigError):
    """The system does not tell what processes use; the text says so."""


@dataclass(frozen=True)
class BoatUse:
    """What one boat has used; memory in MB, processor in % of one core."""

    missed: int  # deadlines: overruns, slipped ticks and gaps
    ticks: int
    session_mb: float
    judge_mb: float
    processor: float


@dataclass(frozen=True)
class ClassUse:
    """What a class has used, and how soon orders were answered."""

    seconds: float
    stations: int  # at each boat
    load: str  # of the machine before it
    orders: int
    answer_median: float  # [ms]
    answer_p95: float
    class_mb: float  # of the class itself: supervisor and pages' server
    class_processor: float  # [%] of one core
    boats: tuple[BoatUse, ...]


@dataclass
class AttachedStation:
    """One station of a boat, as a program."""

    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter
    shown: dict[str, list[str]] = field(default_factory=dict)  # the latest of each channel
    _tags: Iterator[int] = field(default_factory=lambda: itertools.count(1))
    _awaited: dict[str, asyncio.Future[list[str]]] = field(default_factory=dict)

    async def ask(self, words: str) -> None:
        """Give an order; ConfigError where it is refused, or not answered in time."""
        tag = str(next(self._tags))
        self._awaited[tag] = asyncio.get_running_loop().create_future()
        self.writer.write(f"{order_sentence(words, tag)}\n".encode("ascii"))
        try:
            answer = await asyncio.wait_for(self._awaited[tag], ANSWER_TIMEOUT_S)
        except TimeoutError:
            raise ConfigError(f"a boat of the class does not answer: {words}") from None
        if answer[0] != "ok":
            raise ConfigError(f"a boat of the class refuses: {words}: {answer[1]}")

    async def hear(self) -> None:
        """Take what the session says, to its end."""
        while said := await self.reader.readline():
            sentence = parse_sentence(said.decode("ascii", "replace").strip())
            if sentence is None:
                continue
            fields = list(sentence.fields)
            if sentence.kind == "TRS":
                self.shown[fields[0]] = fields[1:]
            elif sentence.kind == "TRA" and fields[0] in ("ok", "no"):
                self._awaited.pop(sentence.tag).set_result(fields)


def time_class(boats: int, seconds: float) -> ClassUse:
    """Return what so many boats use in ``seconds`` [s]; ConfigError if they cannot."""
    if not PROCESS_FILE.exists():
        raise NoProcessFiguresError("a class: this system does not tell what processes use")
    load = load_line()
    with tempfile.TemporaryDirectory(prefix="trainer-") as name:
        said = Path(name) / "said"
        words = ("class", CLASS_EXERCISE, "--boats", str(boats), "--web", "127.0.0.1:0")
        with (
            said.open("w") as out,
            subprocess.Popen(
                [*TRAINER_COMMAND, *words, "--folder", str(Path(name) / "kept")],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=out,
            ) as process,
        ):
            try:
                sockets = await_boats(process, said, boats)
                return asyncio.run(sail(sockets, seconds, process.pid, load))
            finally:
                process.terminate()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(END_TIMEOUT_S)
                process.kill()


def await_boats(process: "subprocess.Popen[bytes]", said: Path, boats: int) -> list[str]:
    """Return where the boats listen, once all do; ConfigError if the class ends before."""
    by = time.monotonic() + START_TIMEOUT_S
    while process.poll() is None and time.monotonic() < by:
        found = BOAT_SOCKET.findall(said.read_text(encoding="utf-8"))
        if len(found) == boats and all(map(listens, found)):
            return found
        time.sleep(0.1)
    raise ConfigError(f"the class did not begin: {said.read_text(encoding='utf-8').strip()}")


def listens(address: str) -> bool:
    """Return whether a session takes lines there."""
    try:
        client.reach(address).close()
    except LinkError:
        return False
    return True


async def sail(sockets: list[str], seconds: float, owner: int, load: str) -> ClassUse:
    """Attach the stations, let all boats run, give orders; return the figures."""
    stations = [await attach(address, role) for address in sockets for role in STATION_CHANNELS]
    hearing = [asyncio.create_task(station.hear()) for station in stations]
    count = len(STATION_CHANNELS)
    instructors, planes = stations[::count], stations[1::count]
    for station, role in zip(stations, itertools.cycle(STATION_CHANNELS), strict=False):
        await station.ask(f"role {role}")
        for channel in STATION_CHANNELS[role]:
            await station.ask(f"subscribe {channel}")
    for station in instructors:
        await station.ask("run")
    await asyncio.sleep(1.0)  # the judges begin
    sessions = {crew: children_of(crew) for crew in children_of(owner)}
    whole = {owner: [], **sessions}
    begun, before = time.monotonic(), {crew: seconds_of(crew, own) for crew, own in whole.items()}
    answers = await give_orders(planes, begun + seconds)
    lasted = time.monotonic() - begun
    after = {crew: seconds_of(crew, own) for crew, own in whole.items()}
    used = {crew: 100.0 * (after[crew] - before[crew]) / lasted for crew in whole}
    ledgers = [station.shown.get("ledger", []) for station in instructors]
    for number, ledger in enumerate(ledgers, 1):
        if ledger and not int(ledger[TICKS_FIELD]):
            raise ConfigError(f"boat {number} of the class has no figure: it did no tick")
    for task in hearing:
        task.cancel()
    for station in stations:
        station.writer.close()
    return ClassUse(
        seconds=lasted,
        stations=count,
        load=load,
        orders=len(answers),
        answer_median=1e3 * statistics.median(answers),
        answer_p95=1e3 * statistics.quantiles(answers, n=20)[-1],
        class_mb=memory_of(owner),
        class_processor=used[owner],
        boats=tuple(
            BoatUse(
                missed=sum(int(ledger[place]) for place in MISSED_FIELDS) if ledger else 0,
                ticks=int(ledger[TICKS_FIELD]) if ledger else 0,
                session_mb=memory_of(crew),
                judge_mb=sum(map(memory_of, own)),
                processor=used[crew],
            )
            for (crew, own), ledger in zip(sorted(sessions.items()), ledgers, strict=True)
        ),
    )


async def attach(address: str, role: str) -> AttachedStation:
    """Return a station with a line to a boat; ConfigError."""
    try:
        end = await asyncio.to_thread(client.reach, address)
    except LinkError as error:
        raise ConfigError(f"a boat of the class takes no {role}: {error}") from None
    return AttachedStation(*await asyncio.open_connection(sock=end))


async def give_orders(planes: list[AttachedStation], until: float) -> list[float]:
    """Give orders from boat to boat until a time [s], both to each boat at least.

    Return how long each answer took [s].
    """
    answers: list[float] = []
    for number in itertools.count():
        station = planes[number % len(planes)]
        begun = time.monotonic()
        if begun >= until and len(answers) >= 2 * len(planes):  # both orders to each boat
            return answers
        await station.ask(PLANE_ORDERS[number // len(planes) % 2])
        answers.append(time.monotonic() - begun)
        await asyncio.sleep(ORDER_PAUSE_S)
    return answers


def children_of(process: int) -> list[int]:
    """Return the processes that a process has begun."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[1]) == process:
                found.append(int(path.parent.name))
    return sorted(found)


def seconds_of(process: int, others: list[int]) -> float:
    """Return the processor time [s] of a process and others."""
    ticks = 0
    for each in (process, *others):
        with contextlib.suppress(OSError):
            fields = Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def memory_of(process: int) -> float:
    """Return the proportional memory [MB] of a process, 0 where it has gone."""
    with contextlib.suppress(OSError):
        told = Path(f"/proc/{process}/smaps_rollup").read_text()
        return (
            float(re.findall(r"^Pss:\s+(\d+) kB", told, re.MULTILINE)[0])
            * BYTES_PER_KIB
            / BYTES_PER_MB
        )
    return 0.0


def lines(figures: ClassUse) -> list[str]:
    """Return the figures as lines of a page."""
    rows = (
        f"  {number:4}{each.ticks:8}{each.missed:8}{each.session_mb:12.0f}{each.judge_mb:10.0f}"
        f"{each.processor:12.2f}"
        for number, each in enumerate(figures.boats, 1)
    )
    answers = f"median {figures.answer_median:.1f} ms, 95 % in {figures.answer_p95:.1f} ms"
    length = f"{len(figures.boats)} boats for {figures.seconds:.0f} s"
    return [
        "",
        f"A CLASS ({length}, {figures.stations} stations at each)",
        f"  {figures.load}",
        f"  {figures.orders} orders answered: {answers}",
        f"  the class itself: {figures.class_mb:.0f} MB, {figures.class_processor:.2f} % of a core",
        "  boat   ticks  missed  session MB  judge MB  % of a core",
        *rows,
    ]
