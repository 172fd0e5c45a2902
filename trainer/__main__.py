"""The command. A run on an exported core loads none of the libraries that others need."""

import gc
import sys


def main() -> None:
    """Run the command line."""
    words = sys.argv[1:]
    exported = any(word.partition("=")[0] == "--core" for word in words)
    if words[:1] == ["run"] and exported and not {"-h", "--help"} & set(words):
        from trainer.boat.export.runner.run import main as run  # noqa: PLC0415

        sys.exit(run(words[1:]))
    gc.disable()  # what is imported is no garbage: to look through it is a tenth of importing it
    from trainer.cli.main import main as command  # noqa: PLC0415

    gc.freeze()
    gc.enable()
    command()


if __name__ == "__main__":
    main()
