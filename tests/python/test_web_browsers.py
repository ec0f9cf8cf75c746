"""The page in browsers that lack something: SIMD, threads, WebGL, WebAssembly. It goes on and says
so."""

import numpy as np
import pytest
from view_browser import Browser, until
from web_pages import Served, built_engines, need_site, opened, seen


@pytest.fixture(scope="module")
def served():
    need_site()
    with Served() as served:
        yield served


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


def without(browser, url, script):
    """The page in a browser in which a script has run first."""
    page = browser.open("about:blank", wait=False)
    page.add_init_script(script)
    page.goto(url)
    return page


def test_every_build_of_the_engine_gives_the_same_bits(browser, served):
    start = f"{served.url}#scene=arena&eye=melophorus"
    page = opened(browser, start)
    wanted, *_ = seen(page)
    page.context.close()
    for kind in built_engines():
        page = opened(browser, start.replace("#", f"?engine={kind}#"))
        assert page.get_attribute("body", "data-ready") == kind
        assert np.array_equal(seen(page)[0].view(np.uint32), wanted.view(np.uint32))
        page.context.close()


def test_no_text_is_evaluated(browser, served):
    # As served here, with a Content-Security-Policy under which all other tests run, too.
    page = opened(browser, f"{served.url}#scene=arena&eye=melophorus")
    # Later: what Playwright itself evaluates may evaluate more.
    evaluated = """() => new Promise((done) => setTimeout(() => {
  try { done(new Function('return 1')()); } catch (error) { done(error.name); }
}))"""
    assert page.evaluate(evaluated) == "EvalError"
    assert not browser.said  # nor did the page try
    page.context.close()


def test_without_simd_it_is_slower_and_says_so(browser, served):
    if "plain" not in built_engines():
        pytest.skip("build/web/site has no engine without SIMD: scripts/web makes it")
    lacks = "WebAssembly.validate = () => false;"
    page = without(browser, f"{served.url}#scene=arena&eye=melophorus", lacks)
    page.wait_for_selector("body[data-ready=plain]")
    assert "no WebAssembly SIMD" in page.inner_text("#said")
    page.context.close()


def test_without_isolation_there_is_one_thread(browser, served):
    lacks = "Object.defineProperty(globalThis, 'crossOriginIsolated', { value: false });"
    page = without(browser, f"{served.url}#scene=arena&eye=melophorus", lacks)
    page.wait_for_selector("body[data-ready=simd]")
    assert ("One thread" in page.inner_text("#said")) == ("threads" in built_engines())
    page.context.close()


def test_where_threads_do_not_start_there_is_one(browser, served):
    page = browser.open("about:blank", wait=False)
    page.route("**/omma_threads.js", lambda route: route.abort())
    page.goto(f"{served.url}#scene=arena&eye=melophorus")
    page.wait_for_selector("body[data-ready=simd]")
    assert ("did not start" in page.inner_text("#said")) == ("threads" in built_engines())
    page.context.close()


def test_without_webgl_the_eye_sees_as_ever(browser, served):
    lacks = """const old = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith('webgl') ? null : old.call(this, kind, ...more);
};"""
    page = without(browser, f"{served.url}#scene=arena&eye=melophorus", lacks)
    page.wait_for_selector("body[data-ready]")
    assert "no WebGL" in page.inner_text("#scene-note")
    assert seen(page)[0].max() > 0.1
    page.context.close()


def test_without_webassembly_it_says_that_it_cannot(browser, served):
    page = without(browser, served.url, "delete globalThis.WebAssembly;")
    until(lambda: "no WebAssembly" in page.inner_text("#trouble"))
    page.context.close()
