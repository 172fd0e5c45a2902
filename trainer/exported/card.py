"""The card of an exported core, as trainer.bare.card reads it."""

from trainer import __version__
from trainer.bare.card import FORMAT, HEADING
from trainer.boat import PLACES, Boat
from trainer.core.scratch import SCRATCH
from trainer.core.state import STATE
from trainer.core.update import WATCHED
from trainer.exported.targets import Processor
from trainer.exported.wording import rows
from trainer.io.csv_file import COLUMNS
from trainer.machine_code import core_digest


def card_text(boat: Boat, target: Processor) -> str:
    """Return the card of ``boat`` compiled for ``target``."""
    method = boat.method
    columns = " ".join(f"{name}={PLACES[name]}" for name in COLUMNS if name != "t")
    lines = [
        f"{HEADING} {FORMAT}",
        f"version {__version__}",
        f"core {core_digest()}",
        f"boat {boat.file.name}",
        f"computed {method.equations} set, {method.integrator} at {method.step:g} s",
        f"cpu {target.name}",
        f"needs {' '.join(target.needs)}",
        f"step {method.step.hex()}",
        f"places {STATE.itemsize // 8}",
        f"work {SCRATCH.itemsize // 8}",
        f"watched {' '.join(WATCHED)}",
        f"columns {columns}",
        *(f"order {row}" for row in rows(boat)),
    ]
    return "\n".join(lines) + "\n"
