"""An order is timed from the helm's serial line to an instrument at another."""

import json
import os

import pytest
from helpers.typed import type_command

from bench.__main__ import bench
from bench.helm import RUDDER_SENTENCE, shown_rudder
from bench.terminal import TerminalLine

pytestmark = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")


def test_the_rudder_is_read_from_whole_sentences() -> None:
    line = TerminalLine(-1, "", b"$INRSA,-3.6,A,,V*4C\r\n$INRSA,7.1,A,,V*6B\r\n")

    assert [shown_rudder(line, 0.0), shown_rudder(line, 0.0)] == [-3.6, 7.1]
    assert RUDDER_SENTENCE.search(b"$INRSA,7.1,A,,V") is None


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@pytest.mark.long
def test_the_bench_steers_a_session_by_serial_lines() -> None:
    tree = json.loads(type_command(bench, "--helm", "--seconds", "3", "--json").output)["helm"]

    assert 1 <= len(tree["delays_s"]) <= 12
    assert tree["step_s"] == 0.5
