"""The current of an exercise or a sea file: uniform, by depth, or a tide.

``boat/world/current`` moves the water by it at each tick. Speeds in the file are in knots.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

from trainer.config.files import ConfigError, Position
from trainer.config.schema import (
    KeyForm,
    Quantity,
    Table,
    list_schema,
    optional,
    read_record,
    record_schema,
    required,
    with_default,
    within,
)
from trainer.io.orders.grammar import Refused

LUNAR_TIDE_PERIOD_H: Final = 12.4206  # [h] between tides: M2, the moon's
MIN_CHANGE_TIME_S: Final = 60.0  # [s] of a change, below which the water's own acceleration is felt
DRIFT_LIMITS_KN: Final = within(0, 10)  # [kn]
SET_LIMITS_DEG: Final = within(0, 360)  # [deg]
MAX_PROFILE_ROWS: Final = 50  # rows of a table
CURRENT_FORMS: Final[Mapping[str, tuple[str, ...]]] = {
    "set_deg with drift_kn": ("set_deg", "drift_kn"),
    "table": ("table",),
    "tide": ("tide",),
}


@dataclass(frozen=True)
class Profile:
    """Rows of depth, set and drift, from above downwards."""

    meaning: str
    columns: tuple[Quantity, ...] = (
        Quantity("m", within(0, 12000), "depth"),
        Quantity("deg", SET_LIMITS_DEG, "set"),
        Quantity("kn", DRIFT_LIMITS_KN, "drift"),
    )

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        row = {
            "prefixItems": [each.form.schema for each in self.columns],
            **list_schema({"type": "number"}, len(self.columns), len(self.columns)),
        }
        return KeyForm(
            "m, deg, kn",
            f"1 to {MAX_PROFILE_ROWS} rows",
            self.meaning,
            list_schema(row, 1, MAX_PROFILE_ROWS),
        )

    def read(self, key: str, value: object, position: Position) -> tuple[tuple[float, ...], ...]:
        """Return the rows; ConfigError naming the first number that is wrong."""
        if not isinstance(value, list) or not 1 <= len(value) <= MAX_PROFILE_ROWS:
            message = f"must be a list of 1 to {MAX_PROFILE_ROWS} rows [depth m, set deg, drift kn]"
            raise ConfigError(position.wrong(key, value, message))
        rows = tuple(self._row(f"{key}[{i}]", row, position) for i, row in enumerate(value))
        for i, (upper, lower) in enumerate(itertools.pairwise(rows), start=1):
            if lower[0] <= upper[0]:
                message = f"depths must rise: {lower[0]:g} m is not below {upper[0]:g} m"
                raise ConfigError(position.wrong(f"{key}[{i}]", value[i], message))
        return rows

    def _row(self, key: str, row: object, position: Position) -> tuple[float, ...]:
        if not isinstance(row, list) or len(row) != len(self.columns):
            message = "must be three numbers: depth m, set deg, drift kn"
            raise ConfigError(position.wrong(key, row, message))
        return tuple(
            kind.read(f"{key}[{i}]", item, position)
            for i, (kind, item) in enumerate(zip(self.columns, row, strict=True))
        )


@dataclass(frozen=True, kw_only=True)
class Tide:
    """A current that turns: its tip runs round an ellipse, about a mean that stays."""

    major_kn: float = required("kn", DRIFT_LIMITS_KN, "strongest")
    minor_kn: float = with_default(
        0.0, "kn", within(-10, 10), "weakest; above 0 it turns clockwise, 0: to and fro"
    )
    towards_deg: float = required("deg", SET_LIMITS_DEG, "true, where the strongest sets")
    period_h: float = with_default(
        LUNAR_TIDE_PERIOD_H,
        "h",
        within(1, 1000),
        f"once round; else {LUNAR_TIDE_PERIOD_H:g}",
    )
    phase_h: float = with_default(
        0.0, "h", within(-1000, 1000), "since the strongest at the start; else 0"
    )
    mean_set_deg: float | None = optional(
        "deg", SET_LIMITS_DEG, "true, where the water goes to on the whole; with its drift"
    )
    mean_drift_kn: float | None = optional(
        "kn", DRIFT_LIMITS_KN, "what is left over a whole period; else nothing is"
    )


@dataclass(frozen=True, kw_only=True)
class Current:
    """One of the forms, and how fast an order changes it. Sets are towards."""

    set_deg: float | None = optional("deg", SET_LIMITS_DEG, "true, where the water goes to")
    drift_kn: float | None = optional("kn", DRIFT_LIMITS_KN, "its speed over ground")
    table: tuple[tuple[float, ...], ...] | None = optional(
        Profile("by depth: `[depth, set, drift]`, depths rising; straight between, ends held")
    )
    tide: Tide | None = optional(Table(Tide, "by time, below"))  # noqa: RUF009  (a frozen description)
    ramp_s: float = with_default(
        MIN_CHANGE_TIME_S,
        "s",
        within(MIN_CHANGE_TIME_S, 3600),
        f"of an order's change; else {MIN_CHANGE_TIME_S:g}",
    )


def read_current(value: object, position: Position, _path: Path) -> Current:
    """Return the current of one table; ConfigError with all that is wrong."""
    current = read_record(Current, value, position, ("note",))
    if refused := _problem(current):
        raise ConfigError(position.problem(refused.reason))
    return current


def _problem(current: Current) -> Refused | None:
    """Return why the keys make no current, None where they do."""
    keys = [item.name for item in fields(Current) if item.name != "ramp_s"]
    present = [key for key in keys if getattr(current, key) is not None]
    forms = [name for name, own in CURRENT_FORMS.items() if any(key in present for key in own)]
    every_form = ", ".join(CURRENT_FORMS)
    if len(forms) != 1:
        have = f"has {', '.join(present)}" if present else "has none of them"
        return Refused(f"{have}: give one of {every_form}")
    (form,) = forms
    lacking = [key for key in CURRENT_FORMS[form] if key not in present]
    if lacking:
        return Refused(f"has {present[0]} and lacks {lacking[0]}: give one of {every_form}")
    return _tide_problem(current.tide) if current.tide else None


def _tide_problem(tide: Tide) -> Refused | None:
    """Return why a tide is none, None where it is one."""
    if abs(tide.minor_kn) > tide.major_kn:
        return Refused(
            f"tide minor_kn = {tide.minor_kn:g}: is more than major_kn = {tide.major_kn:g}; "
            "the strongest is the major one"
        )
    mean = {"mean_set_deg": tide.mean_set_deg, "mean_drift_kn": tide.mean_drift_kn}
    has, lacks = sorted(mean, key=lambda key: mean[key] is None)
    whole = (mean[has] is None) == (mean[lacks] is None)
    return None if whole else Refused(f"tide has {has} and lacks {lacks}: give both, or neither")


def current_schema() -> dict[str, Any]:
    """Return the JSON Schema of a table [current]; one of the forms is given."""
    forms = [{"required": [*keys]} for keys in CURRENT_FORMS.values()]
    return {**record_schema(Current, ("note",)), "oneOf": forms}
