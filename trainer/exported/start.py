"""The boat that is exported: fitted out and in trim, as a run of it would begin."""

from typing import Any

from trainer.boat import Boat
from trainer.files.sea_file import load_sea
from trainer.files.vessel_file import load_vessel
from trainer.plan import chosen_method
from trainer.readiness import refuse_unstable
from trainer.units import KNOT


def boat_at_start(options: dict[str, Any]) -> Boat:
    """Return the boat of the command line's ``options`` at its start; ConfigError if she cannot."""
    file = load_vessel(options["vessel"])
    sea = load_sea(options["sea"])
    boat = Boat(file, chosen_method(file, options))
    if not options["unsafe_step"]:
        refuse_unstable(boat)
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0, options["seed"])
    boat.put_to_sea(sea)
    return boat
