"""Recursions of the ARMAX model, section 9: filters by 1/C and their sensitivities."""

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import kernel


@kernel
def filter_by_c(c: Numbers, x: Numbers, out: Numbers) -> None:
    """Write x/C(q) to ``out`` (N,).

    C = 1 + c1 q^-1 + ...; the filter is at rest before the first sample.
    """
    for t in range(x.size):
        total = x[t]
        for i in range(min(c.size, t)):
            total -= c[i] * out[t - 1 - i]
        out[t] = total


@kernel
def combine(a: Numbers, b: Numbers, y: Numbers, u: Numbers, out: Numbers) -> None:
    """Write A(q) y - B(q) u to ``out`` (N,), with zeros before the first sample.

    A = 1 + a1 q^-1 + ..., B = b1 q^-1 + ....
    """
    for t in range(y.size):
        total = y[t]
        for i in range(min(a.size, t)):
            total += a[i] * y[t - 1 - i]
        for i in range(min(b.size, t)):
            total -= b[i] * u[t - 1 - i]
        out[t] = total


@kernel
def simulate_armax(a: Numbers, b: Numbers, u: Numbers, disturbance: Numbers, out: Numbers) -> None:
    """Write the response of an ARMAX model to ``out`` (N,).

    It is y of A(q) y = B(q) u + ``disturbance``, at rest before the first sample.
    """
    for t in range(u.size):
        total = disturbance[t]
        for i in range(min(a.size, t)):
            total -= a[i] * out[t - 1 - i]
        for i in range(min(b.size, t)):
            total += b[i] * u[t - 1 - i]
        out[t] = total
