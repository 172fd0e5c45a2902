"""The hour on other processors: what is here is flown, and the package of the rest is named."""

import pytest
from helpers.installation import PACKAGES, SLOW_PACKAGES

from bench.machines import MACHINES, Machine, fly_on_machines, lines
from trainer.boat.platforms import CPU_TARGETS


def test_a_machine_that_is_not_here_is_told_with_its_package() -> None:
    here = fly_on_machines({}).here
    machines = {
        "good": Machine(lambda: here, {}),
        "other": Machine(lambda: "0" * 64, {"sh": "dash"}),
        "absent": Machine(lambda: "", {"no-such-emulator": "qemu-none", "sh": "dash"}),
    }

    figures = fly_on_machines(machines)

    assert not figures.same
    assert fly_on_machines({"good": machines["good"]}).same
    *_, good, other, absent = lines(figures)
    assert good.split() == ["good", here[:32], "same"]
    assert other.endswith("NOT THE SAME")
    assert absent.endswith("not flown: apt install qemu-none")


@pytest.mark.parametrize("name", MACHINES)
def test_the_tests_install_what_a_machine_needs(name: str) -> None:
    programs = MACHINES[name].programs
    known = {program: {**PACKAGES, **SLOW_PACKAGES}.get(program) for program in programs}

    assert known == {program: programs[program] for program in known}


def test_every_machine_is_a_target() -> None:
    assert set(MACHINES) <= set(CPU_TARGETS)
