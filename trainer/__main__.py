"""The command."""

import gc
import sys


def main() -> None:
    """Run the command line."""
    gc.disable()  # what is imported is no garbage: to look through it is a tenth of importing it
    try:
        from trainer.cli.main import main as command  # noqa: PLC0415
    except KeyboardInterrupt:  # nothing has begun yet
        sys.exit(130)  # as shells have it

    gc.freeze()
    gc.enable()
    try:
        command()
    finally:
        gc.freeze()  # or what is left would be looked through once more, before it is all let go


if __name__ == "__main__":
    main()
