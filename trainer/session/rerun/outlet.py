"""An outlet: where columns go, a file or a viewer."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from trainer.session.rerun.batch import Times
from trainer.session.rerun.sdk import rr

APPLICATION: Final = "trainer"
STEP, SECONDS = "tick", "time"  # names of the time lines


class Outlet:
    """One recording of Rerun's on its way out; for one thread only.

    A write raises what the library does; a viewer that hangs holds it up for as long.
    """

    def __init__(self, title: str) -> None:
        """Take the name that the viewer lists the recording by."""
        self._stream = rr.RecordingStream(APPLICATION)
        rr.send_recording_name(title, recording=self._stream)

    def save(self, path: Path, blueprint: Any) -> None:
        """Write to a file from now on, which is replaced."""
        rr.save(path, default_blueprint=blueprint, recording=self._stream)

    def connect(self, host: str, port: int, blueprint: Any) -> None:
        """Write to a viewer from now on."""
        url = f"rerun+http://{host}:{port}/proxy"
        rr.connect_grpc(url, default_blueprint=blueprint, recording=self._stream)

    def fix(self, path: str, *parts: Any) -> None:
        """Write what an entity is at all times."""
        rr.log(path, *parts, static=True, recording=self._stream, strict=True)

    def send(self, path: str, times: Times, columns: Iterable[Any]) -> None:
        """Write what an entity is at each of the times."""
        when = (
            rr.TimeColumn(STEP, sequence=times.ticks),
            rr.TimeColumn(SECONDS, duration=times.seconds),
        )
        rr.send_columns(path, when, columns, recording=self._stream, strict=True)

    def flush(self) -> None:
        """Bring all of it out; RuntimeError if the viewer is gone."""
        self._stream.flush()

    def close(self) -> None:
        """End the recording; a file is then complete."""
        self._stream.disconnect()
