"""The shipped object of another processor, in an emulator: the hour ends in the same bits."""

import gzip
import struct
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.installation import installed

from trainer.analysis.bench.standard_hour import (
    TickRunner,
    digest,
    fly_standard_hour,
    standard_boat,
)
from trainer.analysis.bench.tick import in_a_loop
from trainer.boat.assemble import Records
from trainer.boat.machine_code import SHIPPED_FOLDER

HOST = Path(__file__).with_name("emulated.c")
OBJECT_NAME = "linux-aarch64"
WORD = struct.Struct("<q")  # of ticks, and of a status


def build_host(folder: Path) -> Path:
    """Return the host with the shipped object in it, for aarch64; needs its compiler."""
    compiler = installed("aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu libc6-dev-arm64-cross")
    tick, host = folder / "tick.o", folder / "host"
    tick.write_bytes(gzip.decompress((SHIPPED_FOLDER / f"{OBJECT_NAME}.o.gz").read_bytes()))
    words = [compiler, "-O2", "-Wall", "-Werror", "-static", "-o", str(host), str(HOST), str(tick)]
    subprocess.run(words, check=True)
    return host


@contextmanager
def emulated_ticks(host: Path, sizes: list[int]) -> Iterator[TickRunner]:
    """Yield what takes ticks of records of those sizes [bytes] by the host, in the emulator."""
    emulator = installed("qemu-aarch64", "qemu-user")
    words = [emulator, str(host), *map(str, sizes)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        asked, answered = process.stdin, process.stdout

        def take(records: Records, count: int) -> int:
            asked.write(WORD.pack(count) + b"".join(each.tobytes() for each in records))
            asked.flush()
            (status,) = WORD.unpack(answered.read(WORD.size))
            for record in records:
                record.view("u1")[:] = bytearray(answered.read(record.nbytes))
            return int(status)

        yield take
    assert process.returncode == 0


@pytest.mark.slow
@pytest.mark.process
def test_the_object_for_aarch64_ends_the_standard_hour_in_the_same_bits(tmp_path: Path) -> None:
    host = build_host(tmp_path)
    sizes = [record.nbytes for record in standard_boat().records]
    with emulated_ticks(host, sizes) as take:
        flown = digest(fly_standard_hour(take))

    assert flown == digest(fly_standard_hour(in_a_loop))
