"""A continuous linear system over one sampling interval, exactly.

Equation numbers are those of the model document (MI): 7.1 matrices, 7.3 noise. Everything may be
complex, because an imaginary step of 1e-100 in one parameter carries its exact derivative through.
For real arrays the same source is compiled for real numbers, which are faster.

A system with states x and inputs u is one block matrix ``drift``: its rows are x, its columns (x,
u, 1): [A B f]. ``model/sampled`` calls ``propagate_blocks``, because readings come at moments and
motion is continuous.
"""

from trainer.identify.kernels.kernel import Entries, kernel, lean_kernel


@lean_kernel
def _times(left: Entries, right: Entries, factor: float, out: Entries) -> None:
    """Write the leading square of ``left`` times ``right`` and ``factor`` to ``out``."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            total = left[i, 0] * right[0, j]
            for k in range(1, out.shape[0]):
                total += left[i, k] * right[k, j]
            out[i, j] = total * factor


@kernel
def _propagate(
    drift: Entries, noise: Entries, h: complex, mean: Entries, covariance: Entries
) -> None:
    """Write [Phi Gamma] and the accumulated noise over ``h`` [s] (MI 7.1, 7.3).

    Power series over the short time h / 2^n, doubled n times. The exponential of MI 7.3 has -A in
    it, which grows without bound over a long interval; a doubling only goes forward in time.
    """
    rows, doublings, largest = drift.shape[0], 0, 0.0
    for i in range(rows):
        total = 0.0
        for j in range(rows):
            total += abs(drift[i, j].real)
        largest = max(largest, total * abs(h.real))
    # up to 0.5 the series are exact to rounding; 60 doublings bound the loop
    while largest > 0.5 and doublings < 60:
        largest *= 0.5
        doublings += 1
    A: Entries = drift * (h * 0.5**doublings)
    gathered: Entries = noise * (h * 0.5**doublings)
    term, product, half = A.copy(), A.copy(), gathered.copy()
    mean[:], covariance[:] = term, gathered
    for i in range(rows):
        mean[i, i] += 1.0
    # |A| h is at most 0.5 and stands left and right in the noise: below 1/20! = 4e-19 are left out
    for order in range(2, 20 if h != 0.0 else 2):  # in no time nothing moves
        _times(A, term, 1.0 / order, product)
        term, product = product, term
        mean += term
        _times(A, gathered, 1.0 / order, half)
        gathered = half + half.T
        covariance += gathered
    for _ in range(doublings):
        _times(mean, covariance, 1.0, half)
        _times(mean, half.T.copy(), 1.0, gathered)
        covariance += gathered
        term[:] = mean
        _times(term, term, 1.0, mean)
        mean[:, rows:] += term[:, rows:]


@kernel
def propagate_blocks(
    drift: Entries, noise: Entries, h: Entries, mean: Entries, covariance: Entries
) -> None:
    """Write [Phi Gamma] and the accumulated noise over each time.

    ``drift`` (b, x, x+u+1) and ``noise`` (b, x, x) are continuous systems, ``h`` (b, m) times [s],
    ``mean`` (b, m, x, x+u+1) and ``covariance`` (b, m, x, x) what is written.
    """
    for b in range(h.shape[0]):
        for m in range(h.shape[1]):
            _propagate(drift[b], noise[b], h[b, m], mean[b, m], covariance[b, m])
