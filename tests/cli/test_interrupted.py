"""Ctrl-C before the command has begun."""

import gc
import sys

import pytest

from trainer import __main__


class InterruptedImport:
    """A finder of modules at whose search the user presses Ctrl-C."""

    def find_spec(self, name: str, *_: object) -> None:
        if name == "trainer.cli.main":
            raise KeyboardInterrupt


def test_ctrl_c_while_the_command_is_loaded_ends_it_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, "trainer.cli.main", raising=False)
    monkeypatch.setattr(sys, "meta_path", [InterruptedImport(), *sys.meta_path])
    with pytest.raises(SystemExit) as left:
        __main__.main()
    gc.enable()  # which a command turns off while it is loaded
    assert left.value.code == 130
