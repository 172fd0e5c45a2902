"""Simulation of a sampled system with noise that is already drawn."""

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.blocks import put
from trainer.identify.kernels.covariance_filter import Places, predict
from trainer.identify.kernels.kernel import kernel


@kernel
def simulate(
    mean: Numbers, first: Numbers, inputs: Numbers, which: Places, noise: Numbers, out: Numbers
) -> None:
    """Write states and readings (n, x+y) to ``out``.

    ``first`` (x,), ``inputs`` (n, 2u) old and new, ``noise`` (n, x+y) of the next state and of the
    reading. The state in ``out`` is that at the sample.
    """
    rows, columns = mean.shape[1:]
    states = first.size
    z, v = np.ones(columns), np.empty(rows)
    put(first, 0, z)
    for k in range(which.size):
        put(inputs[k], states, z)
        predict(mean[which[k]], z, v)
        for i in range(states):
            out[k, i] = z[i]
            z[i] = v[i] + noise[k, i]
        for i in range(states, rows):
            out[k, i] = v[i] + noise[k, i]
