"""What a user says of the instruments that wrote a record.

Options of ``trainer boat fit`` as words become the ``Instruments`` with which ``trial`` reads.
"""

from collections.abc import Iterable, Iterator
from typing import Final

from trainer.config.files import ConfigError, offer_known, quote
from trainer.identify.boat.noise import SLOW_KINDS
from trainer.identify.boat.trial import COLUMNS_OPTION, Instruments
from trainer.identify.record.columns import BOAT_WORDS
from trainer.identify.record.sources import column_said
from trainer.units import DEGREE

BIAS_STATES: Final = {name.removesuffix("_error"): name for name in SLOW_KINDS}


def instruments_of(  # noqa: PLR0913 - one for each option
    columns: Iterable[str] = (),
    bias: Iterable[str] = (),
    gauge_x: float = 0.0,
    late: float = 0.0,
    *,
    coarse: bool = False,
    anyway: bool = False,
    still: Iterable[str] = (),
) -> Instruments:
    """Return what words such as ``depth=Keel:m`` and ``pitch=1`` say; ConfigError."""
    found, sizes = {}, {}
    for channel, text in _pairs(COLUMNS_OPTION, columns, BOAT_WORDS):
        found[channel] = column_said(text)
    for name, text in _pairs("--bias", bias, BIAS_STATES):
        state = BIAS_STATES[name]
        try:
            sizes[state] = float(text) * (DEGREE if SLOW_KINDS[state].unit == "rad" else 1.0)
        except ValueError:
            raise ConfigError(f"--bias {name}={text}: {quote(text)} is no number") from None
        if not 0.0 < sizes[state] < 1e3:
            raise ConfigError(f"--bias {name}={text}: must be above 0, a standard deviation")
    return Instruments(found, sizes, gauge_x, late, coarse, anyway, frozenset(still))


def _pairs(option: str, texts: Iterable[str], known: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield names and values of texts such as ``pitch=1``, the names among those known."""
    for text in texts:
        name, equals, value = (word.strip() for word in text.partition("="))
        if name not in known:
            raise ConfigError(f"{option} {text}: no {quote(name)}{offer_known(name, [*known])}")
        if not equals or not value:
            raise ConfigError(f"{option} {text}: say {name}=..., such as --bias pitch=1")
        yield name, value
