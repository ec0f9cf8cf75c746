"""The web socket of each open page beside viser's: live pictures go out, what hands do comes in.

A picture goes to a browser when it has shown the one before; what is late is left out. So one slow
browser makes no other wait, and what proxies hold back does not pile up.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from aiohttp import WSMsgType, web

#: Pictures by the number that goes before them; a file to keep comes as the last.
STREAMS = ("eye", "camera")
FILE = 255

_LONGEST_MESSAGE = 4096
_LARGEST = 1 << 14  # of a screen, pixels
# So often is asked whether a browser is there, which has half of it to answer, as busy machines may
# need; proxies end what is silent for 60 s.
ALIVE_S = 50.0

Reply = Callable[[bytes], None]
OnMessage = Callable[[dict[str, Any], Reply], None]


@dataclass
class _Watcher:
    socket: web.WebSocketResponse
    news: asyncio.Event = field(default_factory=asyncio.Event)
    free: asyncio.Event = field(default_factory=asyncio.Event)
    sent: dict[str, int] = field(default_factory=dict)
    files: list[bytes | str] = field(default_factory=list)
    size: tuple[int, int] = (0, 0)


class Watchers:
    """All open pages, in the thread of the door's loop.

    Args:
        on_message: called with what a browser says, an object of JSON, and with a function by which
            any thread can send that browser a file.
    """

    def __init__(self, on_message: OnMessage) -> None:
        self._on_message = on_message
        self._all: list[_Watcher] = []
        self._latest: dict[str, tuple[int, bytes]] = {}

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the largest picture that fits them, pixels; 0 where none
        says."""
        sizes = [one.size for one in list(self._all)]
        return max((w for w, _ in sizes), default=0), max((h for _, h in sizes), default=0)

    def note(self, text: str) -> None:
        """A line for all of them."""
        for one in self._all:
            one.files.append(text)
            one.news.set()

    def show(self, name: str, jpeg: bytes) -> None:
        """The next picture of a stream."""
        number, _ = self._latest.get(name, (0, b""))
        self._latest[name] = (number + 1, jpeg)
        for one in self._all:
            one.news.set()

    async def serve(self, request: web.Request) -> web.WebSocketResponse:
        """Until the browser goes."""
        socket = web.WebSocketResponse(
            heartbeat=ALIVE_S, max_msg_size=_LONGEST_MESSAGE, compress=False
        )
        await socket.prepare(request)
        watcher = _Watcher(socket)
        watcher.free.set()
        watcher.news.set()
        self._all.append(watcher)
        sending = asyncio.ensure_future(self._send(watcher))
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self._take(watcher, message.data)
        finally:
            self._all.remove(watcher)
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)
        return socket

    async def close(self) -> None:
        """End them all."""
        for one in list(self._all):
            await one.socket.close()

    async def _send(self, watcher: _Watcher) -> None:
        while True:
            await watcher.news.wait()
            watcher.news.clear()
            while watcher.files:
                file = watcher.files.pop(0)
                if isinstance(file, str):
                    await watcher.socket.send_str(file)
                else:
                    await watcher.socket.send_bytes(bytes([FILE]) + file)
            for index, name in enumerate(STREAMS):
                if self._latest.get(name, (0, b""))[0] == watcher.sent.get(name, 0):
                    continue
                await watcher.free.wait()
                watcher.free.clear()
                watcher.sent[name], jpeg = self._latest[name]
                await watcher.socket.send_bytes(bytes([index]) + jpeg)

    def _take(self, watcher: _Watcher, text: str) -> None:
        try:
            message = json.loads(text)
        except ValueError:
            return
        if not isinstance(message, dict):
            return
        if message.get("do") == "took":
            watcher.free.set()
            return
        if message.get("do") == "size":
            size = message.get("width"), message.get("height")
            if all(isinstance(one, int) and 0 <= one <= _LARGEST for one in size):
                watcher.size = size  # type: ignore[assignment]
        loop = asyncio.get_running_loop()

        def send_file(file: bytes) -> None:
            def put() -> None:
                watcher.files.append(file)
                watcher.news.set()

            with suppress(RuntimeError):  # closed meanwhile
                loop.call_soon_threadsafe(put)

        self._on_message(message, send_file)
