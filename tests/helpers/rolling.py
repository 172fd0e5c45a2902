"""Records of a made oscillator, a hull that rolls under its fins, and files of its system."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import expm

W, Z, K, Q, S = 0.5, 0.12, 1.5, 2e-4, 0.04  # frequency, damping, gain, disturbance, error
STEP = 0.5

SYSTEM = """
schema = "system/1"
name = "Rolling under fins"
inputs = ["fin"]
outputs = ["roll"]
units = ["deg"]
A = [[0, 1], ["-w**2", "-2*z*w"]]
B = [[0], ["k*w**2"]]
C = [[1, 0]]
R1 = [[0, 0], [0, "q"]]
R2 = [["s"]]
x0 = ["roll_0", "rate_0"]
"""
STARTS = {"w": 0.6, "z": 0.2, "k": 1.0, "q": 1e-3, "s": 0.1, "roll_0": 0.0, "rate_0": 0.0}
ROWS = "".join(f'\n[[parameters]]\nname = "{n}"\nstart = {x}\n' for n, x in STARTS.items())
PROGRAM = f"""
name = "Rolling under fins"
inputs = ("fin",)
outputs = ("roll",)
units = ("deg",)
parameters = {STARTS}


def matrices(theta):
    w, z, k, q, s, roll_0, rate_0 = theta
    A = [[0, 1], [-(w**2), -2 * z * w]]
    return A, [[0], [k * w**2]], [[1, 0]], None, [[0, 0], [0, q]], [[s]], [roll_0, rate_0], None
"""
STUDY = """
schema = "identify/1"
name = "Fins"
data = "roll.csv"

[model]
kind = "own"
file = "system.toml"
"""


def sampled() -> tuple[Any, Any, Any]:
    """Return Phi, Gamma and the covariance of the disturbance over a step."""
    A, B = np.array([[0.0, 1.0], [-W * W, -2.0 * Z * W]]), np.array([[0.0], [K * W * W]])
    whole = expm(np.block([[A, B], [np.zeros((1, 3))]]) * STEP)
    noise = expm(np.block([[-A, np.diag([0.0, Q])], [np.zeros((2, 2)), A.T]]) * STEP)
    return whole[:2, :2], whole[:2, 2], noise[2:, 2:].T @ noise[:2, 2:]


def write_record(path: Path, seed: int, first: tuple[float, float], count: int = 300) -> Path:
    """Write a record of rolling; return its path."""
    rng, x, rows = np.random.default_rng(seed), np.array(first), ["t,fin,roll"]
    Phi, Gamma, noise = sampled()
    root = np.linalg.cholesky(noise)
    fin = np.repeat(rng.choice([-10.0, 10.0], count // 8 + 1), 8)
    for i in range(count):
        rows.append(f"{STEP * i},{fin[i]},{x[0] + np.sqrt(S) * rng.standard_normal():.6f}")
        x = Phi @ x + Gamma * fin[i] + root @ rng.standard_normal(2)
    path.write_text("\n".join(rows) + "\n")
    return path


def write_study(folder: Path, system: str = SYSTEM + ROWS) -> Path:
    """Write study, system and record; return the study's path."""
    write_record(folder / "roll.csv", 1, (2.0, 0.0))
    (folder / "system.toml").write_text(system)
    (folder / "study.toml").write_text(STUDY)
    return folder / "study.toml"
