"""The options of a fit: unit, limits and meaning of each, wherever it is given.

A key of a study, an option of ``trainer identify`` and a keyword of ``trainer.identify.fit`` that
mean the same have their kind here, so that all three refuse the same and explain it alike.
"""

from collections.abc import Mapping
from typing import Final

from trainer.config.schema import Choice, Choices, Kind, Quantity, WholeNumber, above, within
from trainer.config.words import LINEAR_MODELS

SHIP_MODELS: Final = ("linear", "mavmm", "abkowitz", "mmg")
MOTION_CHANNELS: Final = ("heading", "yaw_rate", "sway", "bow_sway", "stern_sway", "speed")
INPUT_PATHS: Final = ("straight", "step")  # of inputs from reading to reading
USUAL_PRIOR_STRENGTH: Final = 0.5
MAX_TIME_S: Final = 1e9  # [s]
FIT_KINDS: Final[Mapping[str, Kind]] = {
    "model": Choice((*LINEAR_MODELS, *SHIP_MODELS), "model"),
    "length": Quantity("m", within(0.1, 600), "length"),
    "speed": Quantity("kn", within(0.01, 60), "else the record's mean"),
    "outputs": Choices(MOTION_CHANNELS, "channels fitted; none for own"),
    "noise": Choice(("output-error", "innovations", "covariance"), "noise model; else covariance"),
    "method": Choice(("scoring", "bfgs", "direct"), "minimiser; else scoring"),
    "reject": Quantity(
        "-", above(0, 0.5), "probability below which a sample is an outlier; else none"
    ),
    "positive_rudder": Choice(
        ("port", "starboard"), "way a positive rudder turns the ship; else port"
    ),
    "anyway": Choice(("yes", "no"), "fit what its own channels contradict? else no"),
    "between_readings": Choice(INPUT_PATHS, "of the rudder; else as name and record say"),
    "every": WholeNumber(1, 1000, "takes one sample of so many"),
    "begin": Quantity("s", within(-MAX_TIME_S, MAX_TIME_S), "first time used"),
    "end": Quantity("s", within(-MAX_TIME_S, MAX_TIME_S), "last time used"),
    "prior_strength": Quantity(
        "-", within(0, 100), "widths of what books say of a ship, times this; 0 for no book"
    ),
}
