"""Damped sinusoids fitted to a response by least squares: program EC310.

``cli/workshop/programs`` has the command; [ASSES] is the report of 1969 on the programs. [ASSES] VI
with errata E4, E6: y = sum a_i exp(s_i t) + sum b_j exp(-alpha_j t) cos(beta_j t + c_j), one real
mode and one pair in the vertical plane, two and one in the horizontal. Starting roots are those of
the boat (EC140, EC200), or of the response itself by a matrix pencil where no boat is given; the
starting amplitudes follow from them linearly (EC120, EC150, EC330). Then all numbers are adjusted
together by Levenberg's and Marquardt's method.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.ship.series import Series
from trainer.core.kernel import Numbers
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, PAGE_WIDTH, cut_text, format_number, root_text, table

MAX_FIT_ROUNDS: Final = 200  # rounds, beyond which a fit is told as not settled
SLOPE_NUDGE: Final = 1e-6  # [-] of a number, for the difference quotients
ROOT_TOLERANCE: Final = 1e-10  # [-] a step that changes the roots by less is the last
MAX_ROOT_MOVE: Final = 0.3  # [-] of itself that a root moves in a round: real ones shall not meet
MAX_STEP_DAMPING: Final = 1e15  # [-] damping of the step beyond which no step helps
PENCIL_SAMPLES: Final = 800  # of the response, for the pencil's start
SAMPLES_PER_NUMBER: Final = 3  # of the response, for each number sought
# fmt: off
TERM_HEADS: Final = (
    "", "root\n[1/s]", "std error\n[1/s]", "|s|\n[rad/s]", "damping\nratio", "amplitude",
    "phase\n[rad]",
)
# fmt: on


@dataclass(frozen=True)
class FittedMode:
    """One fitted mode: exp(real t) amplitude cos(imaginary t + phase)."""

    real: float  # [1/s]
    imaginary: float  # [1/s] 0 for a real mode
    amplitude: float  # in the unit of the response at the first sample; signed for a real mode
    phase_rad: float  # 0 for a real mode
    real_error: float | None  # standard error [1/s]; None where the samples cannot tell
    imaginary_error: float | None

    @property
    def frequency(self) -> float:
        """Return |s| [rad/s]."""
        return math.hypot(self.real, self.imaginary)

    @property
    def damping_ratio(self) -> float:
        """Return -Re s/|s| [-], 0 for a root at zero."""
        return -self.real / self.frequency if self.frequency > 0.0 else 0.0


@dataclass(frozen=True)
class ModeFit:
    """Starting values and result; terms in the order of the starting roots."""

    start: tuple[FittedMode, ...]
    terms: tuple[FittedMode, ...]
    rms: float  # of what is left, in the unit of the response
    explained: float  # [-] share of the response's mean square
    converged: bool
    rounds: int


@dataclass(frozen=True)
class FitReport:
    """All that ``trainer report-1969 fit`` says about a response."""

    file: str
    column: str
    begin_s: float  # time of the first sample used, from which amplitudes count
    end_s: float
    samples: int
    about: float  # subtracted from the column before the fit
    roots_from: str  # where the starting roots come from
    fit: ModeFit


def one_of_each(roots: Sequence[complex]) -> list[complex]:
    """Return the real roots, and one of each pair with imaginary > 0.

    The fastest decay is first.
    """
    upper_roots = [complex(s) for s in roots if s.imag >= 0.0]
    return sorted(upper_roots, key=lambda s: s.real)


def columns(roots: Sequence[complex], t: Numbers) -> Numbers:
    """Return exp(s t) of real roots, (samples, n). Pairs have its real and imaginary part."""
    parts = []
    for s in roots:
        wave = np.exp(s * t)
        parts += [wave.real] if s.imag == 0.0 else [wave.real, wave.imag]
    return np.column_stack(parts)


def amplitudes(roots: Sequence[complex], t: Numbers, y: Numbers) -> Numbers:
    """Return the factors of ``columns`` that fit ``y`` best: the start by EC120, EC150, EC330."""
    return np.asarray(np.linalg.lstsq(columns(roots, t), y, rcond=None)[0])


def pencil_roots(t: Numbers, y: Numbers, order: int) -> list[complex]:
    """Return ``order`` roots [1/s] of a response. Hua and Sarkar (1990) give the matrix pencil.

    ConfigError if the samples do not hold that many.
    """
    grid = np.linspace(t[0], t[-1], min(len(t), PENCIL_SAMPLES))
    samples = np.interp(grid, t, y)
    width = len(grid) // 2
    hankel = np.lib.stride_tricks.sliding_window_view(samples, width + 1)
    _, sizes, rows = np.linalg.svd(hankel, full_matrices=False)
    if len(sizes) < order or sizes[order - 1] <= 1e-12 * sizes[0]:
        raise ConfigError(
            f"the response holds fewer than {order} modes; give the roots to start from by "
            "--vessel and --speed, or fewer with --order"
        )
    space = rows[:order].T
    values = np.linalg.eigvals(np.linalg.pinv(space[:-1]) @ space[1:])
    interval = grid[1] - grid[0]
    roots = []
    for z in values:
        # a negative real z alternates from sample to sample: noise, taken as a fast decay
        s = np.log(abs(z)) / interval + 1j * (np.angle(z) / interval if z.imag != 0.0 else 0.0)
        roots.append(complex(s))
    return roots


def _shape(roots: Sequence[complex]) -> Numbers:
    """Return the adjusted numbers: each root's real part, and each pair's imaginary part."""
    parts = [[s.real] if s.imag == 0.0 else [s.real, s.imag] for s in roots]
    return np.concatenate(parts)


def _match_roots(numbers: Numbers, like: Sequence[complex]) -> list[complex]:
    """Return the roots of ``numbers``, real where those of ``like`` are."""
    rest = iter(numbers)
    return [complex(next(rest), 0.0 if s.imag == 0.0 else next(rest)) for s in like]


class _Response:
    """The residual of a response, with the best amplitudes for given roots."""

    def __init__(self, t: Numbers, y: Numbers, like: Sequence[complex]) -> None:
        self.t, self.y, self.like = t, y, like

    def left(self, numbers: Numbers) -> Numbers:
        """Return samples less model; infinite where the model overflows."""
        roots = _match_roots(numbers, self.like)
        with np.errstate(over="ignore"):
            basis = columns(roots, self.t)
        if not np.isfinite(basis).all():
            return np.full_like(self.y, np.inf)
        factors = np.linalg.lstsq(basis, self.y, rcond=None)[0]
        return np.asarray(self.y - basis @ factors)

    def reach(self, numbers: Numbers) -> Numbers:
        """Return the largest change [1/s] of each number in a round."""
        slowest = 1.0 / (self.t[-1] - self.t[0])
        roots = _match_roots(numbers, self.like)
        sizes = [[max(abs(s), slowest)] * (1 if s.imag == 0.0 else 2) for s in roots]
        return np.asarray(MAX_ROOT_MOVE * np.concatenate(sizes))

    def slopes(self, numbers: Numbers) -> Numbers:
        """Return d(left)/d(numbers), (samples, numbers), by central differences."""
        slopes = []
        for i, number in enumerate(numbers):
            step = np.zeros_like(numbers)
            step[i] = SLOPE_NUDGE * max(abs(number), 1.0 / (self.t[-1] - self.t[0]))
            slopes.append((self.left(numbers + step) - self.left(numbers - step)) / (2.0 * step[i]))
        return np.column_stack(slopes)


def _adjust(response: _Response, numbers: Numbers) -> tuple[Numbers, int]:
    """Return the numbers of least squares, and the rounds taken: MAX_FIT_ROUNDS if not settled."""
    residual, damping = response.left(numbers), 1e-3
    misfit = float(residual @ residual)
    for done in range(1, MAX_FIT_ROUNDS):
        slopes = response.slopes(numbers)
        normal, downhill = slopes.T @ slopes, -slopes.T @ residual
        scale = np.diag(np.maximum(np.diag(normal), np.finfo(float).tiny))
        while True:
            step = np.linalg.lstsq(normal + damping * scale, downhill, rcond=None)[0]
            residual = response.left(numbers + step)
            tried = float(residual @ residual)
            if tried <= misfit and np.all(abs(step) <= response.reach(numbers)):
                break
            damping *= 4.0
            if damping > MAX_STEP_DAMPING:  # no step is better: the least there is
                return numbers, done
        numbers = numbers + step
        gain, misfit = misfit - tried, tried
        damping = max(damping / 8.0, 1e-14)
        if np.all(abs(step) <= ROOT_TOLERANCE * abs(numbers)) or gain <= ROOT_TOLERANCE**2 * misfit:
            return numbers, done
    return numbers, MAX_FIT_ROUNDS


def _terms(
    roots: Sequence[complex], factors: Numbers, errors: Sequence[float | None]
) -> tuple[FittedMode, ...]:
    """Return the terms of fitted ``roots``, their amplitudes and standard errors."""
    factor, error = iter(factors), iter(errors)
    terms = []
    for s in roots:
        if s.imag == 0.0:
            terms.append(FittedMode(s.real, 0.0, float(next(factor)), 0.0, next(error), None))
            continue
        cosine, sine = float(next(factor)), math.copysign(1.0, s.imag) * float(next(factor))
        size, phase = math.hypot(cosine, sine), math.atan2(-sine, cosine)
        terms.append(FittedMode(s.real, abs(s.imag), size, phase, next(error), next(error)))
    return tuple(terms)


def fit_modes(t: Numbers, y: Numbers, starts: Sequence[complex]) -> ModeFit:
    """Return the fit of ``y`` over ``t`` [s] from roots [1/s].

    There is one of each pair, imaginary > 0.

    The amplitudes count from the first sample. ConfigError if there are too few samples, or the
    response does not move.
    """
    t = t - t[0]
    sought = 2 * len(_shape(starts))
    if len(t) < SAMPLES_PER_NUMBER * sought:
        raise ConfigError(
            f"{len(t)} samples are too few for {sought} numbers; give {SAMPLES_PER_NUMBER * sought}"
        )
    if not np.any(y):
        raise ConfigError("the response is zero throughout: there is nothing to fit")
    response = _Response(t, y, starts)
    numbers, rounds = _adjust(response, _shape(starts))
    roots = _match_roots(numbers, starts)
    residual, slopes = response.left(numbers), response.slopes(numbers)
    nothing: list[float | None] = [None] * len(numbers)
    errors, free = nothing, len(residual) - 2 * len(numbers)
    if free >= 1 and np.linalg.matrix_rank(slopes) == len(numbers):
        spread = float(residual @ residual) / free * np.linalg.inv(slopes.T @ slopes)
        errors = [math.sqrt(max(float(variance), 0.0)) for variance in np.diag(spread)]
    return ModeFit(
        start=_terms(starts, amplitudes(starts, t, y), nothing),
        terms=_terms(roots, amplitudes(roots, t, y), errors),
        rms=math.sqrt(float(residual @ residual) / len(y)),
        explained=1.0 - float(residual @ residual) / float(y @ y),
        converged=rounds < MAX_FIT_ROUNDS,
        rounds=rounds,
    )


def response_of(terms: Sequence[FittedMode], t: Numbers) -> Numbers:
    """Return the sum of ``terms`` over ``t`` [s] from the first sample."""
    parts = [
        term.amplitude * np.exp(term.real * t) * np.cos(term.imaginary * t + term.phase_rad)
        for term in terms
    ]
    return np.asarray(sum(parts, np.zeros_like(t)))


def response_in(
    series: Series, column: str, span: tuple[float, float], about: float | None
) -> tuple[Numbers, Numbers, float]:
    """Return times [s] and response over ``span`` [s], and what was subtracted from the column.

    The value ``about`` is subtracted. By default it is the column's first value in the file,
    because the flight begins before the impulse.
    """
    values = series.column(column)
    level = float(values[0]) if about is None else about
    inside = (series.t >= span[0]) & (series.t <= span[1])
    if not inside.any():
        first, last = series.t[0], series.t[-1]
        raise ConfigError(
            f"{series.path}: no row from {span[0]:g} s to {span[1]:g} s; it has t from {first:g} "
            f"to {last:g} s"
        )
    return series.t[inside], values[inside] - level, level


def _row(label: str, term: FittedMode) -> tuple[str, ...]:
    """Return one term as a line of the table."""
    errors = [term.real_error, *([term.imaginary_error] if term.imaginary else [])]
    return (
        label,
        root_text(term.real, term.imaginary),
        "" if label == "start" else " ".join(format_number(error, ".0e") for error in errors),
        f"{term.frequency:.5f}",
        f"{term.damping_ratio:+.3f}",
        f"{term.amplitude:+.4g}",
        f"{term.phase_rad:+.3f}" if term.imaginary else "-",
    )


def render(report: FitReport) -> str:
    """Return the report as text."""
    fit = report.fit
    terms = [*(("start", term) for term in fit.start), *(("fit", term) for term in fit.terms)]
    rows = [_row(*each) for each in terms]
    state = f"settled in {fit.rounds} rounds" if fit.converged else "DID NOT SETTLE"
    return "\n".join(
        [
            f"FIT OF {report.column} (EC310)",
            f"{INDENT}{cut_text(report.file, PAGE_WIDTH - len(INDENT))}",
            f"{INDENT}{report.samples} samples, {report.begin_s:g} to {report.end_s:g} s",
            f"{INDENT}{report.about:.6g} taken off; starting roots from {report.roots_from}",
            "",
            *table(TERM_HEADS, rows),
            "",
            f"{INDENT}{state}; left over {fit.rms:.3g} rms, {fit.explained:.4%} explained",
        ]
    )


def panels(report: FitReport, t: Numbers, y: Numbers) -> tuple[Panel, ...]:
    """Return the panels of the response with its fit, and of the residual."""
    model = response_of(report.fit.terms, t - t[0])
    label = f"{report.column} less {report.about:.4g}"
    curves = (Curve("response", t, y), Curve("fit", t, model))
    residual_curve = (Curve("response less fit", t, y - model),)
    return (
        Panel(f"{report.column}, fitted", "time [s]", label, curves),
        Panel("what is left", "time [s]", label, residual_curve, levels=(0.0,)),
    )
