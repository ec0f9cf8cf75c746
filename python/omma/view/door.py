"""The door: the one port that browsers come to, in front of viser's own, which lets nobody else in.

viser asks nobody who they are, and listens where anyone of this machine may come. So it listens on
a port of its own of 127.0.0.1, and turns away who does not bring the secret that only this door
knows. The door looks at every request (`rules`), gives the page and its web socket (`passing`), and
has a web socket of its own for pictures and hands (`watchers`). Every address on the page is said
beside the page's own, so that a proxy can show it below any path.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import threading
from contextlib import suppress

import aiohttp
from aiohttp import web

from omma.view.passing import Viser, page_file
from omma.view.rules import Rules, path_inside, refusal, refusal_of_origin
from omma.view.watchers import OnMessage, Watchers

_CLOSE_S = 2.0
# Whoever comes without the last slash of a path: only the browser knows what path that was.
_ON_TO_PAGE = (
    "<!doctype html><title>Omma</title><script>location.replace("
    "location.pathname.replace(/\\/*$/,'/')+'{word}/')</script>"
)
_NO_SOCKETS = (
    "Nothing live comes through: web sockets end on their way from here to omma. A proxy in "
    "between has to pass on the headers Upgrade and Connection; docs/view.md, 'Behind a proxy', "
    "says how."
)


class Door:
    """Listens, looks at requests and answers or passes on those that may; a thread of its own.

    Args:
        listener: of `omma.view.ports.listening_socket`.
        inner_port: viser's, on 127.0.0.1.
        secret: what viser is shown with each request that may pass.
        rules: who may come in.
        settings: JSON for the page's scripts.
        on_message: as of `Watchers`; called in this thread.
    """

    def __init__(
        self,
        listener: socket.socket,
        inner_port: int,
        *,
        secret: str,
        rules: Rules,
        settings: str,
        on_message: OnMessage,
    ) -> None:
        self._listener, self._inner_port = listener, inner_port
        self._secret, self._rules, self._settings = secret, rules, settings
        self._watchers = Watchers(on_message)
        self._loop = asyncio.new_event_loop()
        self._ended = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="omma-view-door", daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._listener.getsockname()[1])

    @property
    def size(self) -> tuple[int, int]:
        """As of `Watchers`."""
        return self._watchers.size

    def show(self, name: str, jpeg: bytes) -> None:
        """Give all who watch a stream its next picture; from any thread."""
        with suppress(RuntimeError):  # closed meanwhile
            self._loop.call_soon_threadsafe(self._watchers.show, name, jpeg)

    def note(self, text: str) -> None:
        """A line for a moment in every browser; from any thread."""
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._watchers.note, text)

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
        self._viser = Viser(self._inner_port, self._secret, self._settings)
        app = web.Application()
        app.router.add_route("*", "/{path:.*}", self._answer)
        runner = web.AppRunner(
            app, access_log=None, logger=_silent(), shutdown_timeout=_CLOSE_S, handle_signals=False
        )
        await runner.setup()
        try:
            await web.SockSite(runner, self._listener).start()
            await self._ended.wait()
        finally:
            await self._watchers.close()
            await self._viser.close()
            await runner.cleanup()

    async def _answer(self, request: web.Request) -> web.StreamResponse:
        answer = await self._answer_of(request)
        # A connection for each request: plain proxies look at the first of a connection alone.
        answer.force_close()
        return answer

    async def _answer_of(self, request: web.Request) -> web.StreamResponse:
        word, path = path_inside(self._rules, request.raw_path)
        refused = refusal(self._rules, word, request.headers)
        if refused is not None:
            return _say(403, refused)
        if request.method != "GET":
            return _say(405, "Only GET is answered here.")
        wants_socket = request.headers.get("Upgrade", "").lower() == "websocket"
        if word != self._rules.word:
            if word:
                return _say(404, "There is no such page here.")
            on = _ON_TO_PAGE.format(word=self._rules.word)
            return web.Response(text=on, content_type="text/html")
        try:
            if wants_socket:
                return await self._socket(request, path)
            if path is None:
                # What the page asks for is beside it, in the folder that the word is.
                return web.Response(status=301, headers={"Location": f"{word}/"})
            return await self._page(request, path)
        except aiohttp.ClientError:
            return _say(502, "The page has ended.")

    async def _page(self, request: web.Request, path: str) -> web.StreamResponse:
        if path == "":
            return await self._viser.page()
        if path == "why":
            return _say(200, self._why_no_socket(request))
        if path.startswith("omma/"):
            return page_file(path[len("omma/") :]) or _say(404, "There is no such file here.")
        return await self._viser.file(path)

    async def _socket(self, request: web.Request, path: str | None) -> web.StreamResponse:
        # viser looks for its own at the page's address without the last slash.
        if not path:
            return await self._viser.socket(request)
        if path == "live":
            return await self._watchers.serve(request)
        return _say(404, "There is no such web socket here.")

    def _why_no_socket(self, request: web.Request) -> str:
        """For a page that has come, and whose web sockets do not open."""
        origin, folder = request.query.get("origin"), request.query.get("folder", "/")
        return refusal_of_origin(self._rules, origin, request.headers, folder) or _NO_SOCKETS


def _silent() -> logging.Logger:
    """Where aiohttp says what is wrong with requests: nobody asked."""
    logger = logging.getLogger("omma.view.door")
    logger.propagate = False
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
    return logger


def _say(status: int, text: str) -> web.Response:
    return web.Response(status=status, text=text, headers={"X-Content-Type-Options": "nosniff"})
