"""The thread that renders for the window: errors, turns, and what gets finer."""

import threading

import numpy as np
from view_checks import LEVEL, ROLLED, wait_for

import omma
from omma.view.live import Live
from omma.view.poses import HeadPose
from omma.view.state import Look


def test_an_error_does_not_end_the_work(looker):
    frames, errors = [], []
    live = Live(looker, Look(LEVEL), on_seen=frames.append, on_still=lambda _: None,
                on_error=errors.append)  # fmt: skip

    def broken():
        raise omma.Error("that cannot be done")

    live.refine(False)
    live.start()
    try:
        wait_for(lambda: frames)
        live.do(broken)
        wait_for(lambda: errors)
        live.want(Look(ROLLED))
        wait_for(lambda: frames[-1].look == Look(ROLLED))
    finally:
        live.close()
    assert str(errors[0]) == "that cannot be done"
    assert not any(one.name == "omma-view-render" for one in threading.enumerate())


def test_what_is_done_piece_by_piece_does_not_stop_frames(looker):
    frames, steps = [], []
    live = Live(looker, Look(LEVEL), on_seen=frames.append, on_still=lambda _: None,
                on_error=print)  # fmt: skip

    def step():
        steps.append(len(frames))
        live.want(Look(HeadPose((0, 1, len(steps) / 10))))
        return len(steps) < 20

    live.refine(False)
    live.start()
    try:
        wait_for(lambda: frames)
        live.do(step)
        wait_for(lambda: len(steps) == 20)
    finally:
        live.close()
    # A frame between each two steps.
    assert np.array_equal(np.diff(steps), np.ones(19))


def test_what_holds_still_gets_finer(looker):
    frames = []
    live = Live(looker, Look(LEVEL, samples=16), on_seen=frames.append, on_still=lambda _: None,
                on_error=print)  # fmt: skip
    live.start()
    try:
        wait_for(lambda: frames and frames[-1].samples == 64)
    finally:
        live.close()
    assert [(one.samples, one.standard_error) for one in frames] == [
        (16, False), (16, True), (32, True), (64, True),
    ]  # fmt: skip
