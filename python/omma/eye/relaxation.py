"""Points spread over a surface until they make a lattice: what lies under the eyes made to order.

A lattice is grown from a coarse one. Some hundred points are spread in proportion to the density
wanted and annealed: they repel each other and are shaken ever less. Then points are put on the
middle of every edge between neighbours, which gives four times as many, each new one with six
neighbours, and the forces even out what is uneven; and again, until there are enough. A lattice
relaxed from as many points at once freezes into grains with rows of defects between them; this one
has the few defects of the coarse lattice.

The force between two points a metric distance r apart is r^-7, in units of the spacing. In a
hexagonal lattice such forces make a pressure that is a function of r alone, so pressures balance
where r is the same everywhere, and the spacing follows the metric.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from omma._core import Error
from omma.base.arguments import whole
from omma.base.arrays import Flags, Floats
from omma.base.directions import normalized
from omma.base.progress import Progress, Stage, ends_of_steps
from omma.eye.cells import NEIGHBOURS, Pairs, cells, nearest
from omma.eye.nearest import Nearest

_FORCE_POWER = 7
# Step size as a fraction of the largest stable one, found by trials with 100 to 10,000 points.
_STEP_SIZE = 0.0107
_MOMENTUM = 0.8
_LONGEST_STEP = 0.15  # spacings
_COARSEST = 150  # points, or up to four times as many
_COARSE_STEPS = 400
_COARSE_SHAKE = 0.15
_TRIALS = 3
_STEPS = 150
_SHAKE = 0.04
MARGIN = 2.5  # spacings laid beyond where points are wanted, where the lattice meets a wall
_HALF_ROW = 0.43
_WIDENING = 1.0045  # of the spacing with every doubling, as the cut rows at the wall leave room
STEPS_PER_SEARCH = 10


def started(
    count: int | None, seed: int, progress: Stage | None
) -> tuple[np.random.Generator, Stage]:
    """What makes an eye by chance begins with: random numbers, and who is told of progress.

    Raises:
        omma.Error: a number of ommatidia or a seed out of range.
    """
    if count is not None and whole(count, "count", 1, 200_000) == 1:
        raise Error(
            "count: expected 2 or more, found 1; a single ommatidium is "
            "omma.Eye([(0, 0, 0)], [(0, 0, -1)], acceptance_angle_rad)"
        )
    random = np.random.default_rng(whole(seed, "seed", 0, 2**63 - 1))
    tell = progress or (lambda stage, fraction: None)
    tell("placing ommatidia", None)
    return random, tell


@dataclass(frozen=True)
class Domain:
    """Where points are laid and how far apart.

    ``onto`` moves points (K, 3) near the surface onto it. ``metric`` gives (K, 2, 3): two vectors
    along the surface at right angles, whose products with a step are its lengths along them in
    units of the spacing wanted. ``outside``, of points and the metric there, or None where that is
    not known yet, is the metric distance (K,) outside of where points are wanted, 0 within; it is
    None where they are wanted all over a closed surface. ``samples`` (S, 3) cover the surface, at
    least as far as points may go, each for its ``fraction`` (S,) of the number of points wanted.
    """

    onto: Callable[[Floats], Floats]
    metric: Callable[[Floats], Floats]
    outside: Callable[[Floats, Floats | None], Floats] | None
    samples: Floats
    fraction: Floats


def _filled(domain: Domain, points: Floats, count: int) -> Floats:
    # With the middles of the longest edges, not two at one position.
    net = cells(points, domain.metric(points))
    length = np.where(net.is_neighbour, net.distance, 0)
    free = np.ones(len(points), bool)
    added = [points]
    for point in np.argsort(-length.max(axis=1)):
        if len(points) + len(added) - 1 == count:
            break
        if free[net.near[point]].all():
            free[point] = False
            other = net.near[point, np.argmax(length[point])]
            added.append(0.5 * (points[[point]] + points[[other]]))
    return domain.onto(np.concatenate(added))


class Region:
    """Where on a surface points are wanted, known by samples (S, 3) of the surface of which
    ``sees`` (a function of points (K, 3) to (K,)) says which are in it; distances are measured by
    a ``metric`` as in `Domain`. ``nearest_inside`` knows those of the samples where it is seen."""

    def __init__(
        self,
        sees: Callable[[Floats], Flags],
        metric: Callable[[Floats], Floats],
        samples: Floats,
        inside: Flags,
        nearest_inside: Nearest | None = None,
    ) -> None:
        self._sees, self._metric = sees, metric
        self._inside = nearest_inside or Nearest(samples[inside])
        self._hidden = Nearest(samples[~inside])

    def outside(self, points: Floats, metric: Floats | None = None) -> Floats:
        """Metric distance (K,) outside of it, 0 in it; ``metric`` is that at the points, where it
        is known already."""
        distance = np.zeros(len(points))
        hidden = np.flatnonzero(~self._sees(points))
        if len(hidden):
            near = self._inside.points[self._inside(points[hidden])]
            known = None if metric is None else metric[hidden]
            distance[hidden] = self._length(points[hidden], near, known)
        return distance

    def deepest(self, points: Floats, count: int) -> Floats:
        """The ``count`` points deepest inside; what is outside of those is moved in."""
        depth = -self.outside(points)
        inner = np.flatnonzero(depth == 0)
        if len(inner) and len(self._hidden.points):
            near = self._hidden.points[self._hidden(points[inner])]
            depth[inner] = self._length(points[inner], near)
        chosen = np.sort(np.argsort(-depth, kind="stable")[:count])
        points, moved = points[chosen], np.flatnonzero(depth[chosen] < 0)
        if len(moved):
            points[moved] = self._inside.points[self._inside(points[moved])]
        return points

    def _length(self, start: Floats, end: Floats, metric: Floats | None = None) -> Floats:
        metric = self._metric(start) if metric is None else metric
        step = np.einsum("nac,nc->na", metric, end - start)
        return np.asarray(np.linalg.norm(step, axis=1))


def grown(domain: Domain, count: int, random: np.random.Generator, tell: Progress) -> Floats:
    """A lattice of ``count`` points (N, 3) on a closed surface; elsewhere about as many where they
    are wanted, and more around them."""
    doublings = max(0, math.floor(math.log(count / _COARSEST, 4)))
    coarse = _COARSE_STEPS * (1 if domain.outside is None else _TRIALS) / 4**doublings
    levels = [_STEPS / 4.0**further for further in reversed(range(doublings))]
    # The last are after the number has been made the one that is wanted, as on closed surfaces.
    last = [_STEPS] if domain.outside is None else []
    done = ends_of_steps([coarse, *levels, *last])

    def stage(level: int) -> Progress:
        start, length = done[level], done[level + 1] - done[level]
        return lambda fraction: tell(start + fraction * length)

    points = _coarse(domain, count, 2.0**doublings, random, stage(0))
    for level in range(1, doublings + 1):
        scale = 2.0 ** (doublings - level)
        points = _refined(domain, points, scale)
        if domain.outside is not None:
            points = points[domain.outside(points, None) <= (MARGIN + _HALF_ROW) * scale]
        points = _relaxed(domain, points, scale, _STEPS, _SHAKE, random, stage(level))
    if len(points) < count or (domain.outside is None and len(points) > count):
        change = _thinned if len(points) > count else _filled
        points = change(domain, points, count)
        told = stage(doublings + 1) if last else lambda fraction: None
        points = _relaxed(domain, points, 1.0, _STEPS, 0.0, random, told)
    tell(1.0)
    return points


def _coarse(
    domain: Domain,
    count: int,
    scale: float,
    random: np.random.Generator,
    tell: Progress,
) -> Floats:
    # The points that make the lattice `scale` times as wide as wanted at the end.
    fraction = domain.fraction / scale**2
    if domain.outside is None:
        # A closed net of V points has 3V - 6 edges, hence 4V - 6 points the next time.
        number = math.ceil((count - 2) / scale**2) + 2 if scale > 1 else count
        seeds = bisected(domain.samples, fraction, number)
        return _relaxed(domain, seeds, scale, _COARSE_STEPS, _COARSE_SHAKE, random, tell)
    within = domain.outside(domain.samples, None) <= MARGIN * scale
    total = float(fraction[within].sum())
    # Points on the wall have half of their cells outside; around a disc these are so many.
    number = max(2, round(total + 1.9 * math.sqrt(total)))
    target = _WIDENING ** -math.log2(scale)
    best: tuple[float, Floats] | None = None
    for trial in range(_TRIALS):
        told = _share_of_trial(tell, trial)
        number = min(number, int(within.sum()))
        seeds = bisected(domain.samples[within], fraction[within], number)
        points = _relaxed(domain, seeds, scale, _COARSE_STEPS, _COARSE_SHAKE, random, told)
        spacing = _spacing(domain, _refined(domain, points, scale / 2), scale / 2)
        error = abs(spacing / target - 1)
        if best is None or error < best[0]:
            best = error, points
        following = max(2, round(number * (spacing / target) ** 2))
        if error < 0.002 or following == number:
            break
        number = following
    assert best is not None
    return best[1]


def _share_of_trial(tell: Progress, trial: int) -> Progress:
    return lambda fraction: tell((trial + fraction) / _TRIALS)


def _spacing(domain: Domain, points: Floats, scale: float) -> float:
    # Median metric distance of neighbours where they are wanted.
    net = cells(points, domain.metric(points) / scale)
    assert domain.outside is not None
    distance = net.distance[(domain.outside(points, None) == 0)[:, None] & net.is_neighbour]
    return float(np.median(distance)) if len(distance) else 1.0


def _refined(domain: Domain, points: Floats, scale: float) -> Floats:
    # Points and the middles of edges: a lattice half as wide, of spacing ``scale``.
    pairs = cells(points, domain.metric(points) / (2 * scale)).edges()
    middles = 0.5 * (points[pairs[:, 0]] + points[pairs[:, 1]])
    return np.concatenate([points, domain.onto(middles)])


def _thinned(domain: Domain, points: Floats, count: int) -> Floats:
    # Without those that are closest to their neighbours, not two from one position.
    net = cells(points, domain.metric(points))
    crowded = np.argsort(np.where(net.is_neighbour, net.distance, 0).sum(axis=1) / net.degree)
    keep = np.ones(len(points), bool)
    for point in crowded:
        if keep.sum() == count:
            break
        keep[point] = keep[net.near[point]].all()
    for point in crowded:
        if keep.sum() == count:
            break
        keep[point] = False
    return points[keep]


def bisected(points: Floats, fraction: Floats, count: int) -> Floats:
    """``count`` of many points (K, 3), each standing for the same sum of ``fraction`` (K,).

    The set is halved again and again across its longest side into subsets of as many to come each;
    neighbours in the result are neighbours in space.
    """
    seeds = np.empty((count, 3))
    subsets = [(np.arange(len(fraction)), 0, count)]
    while subsets:
        members, first, size = subsets.pop()
        inside, weight = points[members], fraction[members]
        if size == 1:
            # One of the points, as the middle itself may lie where there are to be none.
            middle = np.average(inside, axis=0, weights=weight)
            seeds[first] = inside[np.argmin(np.sum((inside - middle) ** 2, axis=1))]
            continue
        longest = int(np.argmax(np.ptp(inside, axis=0)))
        order = np.argsort(inside[:, longest], kind="stable")
        members, summed = members[order], np.cumsum(weight[order])
        half = size // 2
        cut = int(np.searchsorted(summed, summed[-1] * half / size))
        cut = min(max(cut, half), len(members) - (size - half))
        subsets.append((members[:cut], first, half))
        subsets.append((members[cut:], first + half, size - half))
    return seeds


def repulsion(squared: Floats) -> tuple[Floats, Floats]:
    """Squared distances in units of the spacing, as they count, and what the steps apart are
    multiplied by to be forces."""
    # Not closer than half, so that two points on top of each other do not fly off.
    squared = np.maximum(squared, 0.25)
    return squared, squared ** (-(_FORCE_POWER + 1) / 2)


def pushed(velocity: Floats, force: Floats, normal: Floats) -> Floats:
    """Velocities (N, 3) per step after a step under forces (N, 3), along a surface of normals
    (N, 3)."""
    velocity = _MOMENTUM * velocity + _STEP_SIZE * force
    velocity -= np.sum(velocity * normal, axis=1, keepdims=True) * normal
    return velocity


def limited(velocity: Floats, speed: Floats, spacing: Floats | float = 1.0) -> Floats:
    """Velocities (N, 3) of lengths ``speed`` (N,), made no longer than some of the spacing."""
    most = _LONGEST_STEP * spacing / np.maximum(speed, 1e-300)
    return np.asarray(velocity * np.minimum(1, most)[:, None])


def _relaxed(
    domain: Domain,
    points: Floats,
    scale: float,
    steps: int,
    shake: float,
    random: np.random.Generator,
    tell: Progress,
) -> Floats:
    # Points (N, 3) after so many steps of repulsion at `scale` times the spacing. `shake` is the
    # size of a random step at the start, in spacings; it falls to 0 over two thirds of the steps.
    velocity = np.zeros_like(points)
    here = domain.metric(points)
    metric = here / scale
    for step in range(steps):
        if step % STEPS_PER_SEARCH == 0:
            pairs = Pairs(nearest(points, metric, NEIGHBOURS))
            bend = _bend(points, domain, metric)
            tell(step / steps)
        apart = points[:, None, :] - points.take(pairs.near, axis=0)
        squared, strength = repulsion(pairs.distance_squared(apart, metric))
        force = np.einsum("nkc,nk->nc", apart, strength)
        if bend is not None:
            force += 0.25 * np.sum(squared * strength, axis=1, keepdims=True) * bend
        velocity = pushed(velocity, force, _normals(metric))
        speed = np.linalg.norm(np.einsum("nac,nc->na", metric, velocity), axis=1)
        velocity = limited(velocity, speed)
        move = velocity
        amount = shake * (1 - 1.5 * step / steps)
        if amount > 0:
            # Along the metric's two directions, whose lengths are one over the spacing.
            stretch = metric / np.sum(metric**2, axis=2, keepdims=True)
            jump = amount * random.standard_normal((len(points), 2))
            move = velocity + np.einsum("nac,na->nc", stretch, jump)
        moved = domain.onto(points + move)
        there = domain.metric(moved)
        if domain.outside is not None:
            stays = domain.outside(moved, there) > MARGIN * scale
            moved[stays], there[stays], velocity[stays] = points[stays], here[stays], 0
        points, here = moved, there
        metric = here / scale
    return points


def _bend(points: Floats, domain: Domain, metric: Floats) -> Floats | None:
    """How much the six neighbours of an even lattice are out of balance, as steps in space are not
    straight in the metric: with steps d + Γ(d, d)/2 they would balance, and over six neighbours the
    Christoffel symbols Γ add up to -1/√g ∂_a(√g g^ak), (N, 3). None, for 0, where the metric is the
    same in all directions."""
    size = np.linalg.norm(metric, axis=2)
    if np.allclose(size[:, 0], size[:, 1], rtol=1e-9):
        return None
    divergence = np.zeros_like(points)
    for along in range(2):
        step = 0.5 * metric[:, along] / size[:, along, None] ** 2
        ahead, behind = (_root_metric(domain, domain.onto(points + s * step)) for s in (1, -1))
        per_length = step / (2 * np.sum(step**2, axis=1, keepdims=True))
        divergence += np.einsum("nij,nj->ni", ahead - behind, per_length)
    normal = _normals(metric)
    divergence -= np.sum(divergence * normal, axis=1, keepdims=True) * normal
    return np.asarray(divergence / np.prod(size, axis=1)[:, None])


def _normals(metric: Floats) -> Floats:
    across = np.cross(metric[:, 0], metric[:, 1])
    return normalized(across)


def _root_metric(domain: Domain, points: Floats) -> Floats:
    # √g g^-1 of a metric of two directions at right angles; no scale changes it. (N, 3, 3)
    metric = domain.metric(points)
    size = np.linalg.norm(metric, axis=2)
    ratio = size[:, 1] / size[:, 0]
    direction = metric / size[:, :, None]
    weight = np.stack([ratio, 1 / ratio], axis=1)
    return np.asarray(np.einsum("na,nai,naj->nij", weight, direction, direction))
