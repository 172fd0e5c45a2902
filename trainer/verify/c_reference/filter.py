"""The likelihood in C, of a problem's parameters."""

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.problem import Problem
from trainer.verify.c_reference.compiler import compile_source

Value = Callable[[], float]  # minus the log-likelihood [-], the same again at each call

SOURCE: Final = Path(__file__).parent / "likelihood.c"
MOST, WIDEST = 12, 24  # [-] rows and columns that the C has room for


def likelihood_in_c() -> Callable[[Problem, Numbers], Value]:
    """Return what makes the likelihood in C of a problem; NoCompilerError without a compiler.

    The continuous matrices are ours, and made before; sampling and filter are C's.
    """
    function = compile_source(SOURCE, ["-O3"]).minus_log_likelihood
    address, whole, real = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
    function.argtypes = [*[address] * 4, real, address, whole, address, address, whole, address]
    function.restype = real

    def of(problem: Problem, theta: Numbers) -> Value:
        intervals, which = problem.samples.steps
        table = problem.samples.table
        states, readings = problem.plant.model.states, problem.samples.outputs.shape[1]
        sizes = np.array([states, problem.samples.inputs.shape[1], readings], np.intc)
        room = np.empty((len(intervals), MOST * (WIDEST + MOST)))
        blocks = problem.plant.blocks(problem.whole(theta)[None])
        arrays = (sizes, blocks.drift, blocks.noise, blocks.start, intervals, table, which, room)
        places = [each.ctypes.data_as(address) for each in arrays]  # which hold the arrays
        lag, count, rows = float(blocks.lag[0]), len(intervals), len(table)
        arguments = (*places[:4], lag, places[4], count, *places[5:7], rows, places[7])
        return lambda: float(function(*arguments))

    return of
