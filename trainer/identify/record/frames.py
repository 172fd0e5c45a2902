"""Arrays by channel, such as a frame of pandas, as a record."""

from collections.abc import Iterable, Mapping
from typing import Any, cast

import numpy as np

from trainer.config.files import ConfigError, offer_known
from trainer.core.kernel import Numbers
from trainer.identify.record.measurements import CHANNEL_UNITS, Record
from trainer.identify.record.sources import (
    SHIP_COLUMNS,
    TRAINER_COLUMNS,
    Column,
    factor,
    find_impossible,
    own_readings,
    units_of,
)


def columns_of(
    frame: Mapping[str, Any],
    columns: Mapping[str, str],
    units: Mapping[str, str],
    further: Iterable[str],
) -> dict[str, Column]:
    """Return the column of each channel, ``further`` ones among them. ConfigError.

    ``columns`` and ``units`` are those that the caller names, by channel.
    """
    channels, known_as = ("t", *CHANNEL_UNITS, *further), {**TRAINER_COLUMNS, **SHIP_COLUMNS}
    for name in (*columns, *units):
        if name not in channels:
            raise ConfigError(f"no channel {name!r}{offer_known(name, channels)}")
    columns_by_channel = {}
    for channel in channels:
        usual = [channel, known_as.get(channel, channel)]
        names = [columns[channel]] if channel in columns else usual
        column = next((name for name in names if name in names_of(frame)), None)
        if column is not None:
            columns_by_channel[channel] = Column(column, units.get(channel))
        elif channel in columns or channel in ("t", "rudder"):
            known = ", ".join(map(str, names_of(frame)))
            raise ConfigError(f"frame: no column {names[0]!r} for {channel}; it has {known}")
    return columns_by_channel


def names_of(frame: Mapping[str, Any]) -> list[str]:
    """Return the names of a frame's columns, and of its index if it has one."""
    index = getattr(getattr(frame, "index", None), "name", None)
    return [*frame.keys(), *([index] if index else [])]


def arrays_of(frame: Mapping[str, Any], columns: Mapping[str, Column]) -> dict[str, Numbers]:
    """Return arrays by channel, SI; ConfigError naming a column that cannot be used."""
    taken: dict[str, Numbers] = {}
    for channel, column in columns.items():
        scale = factor(channel, column.unit)
        # the index of a pandas frame is no column of it
        series = frame[column.name] if column.name in frame else cast("Any", frame).index
        values = np.asarray(series)
        if values.dtype.kind == "M":
            values = (values - values[0]) / np.timedelta64(1, "s")
        try:
            taken[channel] = np.asarray(values, float) * scale
        except (TypeError, ValueError) as error:
            raise ConfigError(f"frame: {column.name}: is no array of numbers: {error}") from None
        size = taken[next(iter(taken))].shape
        if taken[channel].ndim != 1 or taken[channel].shape != size:
            shape = taken[channel].shape
            raise ConfigError(f"frame: {column.name}: has shape {shape}, must be {size[:1]}")
    return taken


def record_of(taken: Mapping[str, Numbers], columns: Mapping[str, Column]) -> Record:
    """Return the record of arrays by channel; ConfigError if times do not rise."""
    names = {channel: column.name for channel, column in columns.items()}
    values_by_channel: dict[str, Any] = {
        channel: one for channel, one in taken.items() if channel != "t"
    }
    rows = np.arange(len(taken["t"]))
    units = {name: one.unit or next(iter(units_of(name))) for name, one in columns.items()}
    record = Record(
        source="frame", t=taken["t"], rows=rows, names=names, units=units, **values_by_channel
    )
    for channel, values in values_by_channel.items():
        unit = units[channel]
        if fault := find_impossible(channel, values, unit):
            raise ConfigError(f"frame: {names[channel]}[{fault[0]}]: {fault[1]} make it NaN")
    return own_readings(record)
