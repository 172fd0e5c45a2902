"""The machine of an address, under which its connections and its guesses are counted."""

import ipaddress
from typing import Final

THIS_MACHINE: Final = "127.0.0.1"  # whatever address its programs come from
SITE_BITS: Final = 64  # of an IPv6 address: one site has all that begin so


def machine_of(peer: str, own: str = "") -> str:
    """Return what the connections of a machine are counted under.

    ``own`` is the address at which it has come in, if that is known. A far machine may choose any
    address of its site; one of this server's own site is a neighbour, and counts alone.
    """
    address, here = address_of(peer), address_of(own)
    if address is None:
        return peer
    if address.is_loopback or address == here:
        return THIS_MACHINE
    if isinstance(address, ipaddress.IPv4Address) or address.is_link_local:
        return str(address)
    site = ipaddress.IPv6Network((int(address), SITE_BITS), strict=False)
    return str(address if here is not None and here in site else site)


def address_of(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an address, an IPv4 one where IPv6 carries it; None for no address."""
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address
