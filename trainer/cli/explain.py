"""The command ``trainer help``: help for a command, or for an order."""

import click

from trainer.cli.types import Word
from trainer.io.orders.grammar import HELP_HEAD, BadOrder, parse
from trainer.io.orders.help import help_text
from trainer.io.orders.table import HELP_TOPICS


@click.command()
@click.argument("words", type=Word(HELP_TOPICS), nargs=-1, metavar="[WORD]...")
@click.pass_context
def help_command(ctx: click.Context, words: tuple[str, ...]) -> None:
    """Show help for a command, or for an order of a session.

    \b
    Example:  trainer help
              trainer help depth
              trainer help boat check
    """
    order = parse(" ".join((HELP_HEAD, *words))) if words else None
    root = ctx.find_root()
    try:
        root.command.main([*words, "--help"], prog_name=root.info_name, standalone_mode=False)
    except click.UsageError as none:
        if order is None or isinstance(order, BadOrder):
            reason = f"; as an order: {order.reason}" if order else ""
            ctx.fail(f"{none.message}{reason}")
    else:
        if order is None or isinstance(order, BadOrder):
            return
        click.echo()
    click.echo("\n".join(help_text(order.word)))
