"""The first fit on a machine, which compiles its kernels."""

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.places import environment


@pytest.mark.process
@pytest.mark.slow
def test_a_first_fit_compiles_the_kernels_of_its_own_model_alone(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    subprocess.run(
        [sys.executable, "-m", "trainer", "identify", "--example"],  # its model is nomoto2
        env=environment(XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR=""),
        capture_output=True,
        timeout=900,
        check=True,
    )

    kept = {path.name.partition("-")[0] for path in tmp_path.rglob("*.nbi")}
    assert "ship_models.nomoto" in kept
    others = {"model_1", "model_2", "model_3", "nomoto_first"}
    assert not {name for name in kept if name.partition(".")[2] in others}
    assert not {name for name in kept if name.startswith(("extended_", "nonlinear_"))}
