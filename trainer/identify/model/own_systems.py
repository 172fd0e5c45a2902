"""A user's own system has matrices that are functions of its parameters.

``study_problem`` fits it by the same searches as the trainer's own models.

    dx = (A x + B u + f) dt + dw,  y = C x + D u + d + e      E dw dw' = R1 dt, cov e = R2
    x+ = A x + B u + f + w         where the time is discrete, cov w = R1, cov (w, e) = R12

x begins at x0 with covariance P0; K is the gain of a predictor, from reading to the next state.
Numbers are in the units of the record's columns. A Python file is a program: who loads it runs it.
"""

import math
import runpy
from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, quote, raise_problems
from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Entries
from trainer.identify.kernels.ship_models import ModelBlocks
from trainer.identify.model.models import Model, Parameter, Plant
from trainer.identify.model.sampled import COMPLEX_STEP, step_aside

Matrices = dict[str, Entries]  # by name, (b, rows, columns)
Function = Callable[[Entries], Matrices]

TUPLE_ORDER: Final = ("A", "B", "C", "D", "R1", "R2", "x0", "P0")  # of a function's tuple
MATRIX_NAMES: Final = (*TUPLE_ORDER, "f", "d", "R12", "K")
NOISE_MATRICES: Final = {"R1", "R2", "R12", "P0"}
MAX_DIMENSION: Final = 20  # states, inputs, outputs
# Derivatives are imaginary parts of the order of COMPLEX_STEP = 1e-100. A larger one than this is
# no derivative but the root of a negative number.
MAX_STRAY_IMAGINARY: Final = 1e-50
NO_MATRIX: Final[Numbers] = np.zeros((1, 0, 0))
SLOPE_TOLERANCE: Final = 1e-4  # [-] of slopes by an imaginary step against those by differences


@dataclass(frozen=True, eq=False)
class System:
    """A system whose matrices are a function of its parameters (b, n)."""

    path: Path
    name: str
    discrete: bool
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    starts: Numbers  # (n,)
    held: tuple[str, ...]  # parameters that are not estimated
    states: int
    matrices: Function
    how: str = ""  # of derivatives
    touched: Mapping[str, frozenset[str]] = field(default_factory=dict)  # by parameter: matrices

    def only_in(self, matrices: set[str]) -> tuple[str, ...]:
        """Return the parameters that act on some of these matrices and on no other.

        A noise model without these matrices cannot estimate them.
        """
        return tuple(name for name, found in self.touched.items() if found and found <= matrices)

    @cached_property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Return first state and its variance, where each is one parameter and nothing else.

        One record cannot tell both of a pair, so a fit refuses to estimate both.
        """
        matrices, names = self.matrices(step_aside(self.starts)), list(self.touched)
        pairs = []
        for i in range(self.states):
            alone = [
                names[k]
                for key, j in (("x0", 0), ("P0", i))
                for k in (np.flatnonzero(matrices[key][1:, i, j].imag) if key in matrices else ())
            ]
            if len(alone) == 2:
                pairs.append((alone[0], alone[1]))
        return tuple(pairs)

    def assemble(self, theta: Entries, ship: Numbers, blocks: ModelBlocks) -> Entries | None:
        """Write the blocks, see ModelBlocks; return the gain (b, x, y) if it has one."""
        del ship
        drift, noise, start, _ = blocks
        x, u = self.states, self.states + len(self.inputs)
        bounded = [i for i, one in enumerate(self.parameters) if one.kind != "free"]
        theta = theta.copy()
        # a variance counts by its magnitude, so that a search may step below zero
        theta[:, bounded] = np.where(
            theta[:, bounded].real < 0.0, -theta[:, bounded], theta[:, bounded]
        )
        matrices = self.matrices(theta)
        for key, matrix in matrices.items():
            if np.iscomplexobj(matrix):
                stray = np.abs(matrix.imag) > MAX_STRAY_IMAGINARY
                matrices[key] = np.where(stray, math.nan, matrix)
        indices = {
            "A": (drift, slice(x), slice(x)),
            "B": (drift, slice(x), slice(x, u)),
            "f": (drift, slice(x), slice(u, None)),
            "C": (drift, slice(x, None), slice(x)),
            "D": (drift, slice(x, None), slice(x, u)),
            "d": (drift, slice(x, None), slice(u, None)),
            "R1": (noise, slice(x), slice(x)),
            "R2": (noise, slice(x, None), slice(x, None)),
            "x0": (start, slice(None), slice(1)),
            "P0": (start, slice(None), slice(1, None)),
        }
        for key, (out, rows, columns) in indices.items():
            if key in matrices:
                out[:, rows, columns] = matrices[key]
        if "R12" in matrices:
            noise[:, :x, x:] = matrices["R12"]
            noise[:, x:, :x] = matrices["R12"].swapaxes(1, 2)
        return matrices.get("K")

    @cached_property
    def quantities(self) -> dict[str, str]:
        """Return the names of what ``tell`` computes, and units."""
        units = {"1/T1": "1/s"}
        for i in range(1, 1 + self.states):
            units |= {f"T{i}": "s", f"period {i}": "s"}
        for output, unit in zip(self.outputs, self.units, strict=True):
            units |= {f"{name} to {output}": unit for name in self.inputs}
        return units

    def tell(self, plant: Plant, values: Numbers) -> Numbers:
        """Return what the page tells of the system: time constants, periods and steady gains.

        First is -Re of the slowest root, then T and period of each root. A real root has period 0.
        A complex pair has T and period at its first root; both are 0 at its second.
        """
        drift, x = np.nan_to_num(plant.blocks(values[None]).drift[0]), self.states
        A, B, C, D = drift[:x, :x], drift[:x, x:-1], drift[x:, :x], drift[x:, x:-1]
        roots = np.linalg.eigvals(A)
        if self.discrete:
            # roots of one step become those of continuous time; A - I has the same steady gains
            with np.errstate(all="ignore"):
                roots, A = np.log(roots + 0j) / plant.period, A - np.eye(x)
        roots = roots[np.lexsort((-roots.imag, -roots.real))]
        numbers = [-roots[0].real]
        for root in roots:
            second = root.imag < 0.0
            slow = -1.0 / root.real if root.real else math.inf
            numbers += [0.0 if second else slow, 0.0 if root.imag <= 0.0 else math.tau / root.imag]
        regular = np.linalg.matrix_rank(A) == len(A)
        gain = D - C @ np.linalg.solve(A, B) if regular else np.full_like(D, math.nan)
        return np.array([*numbers, *gain.ravel()])


def check_names(path: Path, names: Sequence[str]) -> None:
    """Check the names of parameters; ConfigError naming the first that is none."""
    for i, name in enumerate(names):
        plain = name.isascii() and name.isidentifier() and not name.startswith("_")
        why = "" if plain else "must be a letter, then letters, digits or _"
        why = why or ("is given twice" if name in names[:i] else "")
        if why:
            raise ConfigError(f"{path.name}: parameter {quote(name)}: {why}")


def load_program(path: Path) -> System:
    """Return the system of a Python file, which is run. ConfigError if it fails or lacks a part."""
    try:
        program = runpy.run_path(str(path))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except Exception as error:
        raise ConfigError(f"{path}: {_failed(error, path)}") from error
    lacking = [name for name in ("matrices", "outputs", "parameters") if name not in program]
    if lacking:
        raise ConfigError(f"{path}: lacks {', '.join(lacking)}")
    starts = dict(program["parameters"])
    check_names(path, tuple(starts))
    outputs, inputs = tuple(program["outputs"]), tuple(program.get("inputs", ()))
    vector = np.array([float(value) for value in starts.values()])
    plain = _FunctionMatrices(path, program["matrices"], tuple(starts))
    matrices = plain(vector[None])
    if "A" not in matrices or "C" not in matrices:
        raise ConfigError(f"{path}: matrices() gives no A and C at the start values")
    states = matrices["A"].shape[1]
    function, how = _stepped(plain, vector)
    return System(
        path=path,
        name=str(program.get("name", path.stem)),
        discrete=bool(program.get("discrete", False)),
        inputs=inputs,
        outputs=outputs,
        units=tuple(program.get("units", ("-",) * len(outputs))),
        parameters=tuple(Parameter(name, "-") for name in starts),
        starts=vector,
        held=tuple(program.get("held", ())),
        states=states,
        matrices=function,
        how=how,
    )


def _failed(error: Exception, path: Path) -> str:
    """Return in one line what went wrong in a program, and where."""
    line, trace = 0, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(path):
            line = trace.tb_lineno
        trace = trace.tb_next
    reason = str(error) if isinstance(error, _ReturnedError) else f"{type(error).__name__}: {error}"
    return (f"line {line}: {reason}" if line else reason).splitlines()[0]


class _ReturnedError(ValueError):
    """The value that a function returned is no set of matrices."""


class _FunctionMatrices:
    """The matrices of a Python function, one row of parameters at a time."""

    def __init__(self, path: Path, function: Callable[..., Any], names: tuple[str, ...]) -> None:
        self._path = path
        self._function = function
        self._theta = namedtuple("theta", names)  # type: ignore[misc]  # noqa: PYI024

    def __call__(self, theta: Entries) -> Matrices:
        """Return the matrices of each row of parameters.

        They are NaN in a row for which the function fails on the numbers, so that a search turns
        back.
        """
        rows = [self._row(row) for row in theta]
        known = {key: value.shape for row in rows for key, value in row.items()}
        nothing = {key: np.full(shape, math.nan) for key, shape in known.items()}
        return {key: np.array([row.get(key, nothing[key]) for row in rows]) for key in known}

    def _row(self, theta: Entries) -> Matrices:
        try:
            with np.errstate(all="ignore"):
                matrices = self._function(self._theta(*theta))
            if isinstance(matrices, tuple | list) and len(matrices) == len(TUPLE_ORDER):
                matrices = dict(zip(TUPLE_ORDER, matrices, strict=True))
            if not isinstance(matrices, Mapping):
                message = f"must return {', '.join(TUPLE_ORDER)}, or some matrices by name"
                raise _ReturnedError(message)  # noqa: TRY301
            return {key: _as_matrix(key, one) for key, one in matrices.items() if one is not None}
        except (ArithmeticError, np.linalg.LinAlgError):
            return {}
        except Exception as error:
            message = _failed(error, self._path)
            raise ConfigError(f"{self._path}: matrices(): {message}") from error


def _as_matrix(name: str, value: Any) -> Entries:
    """Return a matrix (rows, columns), a vector as a column. ValueError if it is none."""
    if name not in MATRIX_NAMES:
        raise _ReturnedError(f"no matrix {name!r}; there are {', '.join(MATRIX_NAMES)}")
    try:
        matrix = np.asarray(value)
    except ValueError:
        matrix = np.asarray(None)
    if matrix.dtype.kind not in "iufc" or matrix.ndim > 2:  # i, u, f, c: kinds of numbers
        raise _ReturnedError(f"{name} is not made of rows of numbers")
    return matrix[:, None] if matrix.ndim == 1 else np.atleast_2d(matrix)


def _stepped(function: _FunctionMatrices, start: Numbers) -> tuple[Function, str]:
    """Return the function with derivatives, and how they are computed.

    An imaginary step goes through most programs, and is exact. A program that loses it (by abs,
    max, math.sin or float) gives other slopes than differences do; then differences are used.
    """
    plain = _by_differences(function, step_aside(start))
    try:
        matrices = function(step_aside(start))
    except ConfigError:
        matrices = {}
    slopes = [
        {key: one[1:].imag / COMPLEX_STEP for key, one in each.items()}
        for each in (matrices, plain)
    ]
    sizes = [float(np.max(np.abs(one), initial=0.0)) for one in slopes[1].values()]
    largest = max(sizes, default=0.0)
    agree = matrices.keys() == plain.keys() and all(
        np.allclose(
            slopes[0][key], one, rtol=SLOPE_TOLERANCE, atol=SLOPE_TOLERANCE * 1e-3 * largest
        )
        for key, one in slopes[1].items()
    )
    if agree:
        return function, "complex step"
    return (lambda theta: _by_differences(function, theta)), "differences"


def _by_differences(function: _FunctionMatrices, theta: Entries) -> Matrices:
    """Return matrices whose imaginary parts are central differences, where ``theta`` has any."""
    matrices = function(np.ascontiguousarray(theta.real))
    if not np.iscomplexobj(theta):
        return matrices
    matrices = {key: one.astype(complex) for key, one in matrices.items()}
    for row, index in zip(*np.nonzero(theta.imag), strict=True):
        # about the cube root of rounding: best for central differences
        step = 6e-6 * max(abs(theta[row, index].real), 1e-3)
        beside = np.tile(theta[row].real, (2, 1))
        beside[:, index] += (step, -step)
        part = theta[row, index].imag
        for key, two in function(beside).items():
            matrices[key][row] += 1j * part * (two[0] - two[1]) / (beside[0] - beside[1])[index]
    return matrices


def check_shapes(system: System) -> None:
    """Check sizes of matrices and covariances at the start; ConfigError with all faults."""
    matrices, problems = system.matrices(system.starts[None]), []
    sizes = {"x": system.states, "u": len(system.inputs), "y": len(system.outputs)}
    words = {"x": "states", "u": "inputs", "y": "outputs"}
    shapes = {"A": "xx", "B": "xu", "C": "yx", "D": "yu", "R1": "xx", "R2": "yy", "P0": "xx"}
    shapes |= {"R12": "xy", "K": "xy", "x0": "x1", "f": "x1", "d": "y1"}
    for key in (*(("A", "C") if "A" not in matrices or "C" not in matrices else ()), *matrices):
        if key not in matrices:
            problems.append(f"lacks {key}")
            continue
        rows, columns = matrices[key].shape[1:]
        wanted = tuple(sizes.get(sign, 1) for sign in shapes[key])
        if (rows, columns) != wanted:
            by = " by ".join(words.get(sign, "1") for sign in shapes[key])
            must = f"must be {wanted[0]} by {wanted[1]}, {by}"
            problems.append(f"{key} is {rows} by {columns}, {must}")
        elif not np.isfinite(matrices[key]).all():
            problems.append(f"{key} is not finite at the start values")
        elif key in ("R1", "R2", "P0") and not _is_covariance(matrices[key][0]):
            problems.append(f"{key} is no covariance at the start values")
    if len(set(system.outputs)) < len(system.outputs) or not system.outputs:
        problems.append("outputs must be one column or more, each once")
    if len(system.units) != len(system.outputs):
        problems.append("units must be as many as outputs")
    raise_problems([f"{system.path.name}: {problem}" for problem in problems])


def _is_covariance(matrix: Numbers) -> bool:
    """Return whether a matrix is symmetric and has no negative eigenvalue."""
    size = float(np.max(np.abs(matrix), initial=0.0))
    symmetric = np.allclose(matrix, matrix.T, atol=1e-9 * size)
    return bool(symmetric and np.linalg.eigvalsh(matrix)[0] >= -1e-9 * size)


def with_kinds(system: System) -> System:
    """Return the system with what depends on each parameter, and variances known as such.

    A parameter that is an entry on the diagonal of a covariance, and no other part of it, is a
    variance and is bounded; one in R2 is an error of readings.
    """
    start = system.starts
    touched: dict[str, set[str]] = {one.name: set() for one in system.parameters}
    for theta in (start, 1.17 * start + 0.013):  # a slope may be nothing at one point
        for key, matrix in system.matrices(step_aside(theta)).items():
            for index, slope in enumerate(matrix[1:].imag):
                if np.any(slope != 0.0):
                    touched[system.parameters[index].name].add(key)
    at_start = system.matrices(step_aside(start))
    kinds = {}
    for key in ("P0", "R1", "R2"):
        for value in np.diagonal(at_start.get(key, NO_MATRIX), axis1=1, axis2=2).T:
            slopes = value[1:].imag / COMPLEX_STEP
            indices = np.flatnonzero(slopes)
            # slope 1, and the parameter's own value: the entry is the parameter
            alone = len(indices) == 1 and abs(slopes[indices[0]] - 1.0) < 1e-6
            if alone and value[0].real == start[indices[0]]:
                kinds[int(indices[0])] = "error" if key == "R2" else "variance"
    parameters = tuple(
        replace(one, kind=kinds.get(index, "free")) for index, one in enumerate(system.parameters)
    )
    known = {name: frozenset(where) for name, where in touched.items()}
    return replace(system, parameters=parameters, touched=known)


def model_of(system: System) -> Model:
    """Return the model of a system, which the estimation takes like any other."""
    parts = system.parameters, system.outputs, system.states, system.assemble
    return Model("own", *parts, inputs=len(system.inputs), system=system)
