"""Systems in TOML files, their matrices made of expressions of parameters.

``options`` reads them for ``--system``. An expression is read as a tree of numbers, names, + - * /
** and a few functions. Anything else is refused and nothing is run as a program, because a file may
come from anybody. Values may be complex: an imaginary step carries a derivative. A Python file is a
program, and is run when it is loaded.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, Position, offer_known, parse_toml, quote, read_text
from trainer.config.schema import (
    Choice,
    Flag,
    KeyForm,
    Rows,
    Text,
    Texts,
    optional,
    read_record,
    required,
    with_default,
    within,
)
from trainer.identify.kernels.kernel import Entries
from trainer.identify.model.models import Parameter
from trainer.identify.model.own_systems import (
    MATRIX_NAMES,
    MAX_DIMENSION,
    Matrices,
    System,
    check_names,
    check_shapes,
    load_program,
    with_kinds,
)

Row = tuple[object, ...]  # of a matrix
Value = Any  # a number, or an array of them
Expression = Callable[[Mapping[str, Value]], Value]

# A file may come from anybody: the limits bound the work of an expression.
MAX_EXPRESSION_LETTERS: Final = 200  # characters
MAX_EXPRESSION_DEPTH: Final = 30  # signs within signs
NAMED_CONSTANTS: Final = {"pi": math.pi}
OPERATOR_BY_SIGN: Final[Mapping[type, Callable[..., Value]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,  # numpy's, because they give infinity or NaN where Python's would raise
    ast.Pow: np.power,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def _magnitude(x: Value) -> Value:
    """Return |x| of a number whose imaginary part is a derivative."""
    return np.where(np.real(x) >= 0.0, x, -x)


KNOWN_FUNCTIONS: Final[Mapping[str, Callable[[Value], Value]]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "abs": _magnitude,
}
ALLOWED_TEXT: Final = (
    f"numbers, parameters, + - * / **, {', '.join((*NAMED_CONSTANTS, *KNOWN_FUNCTIONS))}"
)


def parse_expression(text: str, names: tuple[str, ...]) -> Expression:
    """Return the expression in ``text`` of parameters ``names``; ConfigError if it is none."""
    if len(text) > MAX_EXPRESSION_LETTERS:
        raise ConfigError(
            f"expression of {len(text)} characters: must have {MAX_EXPRESSION_LETTERS} at most"
        )
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ConfigError(f"{quote(text)}: is no expression; it may have {ALLOWED_TEXT}") from None
    return _built(tree.body, names, 0)


def _built(node: ast.expr, names: tuple[str, ...], depth: int) -> Expression:
    """Return a function that computes one node of the tree from the parameters' values."""
    if depth > MAX_EXPRESSION_DEPTH:
        raise ConfigError(f"expression: {MAX_EXPRESSION_DEPTH} signs within one another at most")
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            raise ConfigError(f"{quote(node.value)}: is no number; there may be {ALLOWED_TEXT}")
        try:
            value = float(node.value)
        except OverflowError:  # an integer of more than 308 digits
            value = math.inf
        if not math.isfinite(value):
            raise ConfigError("expression: a number is too large")
        return lambda _: value
    if isinstance(node, ast.Name):
        name, known = node.id, (*names, *NAMED_CONSTANTS)
        if name not in known:
            raise ConfigError(f"no parameter {quote(name)}{offer_known(name, known)}")
        return lambda values: values[name] if name in names else NAMED_CONSTANTS[name]
    function, operands = _sign_of(node)
    parts = tuple(_built(part, names, depth + 1) for part in operands)
    return lambda values: function(*(part(values) for part in parts))


def _sign_of(node: ast.expr) -> tuple[Callable[..., Value], list[ast.expr]]:
    """Return the function of a sign or name, and its operands; ConfigError for anything else."""
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATOR_BY_SIGN:
        return OPERATOR_BY_SIGN[type(node.op)], [node.left, node.right]
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATOR_BY_SIGN:
        return OPERATOR_BY_SIGN[type(node.op)], [node.operand]
    if not isinstance(node, ast.Call) or len(node.args) != 1 or node.keywords:
        raise ConfigError(f"{quote(ast.unparse(node))}: there may be only {ALLOWED_TEXT}")
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    if name not in KNOWN_FUNCTIONS:
        raise ConfigError(f"no function {quote(name)}{offer_known(name, KNOWN_FUNCTIONS)}")
    return KNOWN_FUNCTIONS[name], node.args


@dataclass(frozen=True)
class Matrix:
    """A list of rows, or a list of numbers, whose entries are numbers or expressions."""

    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        entry = {"type": ["number", "string"]}
        rows = {"type": "array", "items": {"anyOf": [entry, {"type": "array", "items": entry}]}}
        return KeyForm("rows", "numbers or expressions", self.meaning, rows)

    def read(self, key: str, value: object, position: Position) -> tuple[Row, ...]:
        """Return the rows; ConfigError if they are not of one length."""
        if isinstance(value, list) and 0 < len(value) <= MAX_DIMENSION:
            rows = tuple(tuple(row) if isinstance(row, list) else (row,) for row in value)
            if len({len(row) for row in rows}) == 1 and len(rows[0]) <= MAX_DIMENSION:
                return rows
        text = f"must be 1 to {MAX_DIMENSION} rows of one length, each a list"
        raise ConfigError(position.wrong(key, value, text))


@dataclass(frozen=True, kw_only=True)
class SystemParameter:
    """One parameter of a system."""

    name: str = required(Text(20, "a letter, then letters, digits or _"))
    start: float = required("-", within(-1e12, 1e12), "where the search begins")
    free: bool | None = optional(Flag("is it estimated? else true"))
    unit: str = with_default("-", Text(12, "for the page; else none"))
    meaning: str = with_default("", Text(79, "for the reader"))


SYSTEM_PARAMETERS: Final = Rows(SystemParameter, ("note",), 1, 60, "parameters, below")


@dataclass(frozen=True, kw_only=True)
class SystemFile:
    """A system of a TOML file, in matrices."""

    schema: str = required(Choice(("system/1",), "form of the file"))
    name: str = required(Text(79, "what it is"))
    time: str = with_default(
        "continuous",
        Choice(("continuous", "discrete"), "discrete matrices lead to the next sample"),
    )
    inputs: tuple[str, ...] = with_default((), Texts(Text(80, "columns that act"), MAX_DIMENSION))
    outputs: tuple[str, ...] = required(Texts(Text(80, "columns that are fitted"), MAX_DIMENSION))
    units: tuple[str, ...] | None = optional(Texts(Text(12, "of the outputs"), MAX_DIMENSION))
    A: tuple[Row, ...] = required(Matrix("states by states"))
    B: tuple[Row, ...] | None = optional(Matrix("states by inputs"))
    f: tuple[Row, ...] | None = optional(Matrix("a constant on each state; else 0"))
    C: tuple[Row, ...] = required(Matrix("outputs by states"))
    D: tuple[Row, ...] | None = optional(Matrix("outputs by inputs; else 0"))
    d: tuple[Row, ...] | None = optional(Matrix("a bias of each output; else 0"))
    R1: tuple[Row, ...] | None = optional(Matrix("states by states, disturbance; else 0"))
    R2: tuple[Row, ...] | None = optional(Matrix("outputs by outputs, errors; else 0"))
    R12: tuple[Row, ...] | None = optional(Matrix("states by outputs, both; else 0"))
    x0: tuple[Row, ...] | None = optional(Matrix("first state; else 0"))
    P0: tuple[Row, ...] | None = optional(Matrix("its covariance; else 0"))
    K: tuple[Row, ...] | None = optional(Matrix("states by outputs, gain of innovations"))


def load_system(path: Path) -> System:
    """Return the system in a TOML file or a program, which is run. ConfigError if it is none."""
    system = load_program(path) if path.suffix == ".py" else _load_file(path)
    check_shapes(system)
    return with_kinds(system)


def _load_file(path: Path) -> System:
    """Return the system of a TOML file, its expressions parsed; ConfigError with all faults."""
    table, position = parse_toml(read_text(path), path.name), Position(path.name, "")
    heading_values = {key: value for key, value in table.items() if key != "parameters"}
    file = read_record(SystemFile, heading_values, position, ("note",))
    rows = SYSTEM_PARAMETERS.read("parameters", table.get("parameters", []), position)
    names = tuple(row.name for row in rows)
    check_names(path, names)
    for name in names:
        if name in KNOWN_FUNCTIONS or name in NAMED_CONSTANTS:
            message = "is the name of a function or constant"
            raise ConfigError(f"{path.name}: parameter {quote(name)}: {message}")
    matrices = {
        name: getattr(file, name) for name in MATRIX_NAMES if getattr(file, name) is not None
    }
    problems, parsed = [], {}
    for key, entries in matrices.items():
        try:
            parsed[key] = [[_entry(one, names) for one in row] for row in entries]
        except ConfigError as wrong:
            problems.append(position.problem(f"{key}: {wrong}"))
    if problems:
        raise ConfigError(*problems)
    return System(
        path=path,
        name=file.name,
        discrete=file.time == "discrete",
        inputs=file.inputs,
        outputs=file.outputs,
        units=file.units or ("-",) * len(file.outputs),
        parameters=tuple(Parameter(row.name, row.unit) for row in rows),
        starts=np.array([row.start for row in rows]),
        held=tuple(row.name for row in rows if row.free is False),
        states=len(file.A),
        matrices=partial(_fill_matrices, names, parsed),
    )


def _entry(value: object, names: tuple[str, ...]) -> float | Expression:
    """Return a number or an expression; ConfigError if it is neither."""
    if isinstance(value, str):
        return parse_expression(value, names)
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > 1e300:
        raise ConfigError(f"{quote(value)}: must be a number or an expression")
    return float(value)


def _fill_matrices(
    names: tuple[str, ...], entries: Mapping[str, list[list[float | Expression]]], theta: Entries
) -> Matrices:
    """Return the matrices of a TOML file for each row of parameters."""
    values, matrices = dict(zip(names, theta.T, strict=True)), {}
    with np.errstate(all="ignore"):  # a search may try impossible values: they give NaN
        for name, rows in entries.items():
            out = np.zeros((len(theta), len(rows), len(rows[0])), theta.dtype)
            for i, row in enumerate(rows):
                for j, entry in enumerate(row):
                    out[:, i, j] = entry if isinstance(entry, float) else entry(values)
            matrices[name] = out
    return matrices
