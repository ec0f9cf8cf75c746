"""Renderers and several threads: who frees what while it is in use, and callbacks that render."""

import gc
import threading

import pytest
from conftest import make_eye

import omma


@pytest.fixture(scope="module")
def busy(scene):
    return omma.Renderer(scene, make_eye(500), omma.Fixed(512), threads=2)


@pytest.mark.parametrize("sampling", [omma.Fixed(64), omma.Shared(16)])
def test_a_renderer_freed_while_another_thread_renders(scene, flight, sampling):
    eye = make_eye(500, acceptance_deg=10)

    def made():
        return omma.Renderer(scene, eye, sampling, threads=2)

    expected = made().render(flight, standard_error=True)

    def render(renderers, begun, freed, results):
        def told(fraction):
            # It goes on while it is freed, and ends after that.
            if begun.is_set():
                freed.wait()
            begun.set()

        results.extend(renderers[0].render(flight, standard_error=True, progress=told))

    for _ in range(4):
        renderers, begun, freed, results = [made()], threading.Event(), threading.Event(), []
        thread = threading.Thread(target=render, args=(renderers, begun, freed, results))
        thread.start()
        begun.wait()
        renderers.clear()
        gc.collect()
        freed.set()
        thread.join()
        assert all((a == b).all() for a, b in zip(results, expected, strict=True))


def test_a_callback_that_renders(busy, flight):
    expected = busy.render(flight)
    inner = []

    def told(fraction):
        def deeper(fraction):
            inner.append(busy.with_eye(busy.eye).render(flight[:1]))

        if len(inner) < 2:
            inner.append(busy.render(flight, progress=deeper))

    assert (busy.render(flight, progress=told) == expected).all()
    for responses in inner:
        assert (responses == expected[: len(responses)]).all()
    assert {len(responses) for responses in inner} == {1, len(flight)}


def test_a_callback_that_renders_while_rays_to_be_shared_are_made(scene, flight):
    eye = make_eye(1000, acceptance_deg=20)
    renderer = omma.Renderer(scene, eye, omma.Shared(16), threads=2)
    inner = []

    def told(fraction):
        # Nothing is finished while they are made, which takes many times as long as it is told.
        if not inner and fraction == 0:
            inner.append(renderer.render(flight, standard_error=True))

    outer = renderer.render(flight, standard_error=True, progress=told)
    assert inner
    assert all((a == b).all() for a, b in zip(inner[0], outer, strict=True))


def test_a_callback_that_builds_and_raises(scene, busy, flight):
    def told(fraction):
        omma.Renderer(scene, make_eye(10), progress=stop)

    def stop(fraction):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        busy.render(flight, progress=told)
    for response, whole in zip(busy.render_iter(flight), busy.render(flight), strict=True):
        assert (response == whole).all()


def test_several_threads_ask_for_the_same_shared_rays(scene, flight):
    eye = make_eye(500, acceptance_deg=20)
    expected = omma.Renderer(scene, eye, omma.Shared()).render(flight, standard_error=True)
    renderer = omma.Renderer(scene, eye, omma.Shared())
    results = [None] * 6

    def work(i):
        results[i] = renderer.render(flight, standard_error=True)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        assert all((a == b).all() for a, b in zip(result, expected, strict=True))
