"""The command ``trainer web``: it serves the pages of a session that runs already.

``run`` starts the same server for a session of its own, by this command with ``--owner``. The
libraries of the server are an extra, so they are looked for before anything starts.
"""

from typing import Any, Final

import click

from trainer.cli.options import WEB_ADDRESS, connect_option, page_options
from trainer.config.extras import require_library

PAGES_NEED: Final = ("starlette", "uvicorn", "websockets", "segno")  # libraries of the extra


@click.command()
@connect_option
@click.option(
    "--web",
    "address",
    default=WEB_ADDRESS,
    metavar="HOST:PORT",
    help="Where the pages are; beyond this machine only for a session with --token.",
)
@page_options
@click.option(
    "--open/--no-open",
    "opens",
    default=True,
    show_default=False,
    help="Open them in a browser here.",
)
# A session that begins the pages itself passes them the number of its listening socket.
@click.option("--owner", type=int, hidden=True)
def web(
    *,
    url: str | None,
    address: str,
    opens: bool,
    owner: int | None,
    **options: Any,
) -> None:
    """Serve the stations of a running session as pages for browsers.

    \b
    Example:  trainer web
              trainer web --connect tcp://bridge:17800 --web 0.0.0.0:8080

    It goes on when the session ends, and serves the next that begins there. `trainer run --web`
    and `trainer serve --web HOST:PORT` begin both at once. Ctrl-C ends it, exit code 0.
    """
    require_pages("trainer web")
    from trainer.web import launch
    from trainer.web.front import front_of

    certificate = launch.certificate_of(options["cert"], options["key"])
    front = front_of(options["public_url"], options["proxy"], options["cert"])
    where = launch.address_of(address, certificate, front)
    if owner is None or url is None:
        launch.serve_pages(url, where, certificate, opens=opens)
    else:
        launch.serve_owner(url, where, certificate, owner, opens=opens)


def require_pages(asked: str) -> None:
    """Check that the libraries of the pages are installed; ConfigError naming their extra."""
    for library in PAGES_NEED:
        require_library(library, asked)
