"""The door: the one port that browsers come to, in front of viser's own, which lets nobody else in.

viser asks nobody who they are, and listens where anyone of this machine may come. So it listens on
a port of its own of 127.0.0.1, and turns away who does not bring the secret that only this door
knows. The door looks at every request: at the token in its address, where one is asked for; at the
``Host``, where none is, so that no page of the web gets in by a name that leads here (DNS
rebinding); and at the ``Origin`` of web sockets. It also has what the page itself needs: the live
pictures, as streams of JPEG, and clicks on them.
"""

from __future__ import annotations

import asyncio
import hmac
import http
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

from omma._core import Error

SECRET_HEADER = "X-Omma-Door"
# Where nobody says which, the first of these that is free.
FIRST_PORT, PORTS_TRIED = 8090, 20

_LONGEST_HEAD = 16 << 10
_HEAD_S = 10.0  # a browser that says nothing for so long is gone
_CHUNK = 64 << 10
_BOUNDARY = b"omma-frame"
_LOOPBACK = ("127.0.0.1", "localhost", "::1", "[::1]")
# A browser shows a frame when the next has begun; of what holds still it gets this one again.
_AGAIN_S = 0.25

Click = Callable[[str, float, float], None]


def is_loopback(host: str) -> bool:
    """Whether only this machine gets to an address."""
    return host in _LOOPBACK or host.startswith("127.")


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
            if error.errno not in (98, 48, 10048):  # in use: of Linux, macOS, Windows
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


@dataclass(frozen=True)
class _Request:
    method: str
    path: str  # behind the token, with what is asked
    headers: dict[str, str]  # by names in small letters
    head: bytes  # as it goes on to viser


class Frames:
    """The last picture of a stream, and who waits for the next."""

    def __init__(self) -> None:
        self.latest: bytes | None = None
        self.waiting: set[asyncio.Event] = set()


class Door:
    """Listens, looks at requests and passes on those that may; a thread of its own.

    Args:
        listener: of `listening_socket`.
        inner_port: viser's, on 127.0.0.1.
        secret: what viser is shown with each request that may pass.
        token: what addresses begin with; "" for none.
        check_host: refuse requests by other names than those of this machine itself.
        on_click: called with the name of a picture and a place in it, 0 to 1 to the right and down.
    """

    def __init__(
        self,
        listener: socket.socket,
        inner_port: int,
        *,
        secret: str,
        token: str,
        check_host: bool,
        on_click: Click,
    ) -> None:
        self._listener, self._inner_port = listener, inner_port
        self._secret, self._token = secret, token
        self._check_host, self._on_click = check_host, on_click
        self.frames: dict[str, Frames] = {"eye": Frames(), "camera": Frames()}
        self._connections: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="omma-view-door", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._listener.getsockname()[1])

    def show(self, name: str, jpeg: bytes) -> None:
        """Give all who watch a stream its next picture; from any thread."""
        with suppress(RuntimeError):  # closed meanwhile
            self._loop.call_soon_threadsafe(self._show, name, jpeg)

    def _show(self, name: str, jpeg: bytes) -> None:
        frames = self.frames[name]
        frames.latest = jpeg
        for event in frames.waiting:
            event.set()

    def close(self) -> None:
        """End all connections and the thread."""
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        server = await asyncio.start_server(self._accept, sock=self._listener)
        await self._ended.wait()
        server.close()
        for task in list(self._connections):
            task.cancel()
        await asyncio.gather(*self._connections, return_exceptions=True)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._connections.add(task)
        try:
            await self._answer(reader, writer)
        except (OSError, asyncio.IncompleteReadError, asyncio.TimeoutError):
            pass  # the browser went away: there is nobody to tell
        except asyncio.CancelledError:
            pass  # closing
        finally:
            self._connections.discard(task)
            writer.close()

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), _HEAD_S)
            request = _parse(head)
        except (asyncio.LimitOverrunError, ValueError):
            return await _say(writer, 400, "This is no request of a browser.")
        refusal = self._refusal(request)
        if refusal is not None:
            return await _say(writer, *refusal)
        path = request.path
        wants_socket = request.headers.get("upgrade", "").lower() == "websocket"
        if self._token:
            path = path[1 + len(self._token) :]
            if not path.startswith("/") and not wants_socket:
                # What the page asks for is beside it, in the folder that the token is.
                return await _say(writer, 301, "", {"Location": f"/{self._token}/{path}"})
            path = path if path.startswith("/") else f"/{path}"
        name, _, kind = urlsplit(path).path[1:].partition(".")
        if kind == "mjpeg" and name in self.frames:
            await self._stream(writer, self.frames[name])
        elif kind == "click" and name in self.frames and request.method == "POST":
            await self._click(writer, name, urlsplit(path).query)
        elif request.method != "GET":
            await _say(writer, 405, "Only GET is answered here.")
        else:
            await self._pass_on(reader, writer, self._head_for_viser(request, path), wants_socket)

    def _refusal(self, request: _Request) -> tuple[int, str] | None:
        """Status and words where a request may not pass."""
        host = request.headers.get("host", "")
        if self._token:
            given = request.path.split("?")[0].split("/")[1]
            if not hmac.compare_digest(given.encode(), self._token.encode()):
                return 403, (
                    "This page needs the address with its token, which was printed where "
                    "'omma view' was started."
                )
        elif self._check_host and (urlsplit(f"//{host}").hostname or "") not in _LOOPBACK:
            return 403, "This page is shown at 127.0.0.1 and localhost only."
        origin = request.headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return 403, "Another page may not use this one."
        return None

    def _head_for_viser(self, request: _Request, path: str) -> bytes:
        """The request as it goes on: without the token, with the secret."""
        lines = request.head.split(b"\r\n")
        kept = [line for line in lines[1:-2] if not line.lower().startswith(b"x-omma-door")]
        first = f"{request.method} {path} HTTP/1.1".encode("latin-1")
        return b"\r\n".join([first, *kept, f"{SECRET_HEADER}: {self._secret}".encode(), b"", b""])

    async def _pass_on(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        head: bytes,
        both_ways: bool,
    ) -> None:
        inner_reader, inner_writer = await asyncio.open_connection("127.0.0.1", self._inner_port)
        try:
            inner_writer.write(head)
            # After a page nothing more of the browser's goes on: a second request on the same
            # connection would not have been looked at.
            ways = [asyncio.ensure_future(_copy(inner_reader, writer))]
            if both_ways:
                ways.append(asyncio.ensure_future(_copy(reader, inner_writer)))
            try:
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for way in ways:
                    way.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
        finally:
            inner_writer.close()

    async def _stream(self, writer: asyncio.StreamWriter, frames: Frames) -> None:
        """Each picture when the browser has taken the one before; what is late is left out."""
        kind = b"multipart/x-mixed-replace; boundary=" + _BOUNDARY
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Type: " + kind)
        writer.write(b"\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n--" + _BOUNDARY)
        news = asyncio.Event()
        frames.waiting.add(news)
        try:
            while True:
                news.clear()
                await _send_frame(writer, frames.latest)
                if not await _comes(news, _AGAIN_S):
                    await _send_frame(writer, frames.latest)
                    await news.wait()
        finally:
            frames.waiting.discard(news)

    async def _click(self, writer: asyncio.StreamWriter, name: str, query: str) -> None:
        try:
            place = {key: float(values[0]) for key, values in parse_qs(query).items()}
            x, y = place["x"], place["y"]
        except (KeyError, ValueError):
            return await _say(writer, 400, "Expected x and y, 0 to 1.")
        if not (0 <= x <= 1 and 0 <= y <= 1):
            return await _say(writer, 400, "Expected x and y, 0 to 1.")
        self._on_click(name, x, y)
        await _say(writer, 204, "")


def _parse(head: bytes) -> _Request:
    """The request; ValueError where it is none."""
    if len(head) > _LONGEST_HEAD:
        raise ValueError("too long")
    lines = head.decode("latin-1").split("\r\n")
    method, path, version = lines[0].split(" ")
    if not version.startswith("HTTP/1.") or not path.startswith("/"):
        raise ValueError("not HTTP/1")
    headers = {}
    for line in lines[1:-2]:
        name, colon, value = line.partition(":")
        if not colon or name != name.strip():
            raise ValueError("no header")
        headers[name.lower()] = value.strip()
    return _Request(method, path, headers, head)


async def _send_frame(writer: asyncio.StreamWriter, jpeg: bytes | None) -> None:
    if jpeg is not None:
        size = b"\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(jpeg)
        writer.write(size + jpeg + b"\r\n--" + _BOUNDARY)
        await writer.drain()


async def _comes(news: asyncio.Event, within_s: float) -> bool:
    try:
        await asyncio.wait_for(news.wait(), within_s)
    except asyncio.TimeoutError:
        return False
    return True


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while piece := await reader.read(_CHUNK):
        writer.write(piece)
        await writer.drain()


async def _say(
    writer: asyncio.StreamWriter, status: int, text: str, headers: dict[str, str] | None = None
) -> None:
    body = text.encode()
    lines = {
        "Content-Type": "text/plain; charset=utf-8",
        "Content-Length": str(len(body)),
        "Connection": "close",
        **(headers or {}),
    }
    head = "".join(f"{name}: {value}\r\n" for name, value in lines.items())
    phrase = http.HTTPStatus(status).phrase
    writer.write(f"HTTP/1.1 {status} {phrase}\r\n{head}\r\n".encode("latin-1") + body)
    await writer.drain()
