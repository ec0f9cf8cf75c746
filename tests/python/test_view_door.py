"""The door before the window: who gets in, what is answered, and what goes through."""

import asyncio
import json
import socket
import threading

import aiohttp
import pytest
from aiohttp import web
from view_checks import ask, wait_for

import omma
from omma.view.door import Door
from omma.view.passing import SCRIPTS, SECRET_HEADER
from omma.view.ports import listening_socket
from omma.view.rules import Rules, path_inside, proxy_address, refusal

TOKEN = Rules("abc123")
PLAIN = Rules()


class Inner:
    """Stands for viser: a page, a file, and a web socket that says everything back."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.requests = []
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        asyncio.set_event_loop(self.loop)
        app = web.Application()
        app.router.add_route("*", "/{path:.*}", self.answer)
        runner = web.AppRunner(app, access_log=None)
        self.loop.run_until_complete(runner.setup())
        self.loop.run_until_complete(web.SockSite(runner, self.listener).start())
        self.loop.run_forever()
        self.loop.run_until_complete(runner.cleanup())

    async def answer(self, request):
        self.requests.append((request.raw_path, dict(request.headers)))
        if request.headers.get("Upgrade"):
            back = web.WebSocketResponse(protocols=["viser-v1"])
            await back.prepare(request)
            async for message in back:
                await back.send_bytes(message.data)
            return back
        return web.Response(text="<title>Viser</title>inner", content_type="text/html")


@pytest.fixture
def make_door():
    made, inner, messages = [], Inner(), []

    def make(rules=PLAIN):
        listener = listening_socket("127.0.0.1", 0)
        made.append(
            Door(listener, inner.port, secret="s3cret", rules=rules, settings='{"a": "</script>"}',
                 on_message=lambda *message: messages.append(message))
        )  # fmt: skip
        return made[-1], inner, messages

    yield make
    for door in made:
        door.close()
    inner.loop.call_soon_threadsafe(inner.loop.stop)
    assert not any(one.name == "omma-view-door" for one in threading.enumerate())


def over_socket(port, path, use, **options):
    """What ``use`` gives of an open web socket; the status where it does not open."""

    async def run():
        async with aiohttp.ClientSession() as session:
            try:
                async with session.ws_connect(f"http://127.0.0.1:{port}{path}", **options) as one:
                    return await asyncio.wait_for(use(one), 20)
            except aiohttp.WSServerHandshakeError as error:
                return error.status

    return asyncio.run(run())


async def echo(one):
    await one.send_bytes(b"over and back")
    return await one.receive_bytes()


def test_the_token_opens_and_nothing_else(make_door):
    door, inner, _ = make_door(TOKEN)
    status, page = ask(door.port, "/abc123/")
    assert status == 200
    assert page.endswith(b"inner")
    assert ask(door.port, "/abc123/page.js?x=1")[0] == 200
    path, headers = inner.requests[-1]
    assert path == "/page.js"
    assert headers[SECRET_HEADER] == "s3cret"
    assert "abc123" not in str(inner.requests)
    assert over_socket(door.port, "/abc123", echo) == b"over and back"
    before = len(inner.requests)
    for path in ("/", "/abc12", "/abc1234/", "/?abc123", "/ABC123/", "//abc123/", "/x/abc123/",
                 "/live", "/x/live"):  # fmt: skip
        status, text = ask(door.port, path)
        assert status == 403
        assert b"token" in text
        assert over_socket(door.port, path, echo) == 403
    assert len(inner.requests) == before


def test_a_second_request_on_a_connection_does_not_slip_through(make_door):
    door, inner, _ = make_door(TOKEN)
    with socket.create_connection(("127.0.0.1", door.port), timeout=20) as connection:
        good = b"GET /abc123/ HTTP/1.1\r\nHost: x\r\n\r\n"
        connection.sendall(good + b"GET /secret HTTP/1.1\r\nHost: x\r\n\r\n")
        answer = b""
        while piece := connection.recv(65536):
            answer += piece
    assert answer.count(b"HTTP/1.1 ") == 1
    assert b"\r\nConnection: close\r\n" in answer
    assert len(inner.requests) == 1


def test_other_pages_and_other_names_are_kept_out(make_door):
    door, inner, _ = make_door()
    assert ask(door.port, "/view/")[0] == 200
    assert ask(door.port, "/view/", Host=f"localhost:{door.port}")[0] == 200
    assert ask(door.port, "/view/", Host=f"[::1]:{door.port}")[0] == 200
    before = len(inner.requests)
    for host in ("evil.example", "127.0.0.1.evil.example", "", "[", "localhost.evil.example"):
        status, text = ask(door.port, "/view/", Host=host)
        assert status == 403
        assert b"--proxy" in text
    assert ask(door.port, "/view/", Origin="http://evil.example")[0] == 403
    evil = {"Origin": "http://evil.example"}
    for path in ("/view", "/view/live"):
        assert over_socket(door.port, path, echo, headers=evil) == 403
    assert len(inner.requests) == before
    own = {"Origin": f"http://127.0.0.1:{door.port}"}
    assert over_socket(door.port, "/view", echo, headers=own) == b"over and back"
    assert ask(door.port, "/view/", method="DELETE")[0] == 405
    assert ask(door.port, "/other/")[0] == 404
    assert over_socket(door.port, "/view/other", echo) == 404


def headers(host, origin=None, **more):
    found = {"Host": host, **{name.replace("_", "-"): value for name, value in more.items()}}
    return found if origin is None else {**found, "Origin": origin}


def test_a_proxy_is_let_in_by_one_option_and_nobody_else():
    proxy = proxy_address("https://lab.example/bees")
    assert proxy.geturl() == "https://lab.example/bees/"
    rules = Rules("abc123", proxy)
    # Whatever Host it puts there: nginx's own default, the address that was asked for, any.
    for host in ("127.0.0.1:8090", "lab.example", "inner"):
        assert refusal(rules, "abc123", headers(host, "https://lab.example")) is None
        assert refusal(rules, "abc123", headers(host)) is None
        assert "token" in refusal(rules, "view", headers(host, "https://lab.example"))
        said = refusal(rules, "abc123", headers(host, "https://evil.example"))
        assert "--proxy https://evil.example/" in said
    # Its path is taken away by some, and left by others.
    for path in ("/abc123/live", "/bees/abc123/live?x=1"):
        assert path_inside(rules, path) == ("abc123", "live")
    assert path_inside(rules, "/bees/abc123") == ("abc123", None)
    assert path_inside(PLAIN, "/view/?x") == ("view", "")
    # One that says which host was asked for needs no option for a page with a token.
    known = headers("inner:80", "https://lab.example", X_Forwarded_Host="lab.example, inner")
    assert refusal(TOKEN, "abc123", known) is None
    assert refusal(TOKEN, "abc123", headers("inner:80", "https://lab.example")) is not None
    # But it says nothing of the name by which a page without one is asked for.
    rebound = headers("evil.example", None, X_Forwarded_Host="127.0.0.1")
    assert "evil.example" in refusal(PLAIN, "view", rebound)


@pytest.mark.parametrize(
    "text", ["lab.example", "ftp://lab.example", "http://", "http://a:b/", "http://x/?a", "", "//x"]
)
def test_a_proxy_that_is_no_address_is_said(text):
    with pytest.raises(omma.Error, match="proxy: expected the address"):
        proxy_address(text)


def test_the_page_says_why_nothing_comes(make_door):
    door, _, _ = make_door()
    _, text = ask(door.port, "/view/why?origin=https://lab.example&folder=/bees/")
    assert b"--proxy https://lab.example/bees/ and" in text
    _, text = ask(door.port, f"/view/why?origin=http://127.0.0.1:{door.port}")
    assert b"Upgrade and Connection" in text


def test_addresses_without_their_last_slash_go_on(make_door):
    door, _, _ = make_door()
    # Only the browser knows below which path it came: the page says where to go on from there.
    status, text = ask(door.port, "/")
    assert status == 200
    assert b"location.pathname" in text
    assert b"'view/'" in text
    with socket.create_connection(("127.0.0.1", door.port), timeout=20) as connection:
        connection.sendall(b"GET /view HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        answer = connection.recv(65536)
    assert b" 301 " in answer
    assert b"\r\nLocation: view/\r\n" in answer


def test_the_page_has_the_scripts(make_door):
    door, _, _ = make_door()
    _, page = ask(door.port, "/view/")
    assert b"<title>Omma</title>" in page
    # What ends a script is no end of one in the settings.
    assert page.count(b"</script>") == 1 + len(SCRIPTS)
    for name in (*SCRIPTS, "page.css"):
        assert f"omma/{name}".encode() in page
        status, text = ask(door.port, f"/view/omma/{name}")
        assert status == 200
        assert len(text) > 100
    for name in ("..%2frules.py", "rules.py", "../rules.py", ""):
        assert ask(door.port, f"/view/omma/{name}")[0] == 404


def test_nonsense_at_the_door_is_answered(make_door, capfd):
    door, _, _ = make_door()
    for head in (b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9\r\n\r\n", b"\xff\x00 / x\r\n\r\n",
                 b"GET / HTTP/1.1\r\nno colon\r\n\r\n", b"x" * 100_000):  # fmt: skip
        with socket.create_connection(("127.0.0.1", door.port), timeout=20) as connection:
            connection.sendall(head)
            connection.shutdown(socket.SHUT_WR)
            try:
                answer = connection.recv(65536)
            except ConnectionResetError:
                continue  # the rest was not read
            assert answer == b"" or answer.startswith((b"HTTP/1.1 400", b"HTTP/1.0 400"))
    assert ask(door.port, "/view/")[0] == 200
    assert capfd.readouterr() == ("", "")


def test_pictures_go_out_and_hands_come_in(make_door):
    door, _, messages = make_door()

    async def use(one):
        await one.send_str(json.dumps({"do": "pick", "x": 0.25, "y": 0.5}))
        for nonsense in ("{", "3", "[]", '"x"', '{"do": "size", "width": -3, "height": "x"}'):
            await one.send_str(nonsense)
        door.show("eye", b"first")
        assert await one.receive_bytes() == b"\0first"
        # What comes before a browser has shown the one before is left out but for the last.
        for k in range(50):
            door.show("eye", b"later %d" % k)
        door.note("a word")
        await asyncio.sleep(0.3)
        await one.send_str('{"do": "took"}')
        found = [await one.receive(), await one.receive()]
        await one.send_str(json.dumps({"do": "size", "width": 640, "height": 480}))
        wait_for(lambda: door.size == (640, 480))
        messages[-1][1](b"a file")
        assert await one.receive_bytes() == b"\xffa file"
        return [each.data for each in found]

    found = over_socket(door.port, "/view/live", use)
    assert b"\0later 49" in found
    assert messages[0][0] == {"do": "pick", "x": 0.25, "y": 0.5}
    # A browser that is gone is no trouble for the next.
    wait_for(lambda: door.size == (0, 0))
    assert ask(door.port, "/view/")[0] == 200


def test_a_port_in_use_is_said():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(omma.Error, match=f"port: {port} is in use"):
            listening_socket("127.0.0.1", port)
    with pytest.raises(omma.Error, match="host: "):
        listening_socket("no.such.host.invalid", 0)
    with pytest.raises(omma.Error, match=r"host: cannot listen at 192\.0\.2\.1"):
        listening_socket("192.0.2.1", 0)
