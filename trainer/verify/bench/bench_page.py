"""The figures of ``trainer bench`` as a page for a terminal, 79 columns of ASCII."""

import textwrap
from collections.abc import Iterable

from trainer.session.time.ledger import Spread
from trainer.verify.bench.bench import Figures, Paced, Size
from trainer.verify.bench.latency import SPEED, Latency
from trainer.verify.bench.session_tick import Attended
from trainer.verify.bench.tick import BATCH_NS, BATCHES, Troubled, Update

WIDTH = 79


def render(figures: Figures) -> str:
    """Return the figures as text."""
    machine = figures.machine
    versions = f"python {machine.python}, numpy {machine.numpy}, numba {machine.numba}"
    lines = [
        *_wrap(figures.vessel),
        *_wrap(f"{machine.cpu_model} ({machine.cpu_target}), {machine.cpu_count} processors"),
        *_wrap(f"{machine.system}, {versions}"),
        *_real_time(figures.real_time),
        *_updates(figures.updates),
        *_extra_cost(figures.troubled),
        *_session_cost(figures.attended),
        *_latency(figures.latency),
        *_sizes(figures.sizes, figures.memory_1969_words_of_16_bits),
    ]
    return "\n".join(lines).encode("ascii", errors="replace").decode("ascii")


def _wrap(text: str) -> list[str]:
    """Return ``text`` in lines of the page."""
    return textwrap.wrap(text, WIDTH, subsequent_indent="  ")


def _real_time(paced: Iterable[Paced]) -> list[str]:
    """Return duty cycle, work and punctuality at each step."""
    lines = ["", "REAL TIME (modified set, lagged rates, adams2, a console; waiting is not work)"]
    for run in paced:
        duty = f"duty cycle {run.duty_cycle_percent:.4f} %"
        then = f"1969: {run.duty_cycle_1969_percent:g} %, {run.times_less_than_1969:.0f} times that"
        p99, p999 = _longest(run.samples_from_p99_up), _longest(run.samples_from_p999_up)
        missed = f"overruns {run.overruns}, caught up {run.caught_up}, slipped {run.skipped}"
        lines += [
            f"  step {run.step_s:g} s: {duty} ({then})",
            f"    {'[us]':<14}{'median':>10}{'99 %':>10}{'99.9 %':>10}{'most':>10}",
            _spread("work a tick", run.work),
            _spread("lateness", run.lateness),
            f"    {run.ticks} ticks: 99 % rests on the {p99}, 99.9 % on the {p999}",
            f"    {missed}, gaps {run.gaps}",
            f"    duty cycle of as many ticks without the recording {run.unrecorded_percent:.4f} %",
        ]
    return lines


def _spread(name: str, spread: Spread) -> str:
    """Return a row of percentiles [us]."""
    times = (spread.p50_ns, spread.p99_ns, spread.p999_ns, spread.max_ns)
    return f"    {name:<14}" + "".join(f"{time / 1e3:>10.1f}" for time in times)


def _longest(count: int) -> str:
    """Return in words so many of the longest."""
    return "longest one" if count == 1 else f"{count} longest"


def _updates(updates: Iterable[Update]) -> list[str]:
    """Return what an update costs, called and in a loop."""
    lines = [
        "",
        f"UPDATE, HOT ([ns], medians of {BATCHES} batches of {BATCH_NS / 1e6:g} ms or more)",
        f"  {'':<26}{'from Python':>12}{'in a kernel':>12}{'crossing':>10}{'ticks a batch':>16}",
    ]
    for update in updates:
        name = f"{update.equations} {update.rates} {update.integrator}"
        ticks = f"{update.called.repetitions}/{update.in_kernel.repetitions}"
        lines.append(
            f"  {name:<26}{update.called.median_ns:>12.0f}{update.in_kernel.median_ns:>12.0f}"
            f"{update.crossing_ns:>10.0f}{ticks:>16}"
        )
    return [
        *lines,
        "  (crossing: the difference of the two least, which the machine disturbs least)",
    ]


def _extra_cost(troubled: Troubled) -> list[str]:
    """Return what sea, tanks and casualties add to an update."""
    return [
        f"  with a sea, tanks at work and six casualties {troubled.troubled.median_ns:.0f}",
        f"  ({troubled.times_the_calm:.2f} times the calm one)",
    ]


def _session_cost(attended: Attended) -> list[str]:
    """Return what a tick of the session costs, by what attends to it."""
    names = ("boat", "bare session", "recorded", "5 subscribers", "a CSV row")
    costs = (
        *(attended.boat, attended.bare, attended.recorded, attended.subscribed),
        attended.csv_row,
    )
    return [
        "",
        "TICK OF A SESSION, HOT ([ns], likewise; modified lagged adams2)",
        "        " + "".join(f"{name:>14}" for name in names),
        "  median" + "".join(f"{cost.median_ns:>14.0f}" for cost in costs),
        "  least " + "".join(f"{cost.least_ns:>14.0f}" for cost in costs),
        (
            "  (recorded, with five subscribers at 10 Hz: "
            f"{attended.times_the_bare:.2f} times the bare session)"
        ),
    ]


def _latency(latency: Latency) -> list[str]:
    """Return how soon orders over TCP are answered and act."""
    most = latency.ticks_to_effect_most
    effect = f"{most} tick{'s' * (most != 1)} at most" if most else "none: this boat has no rudder"
    period = f"{1e3 * latency.tick_s:g} ms"
    return [
        "",
        f"ORDERS OVER TCP (five subscribers, time x{SPEED:g}: a tick each {period})",
        f"    {'[us]':<14}{'median':>10}{'99 %':>10}{'99.9 %':>10}{'most':>10}",
        _spread("reply", latency.reply),
        f"    {latency.orders} orders; from order to effect: {effect}",
    ]


def _sizes(sizes: dict[str, Size], memory: int) -> list[str]:
    """Return the sizes of the records."""
    lines = ["", "RECORDS", f"  {'':<14}{'bytes':>8}{'16-bit words':>14}"]
    for name, size in sizes.items():
        lines.append(f"  {name:<14}{size.bytes:>8}{size.words_of_16_bits:>14}")
    total = sum(size.bytes for size in sizes.values())
    lines.append(f"  {'all':<14}{total:>8}{total // 2:>14}   of {memory} words in 1969")
    return lines
