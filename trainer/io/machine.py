"""The machine behind a network address. Limits count connections and wrong tokens by machine.

``server`` and the pages' server ask it. A machine may have many addresses, above all by IPv6. If
limits counted addresses, it could pass them by changing its address.
"""

import ipaddress
from typing import Final

THIS_MACHINE: Final = "127.0.0.1"  # whatever address its programs come from
SITE_BITS: Final = 64  # [bits] of an IPv6 address; one site has all addresses that share them


def machine_of(peer: str, own: str = "") -> str:
    """Return the name under which a machine's connections are counted.

    ``own`` is this machine's address of that connection, if it is known. A far site counts as one
    machine, because its machines may choose any address there. On this server's own site each
    address counts alone, because the trainees' machines are there.
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


def is_here(host: str) -> bool:
    """Return whether a host is an address that only programs of this machine reach."""
    address = address_of(host)
    return host == "localhost" or (address is not None and address.is_loopback)


def address_of(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an IP address, as IPv4 where IPv6 carries one; None for none."""
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address
