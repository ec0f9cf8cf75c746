"""Events: brightening and darkening told apart, each told when it has reached a threshold, as event
cameras do, and coarsely what the ON and OFF pathways behind a fly's photoreceptors do.

The model is the dynamic vision sensor's (Lichtsteiner, Posch and Delbruck 2008, IEEE J Solid-State
Circuits 43:566): each receptor keeps the logarithm of light at its last event, and has the next one
when the logarithm has gone on by a threshold, up (ON) or down (OFF); after an event it is held in
reset for a refractory time, and what it keeps is then the logarithm at the end of that. Between
frames the logarithm is a straight line, by which events have their times (ESIM: Rebecq, Gehrig and
Scaramuzza 2018, Proc Mach Learn Res 87:969, eq. 3). In flies L1 leads to cells that answer to
brightening, L2 to cells that answer to darkening (Joesch et al. 2010, Nature 468:300).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omma import _core
from omma._core import Error, Eye
from omma.base.arguments import array_of, checked, one_of, within
from omma.base.arrays import Floats, Ints
from omma.base.directions import azimuth_elevation_deg_of
from omma.base.optional import needs
from omma.base.slips import warn_of_slip
from omma.base.values import in_full, value_class
from omma.photoreceptors.adaptation import light_of

if TYPE_CHECKING:
    import xarray


# One event: when, s; which; +1 for brightening (ON), -1 for darkening (OFF).
EVENT = np.dtype([("time_s", "f8"), ("ommatidium", "i4"), ("receptor", "i4"), ("polarity", "i1")])

# More events between two frames than that are a threshold in another unit.
_MOST_EVENTS = 1 << 28
# Beyond that, numbers and times are in no unit, and their differences would overflow.
_LARGEST, _LARGEST_S = 1e100, 1e15


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class EventState:
    """What receptors remember from frame to frame, of each (N,) or (N, R).

    time_s: when the last frame was; signal: the logarithm of its light; reference: that of the last
    event, or of the end of the reset after it; ready_s: when that reset ends, -inf before the first
    event. unit: (signal, dark) of the sensor whose it is, by which numbers are what they are; None:
    of any, nothing is compared.
    """

    time_s: float
    signal: Floats
    reference: Floats
    ready_s: Floats
    unit: tuple[str, float] | None = None


@value_class
@dataclass(frozen=True, eq=False, repr=False)
class EventSensor:
    """Receptors that answer with ON and OFF events to responses over time.

    Attributes:
        on_threshold: by how much the signal grows from event to event: a number for all, or of the
            shape of a frame, as thresholds of real sensors differ. In units of the natural
            logarithm; 0.2 is a contrast of 22 %.
        off_threshold: by how much it falls; None: ``on_threshold``.
        refractory_s: how long a receptor is held in reset after an event, s. 0: not at all, and the
            reference is then exactly a threshold further with each event.
        signal: "log": the natural logarithm of ``responses + dark``; "linear": the responses
            themselves, as of potentials that have adapted already. They may then be negative.
        dark: added to light before the logarithm, in its unit: what a receptor tells in darkness.

    Example:
        >>> sensor = omma.photoreceptors.EventSensor(0.5)
        >>> light = np.exp([[0.0], [1.0], [0.0]])  # up by two thresholds, and down again
        >>> events = sensor.run(light, [0.0, 1.0, 2.0])
        >>> events["time_s"].tolist(), events["polarity"].tolist()
        ([0.5, 1.0, 1.5, 2.0], [1, 1, -1, -1])

    Raises:
        omma.Error: thresholds that are not above 0, a refractory time or ``dark`` that is negative
            or not finite.

    Warns:
        UserWarning: a refractory time above 1 s.
    """

    on_threshold: float | Floats = 0.2
    off_threshold: float | Floats | None = None
    refractory_s: float = 0.0
    signal: Literal["log", "linear"] = "log"
    dark: float = 0.0

    __repr__ = in_full

    def __post_init__(self) -> None:
        for name in ("on_threshold", "off_threshold"):
            value = getattr(self, name)
            if value is None:
                continue
            given = array_of(value, name)
            if given.ndim > 2 or given.size == 0:
                raise Error(f"{name}: expected a number, (N,) or (N, R), found shape {given.shape}")
            bad = given[~(np.isfinite(given) & (given > 0))]
            if len(bad):
                raise Error(f"{name}: expected numbers above 0, found {bad[0]:g}")
            object.__setattr__(self, name, float(given) if given.ndim == 0 else given)
        for name in ("refractory_s", "dark"):
            object.__setattr__(self, name, within(getattr(self, name), name, 0, _LARGEST))
        one_of(self.signal, ("log", "linear"), "signal")
        warn_of_slip("refractory time", self.refractory_s, "refractory_s")

    @checked
    def step(
        self, state: EventState | None, frame: ArrayLike, time_s: float
    ) -> tuple[EventState, NDArray[Any]]:
        """The events since the frame before.

        Args:
            state: what the last call returned, of a sensor with the same ``signal`` and ``dark``;
                None at the first frame, which has no events and is what the next are compared with.
            frame: responses (N,) or (N, R), of ommatidia and bands or receptors.
            time_s: when it is, s; after the frame before.

        Returns:
            (state, events): events in the order of time, those of one time by ommatidium and
            receptor, of dtype `EVENT`: ``time_s``, s, ``ommatidium``, ``receptor`` (0 where a frame
            is (N,)), ``polarity``, +1 for ON and -1 for OFF.

        Raises:
            omma.Error: a wrong shape, numbers that are not finite, a time that is not after the one
                before; for "log" responses that are negative, or 0 where ``dark`` is 0; the state
                of a sensor with another ``signal`` or ``dark``.
        """
        if state is not None and state.unit is not None and tuple(state.unit) != self._unit:
            raise Error(
                "state: expected that of a sensor with signal {!r}, dark {:g}, found that of one "
                "with signal {!r}, dark {:g}".format(*self._unit, *state.unit)
            )
        now = self._signal_of(frame, "frame")
        array_of(now, "frame", [("N",), ("N", "R")])
        at = _time(time_s, state)
        if state is None:
            for name in ("on_threshold", "off_threshold"):
                self._threshold(name, now.shape)
            none = np.empty(0, EVENT)
            never = np.full(now.shape, -np.inf)
            return EventState(at, now, now.copy(), never, self._unit), none
        if state.signal.shape != now.shape:
            raise Error(f"frame: expected shape {state.signal.shape} as before, found {now.shape}")
        return self._between(state, now, at)

    @checked
    def run(self, responses: ArrayLike, times_s: ArrayLike) -> NDArray[Any]:
        """The events of many frames, the same bits as frame by frame with `step`.

        Args:
            responses: (T, N) or (T, N, R): frames, ommatidia, bands or receptors.
            times_s: (T,), when each frame is, s, growing.

        Returns:
            (E,), as of `step`.

        Raises:
            omma.Error: a wrong shape, and what `step` raises.

        Warns:
            UserWarning: no frame within a second of another.
        """
        frames = array_of(responses, "responses", [("T", "N"), ("T", "N", "R")], dtype=None)
        times = array_of(times_s, "times_s", (len(frames),))
        found, state = [np.empty(0, EVENT)], None
        for frame, at in zip(frames, times):
            state, events = self.step(state, frame, float(at))
            found.append(events)
        if len(times) > 1:
            warn_of_slip("time between frames", float(np.diff(times).min()), "times_s")
        return np.concatenate(found)

    @checked
    def dataset(self, events: ArrayLike, eye: Eye | None = None) -> xarray.Dataset:
        """Events as an `xarray.Dataset`, which says what they are.

        The dimension is ``event``; the variable ``polarity``; coordinates ``time`` (s),
        ``ommatidium``, ``receptor``, and of an eye also ``azimuth``, ``elevation`` (degrees, in
        the head) and ``eye``. Attributes: Omma's version and what the sensor is.

        Args:
            events: (E,), of `step` or `run`.
            eye: whose ommatidia they are of; None: directions are left out.

        Raises:
            omma.Error: events that are none, an eye of fewer ommatidia; no xarray (``omma[data]``).
        """
        package = needs("xarray", "data", "datasets need xarray")
        given = _events(events)
        along = ("event",)
        coordinates: dict[str, Any] = {
            "time": (along, given["time_s"], {"units": "s"}),
            "ommatidium": (along, given["ommatidium"]),
            "receptor": (along, given["receptor"]),
        }
        if eye is not None:
            which = given["ommatidium"]
            if which.max(initial=-1) >= len(eye):
                raise Error(f"eye: expected at least {which.max() + 1} ommatidia, found {len(eye)}")
            azimuth, elevation = azimuth_elevation_deg_of(eye.axis[which])
            where = "in the head: 0 ahead, right positive"
            coordinates["azimuth"] = (along, azimuth, {"units": "degree", "long_name": where})
            about = {"units": "degree", "long_name": "up positive"}
            coordinates["elevation"] = (along, elevation, about)
            coordinates["eye"] = (along, eye.eye_id[which], {"long_name": "which eye of the head"})
        told = {"units": "1", "long_name": "+1 brightening (ON), -1 darkening (OFF)"}
        off = self.on_threshold if self.off_threshold is None else self.off_threshold
        about_all = {
            "omma_version": _core.__version__,
            "on_threshold": np.ravel(self.on_threshold),
            "off_threshold": np.ravel(off),
            "refractory_s": self.refractory_s,
            "signal": self.signal,
            "dark": self.dark,
        }
        variables = {"polarity": (along, given["polarity"], told)}
        made: xarray.Dataset = package.Dataset(variables, coordinates, about_all)
        return made

    @property
    def _unit(self) -> tuple[str, float]:
        return self.signal, self.dark

    def _signal_of(self, frame: ArrayLike, name: str) -> Floats:
        if self.signal == "linear":
            given = array_of(frame, name)
            if not (np.abs(given) <= _LARGEST).all():
                raise Error(f"{name}: expected finite numbers, at most {_LARGEST:g} in size")
            return np.array(given)  # the caller may render the next frame into the same array
        light = light_of(frame, name) + self.dark
        zero = np.argwhere(light <= 0)
        if len(zero):
            where = ", ".join(map(str, zero[0]))
            raise Error(
                f"{name}: expected numbers above 0 for their logarithm, found 0 at [{where}]; "
                "`dark` is added to them"
            )
        return np.asarray(np.log(light))

    def _threshold(self, name: str, shape: tuple[int, ...]) -> Floats:
        value = getattr(self, name)
        found = np.asarray(self.on_threshold if value is None else value)
        if found.shape not in ((), shape):
            raise Error(
                f"{name}: expected a number or the shape of a frame, {shape}, found {found.shape}"
            )
        return np.broadcast_to(found, shape).ravel()

    def _between(self, then: EventState, now: Floats, at: float) -> tuple[EventState, NDArray[Any]]:
        """Events of straight lines from one frame to the next; arrays inside are flat."""
        shape, lasts = now.shape, at - then.time_s
        before, ready = then.signal.ravel(), then.ready_s.ravel()
        rise = now.ravel() - before
        in_reset = ready >= at
        # Where a reset ends on the way the signal then is the reference.
        wakes = (ready >= then.time_s) & ~in_reset
        awake_s = np.where(wakes, ready, then.time_s)
        woken = before + rise * ((awake_s - then.time_s) / lasts)
        reference = np.where(wakes, woken, then.reference.ravel())
        sign = np.sign(rise)
        on, off = (self._threshold(name, shape) for name in ("on_threshold", "off_threshold"))
        threshold = np.where(rise > 0, on, off)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # How far it goes beyond the reference, and when it first is a threshold further.
            steps = sign * (now.ravel() - reference) / threshold
            first = then.time_s + lasts * ((reference + sign * threshold - before) / rise)
            first = np.clip(first, awake_s, at)
            period = self.refractory_s + lasts * (threshold / np.abs(rise))
            if self.refractory_s > 0:
                steps = np.where(steps >= 1, 1 + np.floor((at - first) / period), 0)
        number = np.where(in_reset, 0, np.maximum(np.floor(steps), 0))
        total = float(np.sum(number))
        if not total <= _MOST_EVENTS:
            raise Error(
                f"on_threshold, off_threshold: expected at most {_MOST_EVENTS:,} events between "
                f"two frames, found {total:g}; are thresholds in the signal's unit?"
            )
        counts = number.astype(np.int64)
        events = _listed(counts, first, period, sign, at, shape)
        has = counts > 0
        if self.refractory_s > 0:
            last = np.minimum(first + (counts - 1) * np.where(has, period, 0.0), at)
            ready = np.where(has, last + self.refractory_s, ready)
            # Resets that end before the frame; those after it, where the signal will be by then.
            met = before + rise * ((np.clip(ready, then.time_s, at) - then.time_s) / lasts)
            reference = np.where(has, met, reference)
        else:
            reference = reference + sign * number * threshold
        after = reference.reshape(shape), ready.reshape(shape)
        return EventState(at, now, *after, self._unit), events


@checked
def event_counts(events: ArrayLike, edges_s: ArrayLike, shape: tuple[int, ...]) -> Ints:
    """How many events there are between times, as models take them that want frames.

    Args:
        events: (E,), of `EventSensor`.
        edges_s: (T + 1,), growing, s: an event counts where it is after one edge and not after the
            next, as those of `EventSensor.step` are after one frame and not after the next.
        shape: of a frame, (N,) or (N, R).

    Returns:
        (T, ..., 2): intervals, the shape of a frame, then ON and OFF.

    Raises:
        omma.Error: edges that do not grow, events of ommatidia or receptors beyond the shape.
    """
    given = _events(events)
    edges = array_of(edges_s, "edges_s", (None,))
    if len(edges) < 2 or not (np.isfinite(edges).all() and (np.diff(edges) > 0).all()):
        raise Error("edges_s: expected two or more finite times that grow")
    sizes = array_of(shape, "shape", dtype=np.int64)
    fits = sizes.shape in ((1,), (2,)) and (sizes > 0).all()
    if not fits or np.prod(sizes.astype(float)) > 2**40:
        raise Error(f"shape: expected (N,) or (N, R), found {shape!r:.40}")
    whole = (int(sizes[0]), int(sizes[1]) if len(sizes) == 2 else 1)
    for name, size in zip(("ommatidium", "receptor"), whole):
        largest = given[name].max(initial=-1)
        if largest >= size or given[name].min(initial=0) < 0:
            raise Error(f"shape: expected {name} 0 to {size - 1} in events, found {largest}")
    when = np.searchsorted(edges, given["time_s"], side="left") - 1
    inside = (when >= 0) & (when < len(edges) - 1)
    kept = given[inside]
    found = np.zeros((len(edges) - 1, *whole, 2), np.int64)
    off = (kept["polarity"] < 0).astype(np.int64)
    np.add.at(found, (when[inside], kept["ommatidium"], kept["receptor"], off), 1)
    return found.reshape(len(edges) - 1, *sizes.tolist(), 2)


def _listed(
    counts: Ints, first: Floats, period: Floats, sign: Floats, at: float, shape: tuple[int, ...]
) -> NDArray[Any]:
    """The events of receptors that have so many, in the order of time."""
    which = np.repeat(np.arange(len(counts)), counts)
    later = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    times = first[which]
    again = later > 0
    times[again] += later[again] * period[which[again]]
    times = np.minimum(times, at)
    order = np.lexsort((which, times))
    events = np.empty(len(which), EVENT)
    receptors = shape[1] if len(shape) == 2 else 1
    which = which[order]
    events["time_s"], events["polarity"] = times[order], sign[which]
    events["ommatidium"], events["receptor"] = np.divmod(which, receptors)
    return events


def _time(time_s: float, state: EventState | None) -> float:
    at = within(time_s, "time_s", -_LARGEST_S, _LARGEST_S)
    if state is not None and not at > state.time_s:
        raise Error(f"time_s: expected a time after {state.time_s:g} s, found {at:g} s")
    return at


def _events(value: ArrayLike) -> NDArray[Any]:
    try:
        given = np.asarray(value)
    except ValueError:
        raise Error("events: expected events, found rows of different lengths") from None
    if given.dtype != EVENT or given.ndim != 1:
        raise Error(
            f"events: expected an array (E,) of omma.photoreceptors.EVENT, found {given.dtype} "
            f"{given.shape}"
        )
    return given
