"""A boat of a page, flown by node."""

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from helpers.installation import installed
from helpers.places import ROOT
from trainer.boat.export.wasm import SHIPPED
from trainer.web.pages import ASSETS

HOST: Final = ROOT / "tests" / "web" / "tab.mjs"
PATIENCE: Final = 120.0  # [s]


def fly(boat: dict[str, Any], *deeds: Sequence[Any]) -> list[Any]:
    """Return what each deed has told: see tab.mjs. The test is skipped where there is no node."""
    node = installed("node", "nodejs")
    asked = json.dumps(
        {"boat": {"recording": None, **boat}, "deeds": [list(each) for each in deeds]}
    )
    with tempfile.TemporaryDirectory() as folder:
        scripts = Path(folder) / "tab"
        scripts.mkdir()
        for path in (ASSETS / "js" / "tab").glob("*.js"):
            (scripts / path.name).write_bytes(path.read_bytes())
        (Path(folder) / "package.json").write_text('{"type": "module"}')
        done = subprocess.run(
            [node, str(HOST), str(scripts), str(SHIPPED)],
            input=asked,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            env=os.environ.copy(),
        )
    assert done.returncode == 0, done.stderr[-2000:]
    told: list[Any] = json.loads(done.stdout)
    return told
