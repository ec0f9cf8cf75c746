"""Where the page listens: an address of this machine, and a port that is free."""

from __future__ import annotations

import socket

from omma._core import Error

# Where nobody says which, the first of these that is free.
FIRST_PORT, PORTS_TRIED = 8090, 20
LOOPBACK = ("127.0.0.1", "localhost", "::1")
_IN_USE = (98, 48, 10048)  # of Linux, macOS, Windows


def is_loopback(host: str) -> bool:
    """Whether only this machine gets to an address."""
    return host.strip("[]") in LOOPBACK or host.startswith("127.")


def listening_socket(host: str, port: int | None) -> socket.socket:
    """A socket that listens: on that port, or where None is said on the first free one.

    Raises:
        omma.Error: the port is in use, or the host is none of this machine's.
    """
    tried = range(FIRST_PORT, FIRST_PORT + PORTS_TRIED) if port is None else (port,)
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family = found[0][0]
    except (OSError, UnicodeError) as error:
        raise Error(f"host: expected an address of this machine, found '{host}': {error}") from None
    for one in tried:
        listener = socket.socket(family, socket.SOCK_STREAM)
        # What has just been closed may be opened again at once; what is in use stays refused.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, one))
            listener.listen(64)
            return listener
        except OSError as error:
            listener.close()
            if error.errno not in _IN_USE:
                raise Error(
                    f"host: cannot listen at {host}, port {one}: {error.strerror}"
                ) from None
    if port is None:
        raise Error(
            f"port: all from {tried[0]} to {tried[-1]} are in use; say another (--port), or 0 for "
            "any that is free"
        )
    raise Error(
        f"port: {port} is in use by another program; say another (--port), 0 for any that is free"
    )
