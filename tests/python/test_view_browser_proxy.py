"""The window's page behind a proxy, in a browser: nginx as docs/view.md says, and proxies that were
not told of, where the page says why nothing comes."""

import re
import shutil
import subprocess
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from conftest import make_eye, write_gltf
from view_browser import Browser, until

import omma
from omma.view.ports import listening_socket

pytest.importorskip("viser", reason="viser (omma[view]) is not installed")
NGINX = shutil.which("nginx") or shutil.which("/usr/sbin/nginx")
pytestmark = pytest.mark.skipif(NGINX is None, reason="nginx is not installed")
PAGE = Path(__file__).parents[2] / "docs" / "view.md"


def free_port():
    with listening_socket("127.0.0.1", 0) as listener:
        return listener.getsockname()[1]


def lines_of_docs(inner):
    """The location that the docs give for nginx."""
    block = re.search(r"```nginx\n(.*?)```", PAGE.read_text(), re.DOTALL).group(1)
    return block.replace("127.0.0.1:8090", f"127.0.0.1:{inner}")


@pytest.fixture(scope="module")
def chromium():
    with Browser() as browser:
        yield browser


@pytest.fixture
def browser(chromium):
    yield chromium
    chromium.close_pages()


@pytest.fixture
def scene(tmp_path):
    write_gltf(tmp_path / "ground.gltf", cameras=[("bee", None, {"translation": [0, 1.0, 4]})])
    return omma.load_scene(tmp_path / "ground.gltf")


@pytest.fixture
def nginx(tmp_path):
    """Starts nginx with locations; at a port."""
    started = []

    def start(port, locations):
        configuration = (
            f"daemon off; pid {tmp_path}/pid; error_log {tmp_path}/error.log; events {{}}\n"
            f"http {{ access_log off; client_body_temp_path {tmp_path}/b; "
            f"proxy_temp_path {tmp_path}/p; fastcgi_temp_path {tmp_path}/f; "
            f"uwsgi_temp_path {tmp_path}/u; scgi_temp_path {tmp_path}/s;\n"
            f"server {{ listen 127.0.0.1:{port}; {locations} }} }}"
        )
        (tmp_path / "nginx.conf").write_text(configuration)
        started.append(subprocess.Popen([NGINX, "-p", tmp_path, "-c", tmp_path / "nginx.conf"]))
        until(lambda: answers(port))

    yield start
    for one in started:
        one.terminate()
        one.wait(20)


def answers(port):
    try:
        urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5)
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False
    return True


def shows(page, window):
    """The page is live: it has the picture, and what it asks for is done."""
    page.locator("#omma-eye").wait_for()
    until(lambda: page.evaluate("document.getElementById('omma-eye').naturalWidth") > 100)
    before = window.look.pose
    page.keyboard.press("n")
    until(lambda: window.look.pose != before)


def test_it_works_behind_nginx_as_the_docs_say(browser, scene, nginx):
    inner, outer = free_port(), free_port()
    proxy = f"http://localhost:{outer}/bees/"
    with omma.view.show(scene, make_eye(40), port=inner, proxy=proxy) as window:
        nginx(outer, lines_of_docs(inner))
        page = browser.open(window.url)
        shows(page, window)
        page.close()
        # Without its last slash.
        page = browser.open(window.url.rstrip("/"), wait=False)
        assert page.url.split("?")[0] == window.url
        assert not browser.said


def test_it_works_where_the_proxy_leaves_the_path(browser, scene, nginx):
    inner, outer = free_port(), free_port()
    proxy = f"http://localhost:{outer}/bees/"
    with omma.view.show(scene, make_eye(40), port=inner, proxy=proxy) as window:
        nginx(outer, lines_of_docs(inner).replace(f":{inner}/;", f":{inner};"))
        shows(browser.open(window.url), window)
        assert not browser.said


def test_it_works_with_the_host_passed_on_and_no_option(browser, scene, nginx):
    inner, outer = free_port(), free_port()
    with omma.view.show(scene, make_eye(40), port=inner) as window:
        more = "proxy_set_header Host $http_host; proxy_pass"
        nginx(outer, lines_of_docs(inner).replace("proxy_pass", more))
        # The page itself finds the folder; nginx adds the first slash that is left out.
        page = None
        for path in ("bees", "bees/", "bees/view", "bees/view/"):
            if page is not None:
                page.close()  # or it goes on drawing
            page = browser.open(f"http://localhost:{outer}/{path}", wait=False)
            page.wait_for_url(re.compile(f"^http://localhost:{outer}/bees/view/($|[?])"))
        page.wait_for_selector("#omma-status", state="attached")
        shows(page, window)
        assert not browser.said


def trouble_of(page):
    page.locator("#omma-trouble").wait_for()
    return page.inner_text("#omma-trouble")


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0"])
def test_a_proxy_that_was_not_told_of_is_said_on_the_page(browser, scene, nginx, host):
    inner, outer = free_port(), free_port()
    with omma.view.show(scene, make_eye(40), port=inner, host=host) as window:
        nginx(outer, lines_of_docs(inner))
        word = window.url.split("/")[3]
        page = browser.open(f"http://localhost:{outer}/bees/{word}/", wait=False)
        said = trouble_of(page)
        assert f"--proxy http://localhost:{outer}/bees/ and open the address" in said


def test_a_proxy_without_web_sockets_is_said_on_the_page(browser, scene, nginx):
    inner, outer = free_port(), free_port()
    proxy = f"http://localhost:{outer}/bees/"
    with omma.view.show(scene, make_eye(40), port=inner, proxy=proxy) as window:
        nginx(outer, f"location /bees/ {{ proxy_pass http://127.0.0.1:{inner}/; }}")
        page = browser.open(window.url, wait=False)
        assert "has to pass on the headers Upgrade and Connection" in trouble_of(page)
        # And what has ended is said too; where it comes again it goes on.
        page.close()
        page = browser.open(f"http://localhost:{inner}/{window.url.split('/')[4]}/")
        shows(page, window)
    assert "has ended" in trouble_of(page)
