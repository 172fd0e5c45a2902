"""Libraries that the plain install lacks, and the extra of the package that brings each.

Whatever needs such a library asks here first, so that its user reads what to install.
"""

from importlib.util import find_spec
from typing import Final

from trainer.config.files import ConfigError

PACKAGE_NAME: Final = "submarine-trainer"
EXTRA_BY_LIBRARY: Final = {  # what is imported, by the extra that brings it
    "matplotlib": "plot",
    "rerun": "rerun",
    "mcap": "mcap",
    "pyarrow": "parquet",
    "pandas": "pandas",
    "distributed": "cluster",
    "scipy": "identify",
    "gymnasium": "gym",
    "tifffile": "bottom",
    "pyulog": "logs",
    "rosbags": "logs",
    "starlette": "web",
    "uvicorn": "web",
    "websockets": "web",
    "segno": "web",
    "playwright": "dev",
}


def advise_install(library: str, purpose: str) -> str:
    """Return one line: what needs a library, and the words that install it."""
    return f"{purpose} needs {library}: pip install '{PACKAGE_NAME}[{EXTRA_BY_LIBRARY[library]}]'"


def require_library(library: str, purpose: str) -> None:
    """Check that a library is installed; ConfigError naming the extra that brings it."""
    if find_spec(library) is None:
        raise ConfigError(advise_install(library, purpose))
