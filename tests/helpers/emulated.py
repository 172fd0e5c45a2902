"""Other processors in an emulator: ticks of an object that is compiled for one.

Records go into the host's input, and come back from its output.
"""

import shlex
import struct
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NamedTuple

from bench.standard_hour import (
    TickRunner,
    digest,
    fly_standard_hour,
    standard_boat,
)

from helpers.places import ROOT
from trainer.boat.assemble import Records
from trainer.boat.export.library import OBJECT_FILE, write_core
from trainer.boat.platforms import CPU_TARGETS

HOST: Final = ROOT / "tests" / "boat" / "exported.c"
WORD: Final = struct.Struct("<q")  # of ticks, and of a status
STATE_PLACE: Final = slice(3, 4)  # of the records of a boat
ENDS: Final = ("/dev/stdin", "/dev/stdout")
BOARD: Final = (
    "qemu-system-arm -M mps2-an500 -display none -serial none -monitor none "
    "-semihosting-config enable=on,target=native"
)


class Emulator(NamedTuple):
    """What runs a host for another processor, and Debian's package of it."""

    command: str
    package: str
    linked: tuple[str, ...] = ("-static",)

    @property
    def program(self) -> str:
        """Return the emulator's program."""
        return self.command.partition(" ")[0]

    def words(self, host: Path, *words: str) -> list[str]:
        """Return the command that runs a host with these words."""
        if self.linked:
            return [self.command, str(host), *words]
        given = "".join(f",arg={word}" for word in (host.name, *words))
        return [*shlex.split(self.command + given), "-kernel", str(host)]


EMULATORS: Final[Mapping[str, Emulator]] = {  # by target
    "aarch64": Emulator("qemu-aarch64", "qemu-user"),
    "riscv64": Emulator("qemu-riscv64", "qemu-user"),
    "cortex-m7": Emulator(BOARD, "qemu-system-arm", linked=()),
}


def needed_programs(cpu: str) -> dict[str, str]:
    """Return the programs that fly a target's hour, with Debian's packages of each."""
    emulator, target = EMULATORS[cpu], CPU_TARGETS[cpu]
    return {
        target.compiler.partition(" ")[0]: target.packages,
        emulator.program: emulator.package,
    }


def fly_exported_hour(cpu: str, folder: Path) -> str:
    """Return the digest of the standard hour by the core that is exported for a target."""
    write_core(standard_boat(), folder, cpu)
    host = link_host(cpu, folder, HOST)
    with emulated_ticks(EMULATORS[cpu].words(host, *ENDS), STATE_PLACE) as take:
        return digest(fly_standard_hour(take))


def link_host(cpu: str, folder: Path, source: Path, *options: str) -> Path:
    """Return a host with the core in it that lies exported in a folder."""
    host, target = folder / "host", CPU_TARGETS[cpu]
    sources = [*(str(folder / name) for name in target.board), str(source)]
    words = [*shlex.split(target.compiler), "-O2", "-Wall", "-Werror", *options]
    words += EMULATORS[cpu].linked
    words += ["-I", str(folder), "-o", str(host), *sources, str(folder / OBJECT_FILE)]
    subprocess.run(words, check=True, capture_output=True)
    return host


@contextmanager
def emulated_ticks(words: list[str], sent: slice) -> Iterator[TickRunner]:
    """Yield what takes ticks by a host in an emulator; it is sent these of a boat's records."""
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        asked, answered = process.stdin, process.stdout

        def take(records: Records, count: int) -> int:
            asked.write(WORD.pack(count) + b"".join(each.tobytes() for each in records[sent]))
            asked.flush()
            (status,) = WORD.unpack(answered.read(WORD.size))
            for record in records[sent]:
                record.view("u1")[:] = bytearray(answered.read(record.nbytes))
            return int(status)

        yield take
    assert process.returncode == 0
