"""A soak is a day of exercises, or half an hour by the clock."""

import concurrent.futures
import contextlib
import json
import re
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random
from typing import Any, Final

from soak.audit import Check, audit
from soak.operators import Watchbill, attend, instruct
from soak.session_process import SessionProcess, begin_watched
from trainer.config.files import read_text, shipped_path

STEP: Final = 0.5  # [s]
OPERATORS: Final = 8
EVERY: Final = 0.05  # [s] between looks at the memory
FEWEST: Final = 100  # looks that can be judged: in fewer, first uses of code weigh as growth
WARM_UP: Final = 1.0 / 3.0  # of the run, before its memory is looked at
GROWTH: Final = 1024  # [kB] that medians of its memory may differ by, in a soak of up to an hour
ORDER_KB: Final = 1.0  # [kB] beside it for each order: what stood after it, for a jump back to it
PATIENCE: Final = 120.0  # [s] for the end of a session beyond its time
LONGEST: Final = 1.0 / 144.0  # [-] of its time that a run at full speed may take: a day, 10 min
ON_TIME: Final = re.compile(r"overruns (\d+), caught up (\d+), slipped (\d+), gaps (\d+)")
ENDLESS_KWH: Final = 1e6  # the most that a vessel's file may say
EXERCISE: Final = """
schema = "exercise/1"
name = "Everything at once"
briefing = "A sea, things that break, and orders without end."
vessel = "./boat.toml"
sea = "sea-state-4"
step_s = 0.5

[initial]
depth_m = 60
speed_kn = 8

[[casualties]]
when = "depth > 90"
name = "rudder-slow"
"""


@dataclass(frozen=True)
class Plan:
    """The plan of a soak."""

    seconds: float  # of exercise time
    real_time: bool
    seed: int

    @property
    def ticks(self) -> int:
        """Return the number of the last tick."""
        return round(self.seconds / STEP)

    @property
    def patience(self) -> float:
        """Return how long [s] it may take by the clock."""
        return PATIENCE + self.seconds * (1.0 if self.real_time else LONGEST)


@dataclass
class Soaked:
    """The findings of a soak."""

    plan: Plan
    wall_s: float
    orders: int
    visits: int
    recording_mb: float
    ahead_mb: float  # most that was written ahead of it
    rescues: int  # times that the boat would be lost, and was taken back or held
    lost_numbers: list[str]  # where the boat went beyond what can be computed
    checks: list[Check]

    @property
    def kept(self) -> bool:
        """Return whether every promise was."""
        return all(check.kept for check in self.checks)


@dataclass(frozen=True)
class Sample:
    """The memory of the session [kB] at a time [s]."""

    at: float
    memory: int


def soak(plan: Plan, keep: Path | None, progress: Callable[[str, int], None]) -> Soaked:
    """Soak a session; its recording stays where told, or is gone in the end."""
    with tempfile.TemporaryDirectory(prefix="trainer-soak-") as folder:
        path = keep or Path(folder) / "soak.trainer"
        exercise = Path(folder) / "soak.toml"
        exercise.write_text(EXERCISE, encoding="utf-8")
        (Path(folder) / "boat.toml").write_text(endless_boat(), encoding="utf-8")
        return _soak(plan, exercise, path, progress)


def endless_boat() -> str:
    """Return BB2's file without what a day would end: her depths, her charge.

    Her hull would collapse, and after 14 h an empty battery would have her sink again and again.
    """
    lines = read_text(shipped_path("vessels", "bb2")).split("\n")
    depths = ("max_depth_m", "test_depth_m", "collapse_depth_m")
    text = "\n".join(line for line in lines if not line.startswith(depths))
    return re.sub(r"^capacity_kwh = .*$", f"capacity_kwh = {ENDLESS_KWH}", text, flags=re.MULTILINE)


def _soak(plan: Plan, exercise: Path, path: Path, progress: Callable[[str, int], None]) -> Soaked:
    pace = ("--speed", "1") if plan.real_time else ("--speed", "max", "--frozen")
    session = begin_watched(
        *(str(exercise), "--seed", str(plan.seed), "--record", str(path), *pace),
        *("--duration", f"{plan.seconds:g}"),
    )
    bill = Watchbill(session, _slowly if plan.real_time else _briskly)
    samples: list[Sample] = []
    begun = time.monotonic()
    ahead = 0
    with manning(bill, plan):
        latest = begun + plan.patience
        while session.running and not bill.over.is_set() and time.monotonic() < latest:
            samples.append(Sample(time.monotonic() - begun, session.memory()))
            ahead = max(ahead, _size(path.with_name(path.name + "-wal")))
            progress("soak", bill.tick)
            bill.over.wait(EVERY)
    wall = time.monotonic() - begun
    checks = [_check_end(session), *_check_account(session, plan)]
    checks.append(flat(samples, len(bill.answered)))
    checks += audit(path, bill.answered)
    return Soaked(
        plan=plan,
        wall_s=wall,
        orders=len(bill.answered),
        visits=bill.visits,
        recording_mb=_size(path) / 1e6,
        ahead_mb=ahead / 1e6,
        rescues=bill.rescues,
        lost_numbers=bill.failures,
        checks=checks,
    )


@contextlib.contextmanager
def manning(bill: Watchbill, plan: Plan) -> Iterator[None]:
    """Man the stations inside the block, while time runs. An operator's own fault ends it all."""
    first = bill.session.caller("instructor")
    first.ask("run")
    first.ask("detach")  # who comes now has command
    first.hang_up()
    with concurrent.futures.ThreadPoolExecutor(OPERATORS + 1) as pool:
        works = [
            pool.submit(attend, bill, plan.seed + number) for number in range(1, OPERATORS + 1)
        ]
        works.append(pool.submit(instruct, bill, plan.seed, goes_back=not plan.real_time))
        for work in works:
            work.add_done_callback(lambda _: bill.over.set())
        try:
            yield
        finally:
            bill.over.set()
    for work in works:
        if fault := work.exception():
            bill.session.kill()
            raise fault


def _briskly(dice: Random) -> float:
    return dice.uniform(0.0, 0.005)


def _slowly(dice: Random) -> float:
    return dice.expovariate(2.0)


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _check_end(session: SessionProcess) -> Check:
    """Return whether the session came to its own end; it is ended if it did not."""
    try:
        code = session.ended(PATIENCE)
    except subprocess.TimeoutExpired:
        session.kill()
        return Check("the session ends by itself", kept=False, seen="it had to be killed")
    seen = f"exit code {code}"
    troubles = [line for line in session.told if line.startswith("trainer: ")]
    seen += "".join(f"; {line}" for line in troubles)
    return Check("the session ends by itself", kept=code == 0, seen=seen)


def _check_account(session: SessionProcess, plan: Plan) -> list[Check]:
    """Return what the session's own account and the witness of its clock say."""
    if not plan.real_time:
        return []
    if not session.account:
        return [Check("the session accounts for its ticks", kept=False, seen="no account")]
    found = ON_TIME.search("\n".join(session.account))
    counts = [int(number) for number in found.groups()] if found else [-1]
    seen = found[0] if found else "no account"
    deadlines: dict[str, Any] = json.loads(session.account[-1])
    drift = (
        f"{deadlines['seen']} deadlines; {deadlines['adrift']} not at start + k h, "
        f"furthest {deadlines['furthest_ns']} ns"
    )
    return [
        Check("no tick is missed: none slipped, no gap", counts[-2:] == [0, 0], seen),
        Check(
            "no drift: deadline k is start + k h, to the nanosecond",
            not deadlines["adrift"] and deadlines["seen"] >= plan.ticks,
            drift,
        ),
    ]


def flat(samples: list[Sample], orders: int) -> Check:
    """Return whether the memory stays as it was after the warm-up."""
    end = samples[-1].at
    warm = [each.memory for each in samples if each.at > WARM_UP * end and each.memory]
    half = len(warm) // 2
    promise = f"memory grows by less than 1 MB, and 1 kB an order, after the first {WARM_UP:.0%}"
    if len(warm) < FEWEST:
        return Check(promise, kept=True, seen=f"not judged: {len(warm)} looks are too few")
    first, last = statistics.median(warm[:half]), statistics.median(warm[half:])
    between = orders * (1.0 - WARM_UP) / 2.0  # of the medians: they come evenly
    seen = (
        f"median {first / 1024:.1f} MB, then {last / 1024:.1f} MB: {last - first:+.0f} kB "
        f"over {between:.0f} orders and {len(warm)} looks; largest {max(warm) / 1024:.1f} MB"
    )
    return Check(promise, last - first <= GROWTH + ORDER_KB * between, seen)


def soaked_as_json(found: Soaked) -> str:
    """Return it as JSON."""
    return json.dumps({**asdict(found), "kept": found.kept}, indent=1)


def page(found: Soaked) -> str:
    """Return it as lines."""
    plan = found.plan
    kind = "real time" if plan.real_time else "full speed"
    lines = [
        f"{plan.seconds / 3600:g} h at {kind} in {found.wall_s:.0f} s, seed {plan.seed}",
        f"{found.orders} orders, {found.visits} visits of stations",
        f"recording {found.recording_mb:.0f} MB, written ahead {found.ahead_mb:.0f} MB at most",
        f"boat rescued {found.rescues} times, {len(found.lost_numbers)} with its numbers lost",
        *(f"{'kept  ' if c.kept else 'BROKEN'}  {c.promise}: {c.seen}" for c in found.checks),
    ]
    return "\n".join(lines)
