"""The core compiled once, where settings of numba ask for other code than the shipped object.

``python -m helpers.core`` does it; in all other lanes there is nothing to compile.
"""

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.session.doors.warm_up import warm_boat

if __name__ == "__main__":
    warm_boat(Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5)))
