"""The clear sky once more, slowly and simply, for tests: backward Monte Carlo in a round air.

Nothing is shared with what makes the tables: one wavelength and one sun, air as the layers of the
US Standard Atmosphere 1976 have it, ozone as a bell round 22 km, distances by Woodcock's tracking,
the way to the sun by quadrature, Rayleigh's matrix as a formula, vectors without tables.
"""

import numpy as np

EARTH_M = 6.371e6
TOP_M = 1e5
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def air_share(altitude_m):
    """Air density over that at sea level: US Standard Atmosphere 1976 to 47 km, then 7.2 km."""
    base = np.array([0, 11e3, 20e3, 32e3, 47e3])
    lapse = np.array([-6.5e-3, 0, 1e-3, 2.8e-3])
    warm = 288.15 + np.concatenate([[0], np.cumsum(lapse * np.diff(base))])
    pressure = [1.0]
    for low, high, slope, kelvin in zip(base, base[1:], lapse, warm):
        if slope:
            ratio = (1 + slope * (high - low) / kelvin) ** (-0.0341632 / slope)
        else:
            ratio = np.exp(-0.0341632 * (high - low) / kelvin)
        pressure.append(pressure[-1] * ratio)
    h = np.asarray(altitude_m) * EARTH_M / (EARTH_M + np.asarray(altitude_m))  # geopotential
    layer = np.clip(np.searchsorted(base, h, side="right") - 1, 0, 3)
    kelvin = warm[layer] + lapse[layer] * (np.minimum(h, base[4]) - base[layer])
    slope = np.where(lapse[layer] == 0, 1.0, lapse[layer])
    inside = np.where(
        lapse[layer] == 0,
        np.exp(-0.0341632 * (h - base[layer]) / warm[layer]),
        np.abs(kelvin / warm[layer]) ** (-0.0341632 / slope),
    )
    share = np.array(pressure)[layer] * inside * 288.15 / kelvin
    return share * np.exp(-np.maximum(h - base[4], 0) / 7.2e3)


def ozone_share(altitude_m):
    return np.exp(-0.5 * ((np.asarray(altitude_m) - 22e3) / 5.5e3) ** 2)


class RoundSky:
    """An atmosphere of these vertical optical depths, of air above the sea and of ozone above the
    ground, which lies so high."""

    def __init__(self, rayleigh_depth, ozone_depth, anisotropy, ground_m=0.0):
        height = np.linspace(0, TOP_M, 20_001)
        self.height = height[::20]  # looked up linearly between
        self.delta = anisotropy
        air, ozone = air_share(height + ground_m), ozone_share(height + ground_m)
        above_sea = np.trapezoid(air_share(height), height)
        self.scattering = (air * rayleigh_depth / above_sea)[::20]
        self.absorption = (ozone * ozone_depth / np.trapezoid(ozone, height))[::20]

    def radiance(self, sun_deg, elevation_deg, azimuth_deg, paths, rng):
        """I, Q, U over irradiance 1 of the sun, and standard errors; azimuth is right of the sun's.

        Q and U: from the vertical, turning to the right as one looks up the ray.
        """
        e, a, s = np.radians([elevation_deg, azimuth_deg, sun_deg])
        way = np.array([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)])
        sun = np.array([0.0, np.sin(s), -np.cos(s)])
        up = np.array([0.0, 1.0, 0.0])
        axis = up - (up @ way) * way
        at = np.tile([0.0, EARTH_M + 0.01, 0.0], (paths, 1))
        way = np.tile(way, (paths, 1))
        axis = np.tile(axis / np.linalg.norm(axis), (paths, 1))
        mueller = np.tile(np.eye(3), (paths, 1, 1))
        total = np.zeros((paths, 3))
        index = np.arange(paths)
        for order in range(60):
            at, gone, passed = self._fly(at, way, first=order == 0, rng=rng)
            weight = np.exp(-passed)
            kept = ~gone
            at, way, axis, index = at[kept], way[kept], axis[kept], index[kept]
            mueller = mueller[kept] * weight[kept][:, None, None]
            if not len(at):
                break
            light = self._to_sun(at, sun) / (4 * np.pi)
            total[index] += (
                light[:, None]
                * self._scatter(mueller, way, axis, np.broadcast_to(sun, way.shape))[0][:, :, 0]
            )
            next_way = self._any_direction(len(at), rng)
            mueller, axis = self._scatter(mueller, way, axis, next_way)
            way = next_way
        total *= self.first
        mean = total.mean(axis=0)
        return mean, total.std(axis=0, ddof=1) / np.sqrt(paths)

    def _at(self, table, points):
        return np.interp(np.linalg.norm(points, axis=-1) - EARTH_M, self.height, table)

    def _fly(self, at, way, first, rng):
        """To the next scattering by Woodcock's tracking; the first is forced into the air.

        Where it is, whether it has left or met the ground, and the ozone's depth on the way.
        """
        if first:
            return self._first(at, way, rng)
        at = at.copy()
        start = at.copy()
        most = self.scattering[0]
        flying, gone = np.ones(len(at), bool), np.zeros(len(at), bool)
        while flying.any():
            i = np.flatnonzero(flying)
            step = -np.log(1 - rng.random(len(i))) / most
            far = np.einsum("ij,ij->i", at[i], way[i])
            nearest = np.linalg.norm(at[i] - far[:, None] * way[i], axis=1)
            below = (far < 0) & (far + step > 0) & (nearest < EARTH_M)
            at[i] += step[:, None] * way[i]
            height = np.linalg.norm(at[i], axis=1) - EARTH_M
            out = below | (height < 0) | (height > TOP_M)
            stops = rng.random(len(i)) * most < self._at(self.scattering, at[i])
            gone[i[out]] = True
            flying[i[out | stops]] = False
        return at, gone, self._depth(self.absorption, start, at)

    def _first(self, at, way, rng):
        """All paths look one way: the share that scatters and where, from its own distribution."""
        far = at[0] @ way[0]
        top = EARTH_M + TOP_M
        length = -far + np.sqrt(far**2 + top**2 - at[0] @ at[0])
        along = length * np.linspace(0, 1, 20_001) ** 2
        points = at[0] + along[:, None] * way[0]
        sigma = self._at(self.scattering, points)
        depth = np.concatenate([[0], np.cumsum(0.5 * (sigma[1:] + sigma[:-1]) * np.diff(along))])
        share = 1 - np.exp(-depth)
        self.first = share[-1]
        even = (np.arange(len(at)) + rng.random(len(at))) / len(at)  # a stratum for each path
        moved = at + np.interp(even * share[-1], share, along)[:, None] * way
        return moved, np.zeros(len(at), bool), self._depth(self.absorption, at, moved)

    def _depth(self, table, start, end):
        """Optical depth along straight lines, Gauss-Legendre."""
        line = end - start
        sums = sum(
            w * self._at(table, start + 0.5 * (x + 1) * line) for x, w in zip(NODES, WEIGHTS)
        )
        return 0.5 * sums * np.linalg.norm(line, axis=1)

    def _to_sun(self, at, sun):
        """The share of the sun's light that gets there."""
        far = at @ sun
        square = np.einsum("ij,ij->i", at, at)
        hidden = (far < 0) & (square - far**2 < EARTH_M**2)
        length = -far + np.sqrt(far**2 - square + (EARTH_M + TOP_M) ** 2)
        both = 0.0
        # In two parts, at the place nearest to the earth, where the air is densest.
        middle = np.clip(-far, 0, length)
        for low, high in ((np.zeros_like(far), middle), (middle, length)):
            if not (high > low).any():
                continue  # before that place: none of it, where the sun is up
            for part in range(4):  # towards the dense end, shorter and shorter
                a, b = (part / 4) ** 2, ((part + 1) / 4) ** 2
                if low is middle:
                    t0, t1 = low + a * (high - low), low + b * (high - low)
                else:
                    t0, t1 = high - b * (high - low), high - a * (high - low)
                start, end = at + t0[:, None] * sun, at + t1[:, None] * sun
                both = both + self._depth(self.scattering + self.absorption, start, end)
        return np.where(hidden, 0, np.exp(-both))

    def _any_direction(self, count, rng):
        z = 2 * rng.random(count) - 1
        turn = 2 * np.pi * rng.random(count)
        flat = np.sqrt(1 - z**2)
        return np.stack([flat * np.cos(turn), z, flat * np.sin(turn)], axis=1)

    def _scatter(self, mueller, way, axis, to):
        """Mueller matrices with one more scattering, into ``to``; and the axis there."""
        normal = np.cross(way, to)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        in_plane = np.cross(normal, way)
        x = np.einsum("ij,ij->i", in_plane, axis)
        y = np.einsum("ij,ij->i", in_plane, np.cross(way, axis))
        angle = 2 * np.arctan2(y, x)
        c, s = np.cos(angle), np.sin(angle)
        mu = np.einsum("ij,ij->i", way, to)
        d = self.delta
        turned = np.zeros((len(way), 3, 3))  # from the plane of scattering to the path's axis
        turned[:, 0, 0] = 1
        turned[:, 1, 1], turned[:, 1, 2] = c, -s
        turned[:, 2, 1], turned[:, 2, 2] = s, c
        phase = np.zeros_like(turned)
        phase[:, 0, 0] = 0.75 * d * (1 + mu**2) + 1 - d
        phase[:, 1, 1] = 0.75 * d * (1 + mu**2)
        phase[:, 0, 1] = phase[:, 1, 0] = -0.75 * d * (1 - mu**2)
        phase[:, 2, 2] = 1.5 * d * mu
        return mueller @ turned @ phase, np.cross(normal, to)
