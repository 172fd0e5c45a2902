"""The reverse proxy before the pages: their public address, and whom the proxy speaks for.

Browsers send their requests to the proxy's address, and the proxy sends them on to this server.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from ipaddress import IPv4Network, IPv6Network, ip_network
from pathlib import Path
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import Scope

from trainer.config.files import ConfigError
from trainer.io.machine import address_of
from trainer.web.pages import PAGES

PUBLIC_URL_FORM: Final = re.compile(
    r"(?P<scheme>https?)://(?P<host>\[[0-9a-f:.]+\]|[a-z0-9](?:[a-z0-9.-]*[a-z0-9])?)"
    r"(?::0*(?P<port>[1-9][0-9]{0,4}))?(?P<path>(?:/[\w~-][\w.~-]*)*)/?",
    re.ASCII | re.IGNORECASE,
)
MAX_PORT: Final = 65535
DEFAULT_PORTS: Final = {"http": "80", "https": "443"}  # which a browser leaves out
OWN_PATHS: Final = {
    *("/assets", "/boat", "/boats", "/class", "/debrief", "/line", "/seat", "/word"),
    *(f"/{page.name}" for page in PAGES),
}
EXAMPLE_URL: Final = "https://school.example/trainer/"


@dataclass(frozen=True)
class Front:
    """What stands before the pages: their public address, and the proxies that are trusted."""

    origin: str  # as a browser writes it: scheme, host, and a port that is not the usual one
    host: str
    root: str  # the path, "" for none
    proxies: tuple[IPv4Network | IPv6Network, ...]

    @property
    def url(self) -> str:
        """Return the address for a browser."""
        return f"{self.origin}{self.root}/"

    def trusts(self, host: str) -> bool:
        """Return whether a machine is a proxy that may name the client of a request."""
        address = address_of(host)
        return address is not None and any(address in network for network in self.proxies)

    def restore_request(self, scope: Scope) -> Scope:
        """Return a request as the browser sent it to the public address.

        The proxy may have taken that path away, or not. The client is None if it names none.
        """
        scheme, _, place = self.origin.partition("://")
        path, peer = scope["path"], scope["client"]
        sent = {
            **scope,
            "scheme": scheme if scope["type"] == "http" else scheme.replace("http", "ws"),
            "root_path": self.root,
            "path": path if f"{path}/".startswith(f"{self.root}/") else self.root + path,
            "client": self._client_of(scope) if self.trusts(peer[0]) else peer,
        }
        MutableHeaders(scope=sent)["host"] = place
        return sent

    def _client_of(self, scope: Scope) -> tuple[str, int] | None:
        """Return the last address in X-Forwarded-For that is no trusted proxy's, None for none.

        Each proxy adds the address that it sees, so all before that one may be forged.
        """
        client = ""
        for hop in reversed(",".join(Headers(scope=scope).getlist("x-forwarded-for")).split(",")):
            client = str(address_of(hop.strip()) or "")
            if not self.trusts(client):
                break
        return (client, 0) if client else None


def front_of(public_url: str | None, proxies: Sequence[str], cert: Path | None) -> Front | None:
    """Return what stands before the pages, None for nothing; ConfigError."""
    if public_url is None:
        if proxies:
            raise ConfigError(f"--proxy {proxies[0]}: add --public-url, such as {EXAMPLE_URL}")
        return None
    match, wrong = PUBLIC_URL_FORM.fullmatch(public_url), f"--public-url {public_url}"
    if match is None or int(match["port"] or 1) > MAX_PORT:
        raise ConfigError(
            f"{wrong}: say it as a browser shows it, such as {EXAMPLE_URL}: http or https, a host, "
            "plain letters, nothing behind the path"
        )
    scheme, host, root = match["scheme"].lower(), match["host"].lower(), match["path"]
    if cert is not None and scheme == "http":
        raise ConfigError(f"{wrong}: with --cert pages come by https: say https://, or no --cert")
    if root in OWN_PATHS:  # with this path taken away or not, a request would mean two things
        raise ConfigError(f"{wrong}: the pages have a {root} of their own: choose another path")
    port = "" if match["port"] in (None, DEFAULT_PORTS[scheme]) else f":{match['port']}"
    networks = tuple(map(proxy_network, proxies))
    return Front(f"{scheme}://{host}{port}", host.strip("[]"), root, networks)


def proxy_network(text: str) -> IPv4Network | IPv6Network:
    """Return the network of ``--proxy``; ConfigError, also for one that trusts everybody."""
    try:
        network = ip_network(text)
    except ValueError:
        network = None
    if network is None or not network.prefixlen:
        raise ConfigError(
            f"--proxy {text}: say the proxy's address or network: 127.0.0.1, or 10.0.0.0/24"
        )
    return network
