"""The command ``trainer help``: help for a command, or for an order."""

import click

from trainer.cli.types import Word
from trainer.io.orders.grammar import HELP_HEAD, BadOrder, parse
from trainer.io.orders.help import help_text
from trainer.io.orders.table import TOPICS

ORDER_WORDS = [head for topic in TOPICS for head in topic.heads]


@click.command("help")
@click.argument("word", type=Word(ORDER_WORDS), required=False)
@click.pass_context
def explain(ctx: click.Context, word: str | None) -> None:
    """Show help for a command, or for an order of a session.

    \b
    Example:  trainer help
              trainer help depth
              trainer help run
    """
    root = ctx.find_root()
    if word is None:
        click.echo(root.get_help())
        return
    command = (
        root.command.get_command(root, word) if isinstance(root.command, click.Group) else None
    )
    if command:
        click.echo(click.Context(command, info_name=word, parent=root).get_help())
    order = parse(f"{HELP_HEAD} {word}")
    if order is None or isinstance(order, BadOrder):
        if command is None:
            reason = f"; as an order: {order.reason}" if order else ""
            ctx.fail(f"no command {word!r}{reason}")
        return
    click.echo("\n".join([*([""] if command else []), *help_text(order.word)]))
