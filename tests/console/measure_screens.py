"""Measure what screens cost, by `python tests/console/measure_screens.py [SECONDS]`.

The screens of all roles are open on one session at 2 Hz in a sea; printed are the share of a core
that each takes, and the session's own account of its ticks.
"""

import contextlib
import fcntl
import os
import pty
import struct
import subprocess
import sys
import tempfile
import termios
import threading
import time
from pathlib import Path

TRAINER = [sys.executable, "-m", "trainer"]
ROLES = ("instructor", "helm", "planes", "ballast", "diving", "observer")
SIZE = struct.pack("HHHH", 48, 160, 0, 0)
SETTLE = 5.0  # [s]


def drain(terminal: int) -> None:
    """Read what a screen shows, to its end."""
    try:
        while os.read(terminal, 65536):
            pass
    except OSError:
        pass


def screen(role: str, where: Path) -> subprocess.Popen[bytes]:
    """Open the screen of a role on a terminal of 160 columns and 48 rows."""
    far, near = pty.openpty()
    fcntl.ioctl(near, termios.TIOCSWINSZ, SIZE)
    threading.Thread(target=drain, args=(far,), daemon=True).start()
    words = ["attach"] if role == "instructor" else ["station", role]
    process = subprocess.Popen(
        [*TRAINER, *words, "--connect", str(where)],
        stdin=near, stdout=near, stderr=near, start_new_session=True,
        env=os.environ | {"TERM": "xterm-256color"},
    )  # fmt: skip
    os.close(near)
    return process


def used(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time [s] that a process has taken."""
    fields = (
        Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    )
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def stay_for(session: "subprocess.Popen[bytes]", seconds: float) -> None:
    """Let the session go on for a time [s]; fail where it ends."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        raise SystemExit(f"the session has ended with {session.wait(seconds)}")


def measure(seconds: float) -> None:
    """Open all, wait, and print what each took."""
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder) / "s"
        serve = ["serve", "--socket", str(where), "--listen", "none", "--sea", "sea-state-5"]
        with subprocess.Popen([*TRAINER, *serve, "--no-record"]) as session:
            while not where.exists():
                time.sleep(0.1)
            screens = {role: screen(role, where) for role in ROLES}
            stay_for(session, SETTLE)
            before = {role: used(process) for role, process in screens.items()}
            stay_for(session, seconds)
            for role, process in screens.items():
                share = (used(process) - before[role]) / seconds
                print(f"{role:<12}{100.0 * share:5.1f} % of a core")
            for process in screens.values():
                process.terminate()
                process.wait()
            session.terminate()


if __name__ == "__main__":
    measure(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
