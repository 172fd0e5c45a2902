"""The tables of a study of many members: keys, units and limits.

``study`` reads files by them. Unit, limits and meaning of a key stand here once, and serve the
reader, its messages, the JSON Schema and docs/sweep-keys.md.
"""

from dataclasses import dataclass
from typing import Any, Final

from trainer.analysis.manoeuvres.flight import FIELD_CHOICES
from trainer.config.files import ConfigError, Position
from trainer.config.schema import (
    Choice,
    Flag,
    KeyForm,
    Quantity,
    Rows,
    Text,
    Texts,
    WholeNumber,
    above,
    list_schema,
    optional,
    required,
    within,
)
from trainer.config.words import EQUATION_SETS, LINEAR_MODELS, OUTPUT_CHANNELS, TRIGONOMETRY_KINDS

MAX_MEMBERS: Final = 10_000_000  # members of a study
MAX_VALUES: Final = 10_000  # values of one variable
MAX_NUMBER: Final = 1e12  # of any value, so that squares and sums of all members stay finite
NUMBER_LIMITS: Final = within(-MAX_NUMBER, MAX_NUMBER)
ESTIMATE_DISTRIBUTION: Final = "estimate"  # a distribution: draws of all coefficients together
SEED_LIMIT: Final = 2**49  # seeds are below it


@dataclass(frozen=True)
class DistinctTexts(Texts):
    """A list of texts, one at least, each given once."""

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        _, _, meaning, schema = super().form
        schema = {**schema, "minItems": 1, "uniqueItems": True}
        return KeyForm("list of text", f"1 to {self.most} texts", meaning, schema)

    def read(self, key: str, value: object, position: Position) -> tuple[str, ...]:
        """Return the texts; ConfigError if there is none, one is none, or is given twice."""
        if value == []:
            raise ConfigError(
                position.wrong(key, value, f"must be a list of 1 to {self.most} texts")
            )
        texts = super().read(key, value, position)
        twice = [text for text in texts if texts.count(text) > 1]
        if twice:
            raise ConfigError(position.wrong(key, value, f"names {twice[0]!r} twice"))
        return texts


@dataclass(frozen=True)
class ValueList:
    """A list of finite numbers, or of words, none of them twice."""

    most: int
    meaning: str

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        each = Quantity("-", NUMBER_LIMITS, self.meaning), Text(200, self.meaning)
        kinds = [list_schema(kind.form.schema, 1, self.most) for kind in each]
        schema = {"anyOf": kinds, "uniqueItems": True}
        return KeyForm("list", f"1 to {self.most} numbers, or words", self.meaning, schema)

    def read(self, key: str, value: object, position: Position) -> tuple[Any, ...]:
        """Return the numbers or words; ConfigError if they are neither, or mixed."""
        if not isinstance(value, list) or not 1 <= len(value) <= self.most:
            raise ConfigError(position.wrong(key, value, f"must be a list of 1 to {self.most}"))
        number = Quantity("-", NUMBER_LIMITS, self.meaning)
        word = Text(200, self.meaning)
        kind: Quantity | Text = word if isinstance(value[0], str) else number
        values = tuple(kind.read(f"{key}[{i}]", item, position) for i, item in enumerate(value))
        if len(set(values)) < len(values):
            raise ConfigError(position.wrong(key, value, "must not give one twice"))
        return values


@dataclass(frozen=True, kw_only=True)
class SweepHeading:
    """The subject of a study."""

    schema: str = required(Choice(("sweep/1",), "form of the file"))
    name: str = required(Text(79, "what is studied"))
    vessel: str | None = optional(
        Text(200, "a boat's name, or path of its or a ship's file; else bb2")
    )
    measures: tuple[str, ...] | None = optional(
        DistinctTexts(Text(60, "what is kept of each member; else all there is"), 200)
    )


@dataclass(frozen=True, kw_only=True)
class MethodTable:
    """How the boat is computed."""

    equations: str | None = optional(Choice(EQUATION_SETS, "set of equations; else the boat's own"))
    rates: str | None = optional(
        Choice(("exact", "lagged"), "accelerations; else lagged, with Runge-Kutta exact")
    )
    trig: str | None = optional(Choice(TRIGONOMETRY_KINDS, "else exact"))
    integrator: str | None = optional(Text(200, "as --integrator; else adams2"))
    step_s: float | None = optional("s", within(0.001, 2), "else the vessel file's")


@dataclass(frozen=True, kw_only=True)
class ManoeuvreTable:
    """The manoeuvre that every member flies; what is left out is its own."""

    name: str = required(Text(40, "as `trainer boat manoeuvre --list` has it"))
    speed_kn: float | None = optional("kn", within(0.01, 60), "else the vessel file's")
    angle_deg: float | None = optional("deg", within(0, 90), "of the control")
    execute_deg: float | None = optional("deg", within(0, 180), "mark")
    planes_deg: float | None = optional("deg", within(0, 90), "of a climbing turn")
    duration_s: float | None = optional("s", within(1, 1e5), "time flown")
    side: str | None = optional(
        Choice(FIELD_CHOICES["side"], "of a turn, or first; else starboard")
    )
    direction: str | None = optional(
        Choice(FIELD_CHOICES["direction"], "of the planes, or first; else rise, of trim dive")
    )
    step_kn: float | None = optional(
        "kn", within(0.1, 60), "of an acceleration's steps, at most; else 5"
    )
    each_s: float | None = optional("s", within(1, 1e5), "of each of these steps")
    ahead_kn: float | None = optional(
        "kn", within(0.01, 60), "last of an acceleration; else full ahead"
    )
    ahead_s: float | None = optional(
        "s", within(1, 1e5), "of an utmost acceleration; else half its time"
    )
    depth_kept: bool | None = optional(Flag("whether a turn keeps its depth; else it does"))
    controls: str | None = optional(Choice(("own", "once"), "rates and lags, or none; else own"))
    trim: str | None = optional(Choice(("own", "full"), "equations of the start; else own"))
    law: str | None = optional(
        Choice(("trainer", "report", "literal"), "of depth keeping; else trainer")
    )


@dataclass(frozen=True, kw_only=True)
class IdentificationTable:
    """An experiment that is simulated and identified again and again."""

    model: str = required(Choice(LINEAR_MODELS, "model, as `trainer identify --model`"))
    length_m: float = required("m", within(0.1, 600), "of the ship")
    speed_kn: float = required("kn", within(0.01, 60), "of the ship")
    bow_log_m: float | None = optional("m", within(0, 600), "forward log")
    stern_log_m: float | None = optional("m", within(0, 600), "aft log")
    outputs: tuple[str, ...] = required(
        DistinctTexts(
            Text(20, f"channels read: {', '.join(OUTPUT_CHANNELS)}"), len(OUTPUT_CHANNELS)
        )
    )
    interval_s: float = required("s", within(1e-4, 3600), "from sample to sample")
    samples: int = required(WholeNumber(10, 100_000, "of a record"))
    register_bits: int = required(WholeNumber(2, 12, "of the binary sequence on the rudder"))
    bit_s: float = required("s", within(1e-3, 3600), "time that one bit holds")
    amplitude_deg: float = required("deg", within(0.01, 90), "of the rudder, either way")


@dataclass(frozen=True, kw_only=True)
class SweptParameter:
    """One parameter of a model that is identified."""

    name: str = required(Text(20, "as the model calls it"))
    truth: float = required("model's", NUMBER_LIMITS, "what the records are made with")
    start: float | None = optional(
        "model's", NUMBER_LIMITS, "where the search begins; else at the truth"
    )
    free: bool | None = optional(Flag("whether it is searched for; else it is"))


@dataclass(frozen=True, kw_only=True)
class Sample:
    """Which members there are."""

    plan: str = required(
        Choice(("grid", "latin-hypercube", "monte-carlo", "sobol"), "how numbers are chosen")
    )
    members: int | None = optional(
        WholeNumber(
            1, MAX_MEMBERS, "how many; a grid has all its points, sobol (variables + 2) 2^n"
        )
    )
    seed: int = required(WholeNumber(0, SEED_LIMIT - 1, "of everything random"))
    seeds: str | None = optional(
        Choice(("each", "one"), "the seas of each member are its own, or all alike; else each")
    )


@dataclass(frozen=True, kw_only=True)
class VaryRow:
    """One number that differs from member to member."""

    name: str = required(Text(40, "heading of its column"))
    key: str = required(Text(200, "what it changes, such as vessel.coefficients.N_v"))
    values: tuple[Any, ...] | None = optional(ValueList(MAX_VALUES, "the numbers, or words"))
    distribution: str | None = optional(
        Choice(
            ("uniform", "normal", "triangular", ESTIMATE_DISTRIBUTION),
            "instead of values; estimate: whole draws of a boat or a fitted ship, key vessel",
        )
    )
    low: float | None = optional("key's", NUMBER_LIMITS, "of uniform, triangular")
    high: float | None = optional("key's", NUMBER_LIMITS, "of uniform, triangular")
    mode: float | None = optional("key's", NUMBER_LIMITS, "peak of triangular")
    mean: float | None = optional("key's", NUMBER_LIMITS, "of normal")
    std: float | None = optional("key's", above(0, MAX_NUMBER), "of normal")
    relative: bool | None = optional(
        Flag("true: the numbers are factors of what the files say; else they take its place")
    )


VARY_ROWS: Final = Rows(VaryRow, ("note",), 0, 200, "what is varied, below")
PARAMETER_ROWS: Final = Rows(SweptParameter, ("note",), 1, 60, "of the model identified, below")
