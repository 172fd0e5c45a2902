"""``python -m tests.learners``: the exercises as Stable-Baselines3 checks environments.

Its checker brings torch, so it is installed into an environment of its own. A warning is an error.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[1]
UV: Final = (sys.executable, "-m", "uv")
LEAST_CHECKED: Final = 14  # exercises that are flown by numbers
CHECKER: Final = f"""
import warnings
from stable_baselines3.common.env_checker import check_env
import gymnasium
import trainer
import trainer.gym

warnings.simplefilter("error")
checked = 0
for name in (name for name in gymnasium.registry if name.startswith("trainer/")):
    try:
        environment = gymnasium.make(name)
    except trainer.TrainerError:
        continue  # it asks for words, or hides what numbers show
    check_env(environment.unwrapped, warn=True)
    checked += 1
assert checked >= {LEAST_CHECKED}, checked
print(f"{{checked}} exercises, no error and no warning")
"""


def run(*words: str) -> int:
    """Run a command; return its exit code."""
    return subprocess.run(words, check=False).returncode


def main() -> int:
    """Install the checker beside the trainer, and run it; return the exit code."""
    with tempfile.TemporaryDirectory(prefix="learners") as folder:
        python = str(Path(folder) / "bin" / "python")
        install = (*UV, "pip", "install", "--quiet", "--python", python)
        return (
            run(*UV, "venv", "--quiet", "--python", sys.executable, "--clear", folder)
            or run(*install, "--torch-backend", "cpu", f"{ROOT}[gym]", "stable-baselines3")
            or run(python, "-I", "-c", CHECKER)
        )


if __name__ == "__main__":
    sys.exit(main())
