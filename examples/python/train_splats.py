"""A splat world, trained here from pictures of the bundled meadow: Gaussians, in a file of 3DGS.

Omma takes the pictures: perspective views of the unlit meadow from places around the camera "bee",
sRGB-encoded as photographs are. Points that the pictures' own rays meet stand in for the sparse
points that COLMAP finds in photographs; real ones are fewer and less exact. PyTorch moves the
Gaussians by gradients of the pictures' error (Adam), by the rule that Omma renders splats by: one
ray per pixel, each Gaussian at its greatest response along the ray, in the order of those points.
The sky is no splats: it stays the background that the scene has, composited in linear light behind
them, and is to be given to whoever renders the file.

    pip install torch
    python examples/python/train_splats.py -o meadow_splats.ply
    python examples/python/train_splats.py --quick -o quick.ply   (seconds, to try it)
"""

import argparse
import math
import time
from pathlib import Path

import numpy as np
import torch
from scipy.spatial import cKDTree
from splat_pictures import (
    HEIGHT,
    PIXEL_RAD,
    WIDTH,
    Grid,
    decode,
    encode,
    poses_around,
    take_pictures,
)

import omma

STRIDE = 2  # of the columns and rows that a step renders
HELD_OUT = 8  # every eighth view is not trained on
# Of the model, as 3DGS has them (Kerbl et al. 2023).
LEAST_ALPHA, MOST_ALPHA, LEAST_TRANSMITTANCE = 1 / 255, 0.99, 1e-4
Y0, Y1 = 0.28209479177387814, 0.4886025119029199
# Steps of Adam. Positions are in units of the size that a splat had at first.
RATES = {
    "shift": 0.02, "log_scale": 0.015, "turn": 0.01, "logit": 0.05, "color": 0.02, "slope": 0.005,
}  # fmt: skip
FEW_PIXELS = 8  # of all pictures: splats that fill less are moved elsewhere
SMALLEST_PX = 0.3  # no splat is thinner, seen from the nearest camera: rays would miss it


class Splats:
    """Gaussians that can be trained: position start + size shift, and what a file of 3DGS has."""

    def __init__(self, views, count, seed=0):
        self.views, self.random = views, np.random.default_rng(seed)
        self.cameras = cKDTree(np.stack([view.eye.numpy() for view in views]))
        start, size, color = self.draw(count)
        self.start, self.size = torch.from_numpy(start), torch.from_numpy(size)
        self.smallest = torch.from_numpy(self.least_scale(start))
        self.trained = {
            "shift": torch.zeros(count, 3),
            "log_scale": torch.log(self.size)[:, None].repeat(1, 3),
            "turn": torch.tensor([1.0, 0, 0, 0]).repeat(count, 1),
            "logit": torch.full((count,), 0.0),
            "color": torch.tensor(color),
            "slope": torch.zeros(count, 3, 3),  # harmonics of degree 1: (n, coefficient, rgb)
        }
        self.shown = torch.zeros(count)  # pixels that each has filled, since splats last moved
        for value in self.trained.values():
            value.requires_grad_(True)
        self.adam = torch.optim.Adam(
            [{"params": [self.trained[name]], "lr": rate} for name, rate in RATES.items()],
            eps=1e-10,
        )

    def draw(self, count):
        """Points, sizes and harmonics of degree 0 of new splats: more where errors are large."""
        met = [np.flatnonzero(np.isfinite(view.points[:, 0])) for view in self.views]
        points = np.concatenate([view.points[on] for view, on in zip(self.views, met)])
        colors = np.concatenate([view.picture.numpy()[on] for view, on in zip(self.views, met)])
        error = np.concatenate([view.error[on] for view, on in zip(self.views, met)])
        drawn = self.random.choice(len(points), count, replace=False, p=error / error.sum())
        others = points[drawn]
        if hasattr(self, "start"):
            others = np.concatenate([others, self.positions().detach().numpy()])
        near = cKDTree(others).query(points[drawn], k=4)[0][:, 1:].mean(axis=1)
        size = np.clip(0.7 * near, self.least_scale(points[drawn]), None)
        of_color = (colors[drawn] - 0.5) / Y0
        return points[drawn].astype("f4"), size.astype("f4"), of_color.astype("f4")

    def least_scale(self, points):
        """(n,), m, of splats there: what is thinner falls between the pixels of all cameras."""
        return (SMALLEST_PX * PIXEL_RAD * self.cameras.query(points)[0]).astype("f4")

    def positions(self):
        return self.start + self.size[:, None] * self.trained["shift"]

    def opacity(self):
        return torch.sigmoid(self.trained["logit"])

    def rotations(self):
        """World from the Gaussian's own axes (n, 3, 3), of quaternions w, x, y, z."""
        w, x, y, z = torch.nn.functional.normalize(self.trained["turn"], dim=1).unbind(1)
        return torch.stack(
            [
                1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
            ], dim=1,
        ).view(-1, 3, 3)  # fmt: skip

    def colors_from(self, eye):
        """Display RGB (n, 3), by the direction from the camera to each centre."""
        x, y, z = torch.nn.functional.normalize(self.positions() - eye, dim=1).unbind(1)
        basis = Y1 * torch.stack([-y, z, -x], dim=1)
        slope = (basis[:, :, None] * self.trained["slope"]).sum(1)
        return (0.5 + Y0 * self.trained["color"] + slope).clamp(min=0)

    def step(self, loss, rate):
        for group, first in zip(self.adam.param_groups, RATES.values()):
            group["lr"] = first * rate
        self.adam.zero_grad()
        loss.backward()
        self.adam.step()
        with torch.no_grad():
            scale = self.trained["log_scale"]
            scale.copy_(torch.maximum(scale, torch.log(self.smallest)[:, None]))

    def move_little_used(self):
        """Splats that fill next to nothing go where errors are largest; their number is told."""
        with torch.no_grad():
            least = torch.argsort(self.shown)[: len(self.shown) // 20]
            which = least[self.shown[least] < FEW_PIXELS]
            self.shown.zero_()
            if not len(which):
                return 0
            start, size, color = (torch.from_numpy(one) for one in self.draw(len(which)))
            self.start[which], self.size[which] = start, size
            self.smallest[which] = torch.from_numpy(self.least_scale(start.numpy()))
            now = {"log_scale": torch.log(size)[:, None].repeat(1, 3), "color": color}
            now["turn"] = torch.tensor([1.0, 0, 0, 0]).repeat(len(which), 1)
            for name, value in self.trained.items():
                value[which] = now.get(name, torch.zeros_like(value[which]))
                for moment in ("exp_avg", "exp_avg_sq"):
                    self.adam.state[value][moment][which] = 0
        return len(which)


@torch.no_grad()
def boxes(splats, view, grid):
    """Columns and rows (n, 4) that the outlines of Gaussians lie in: from, to (excluded)."""
    shape = view.frame @ splats.rotations() * torch.exp(splats.trained["log_scale"])[:, None, :]
    centre = (splats.positions() - view.eye) @ view.frame.T
    reach2 = 2 * torch.log(splats.opacity() / LEAST_ALPHA)
    # The dual conic of the ellipsoid of that radius as the camera sees it: its tangents.
    conic = reach2[:, None, None] * (shape @ shape.mT) - centre[:, :, None] * centre[:, None, :]
    depth = conic[:, 2, 2]
    ends = []
    for axis, middle in ((0, (WIDTH - 1) / 2), (1, (HEIGHT - 1) / 2)):
        cross, own = conic[:, axis, 2], conic[:, axis, axis]
        inside = cross**2 - own * depth
        half = torch.sqrt(inside.clamp(min=0)) / depth.abs()
        low, high = cross / depth - half, cross / depth + half
        # One that reaches behind the camera's plane goes on beyond one of its tangents for ever.
        upper = centre[:, axis] > cross / depth * centre[:, 2]
        low, high = (
            torch.where(depth < 0, low, torch.where(upper & (inside > 0), high, -1e9)),
            torch.where(depth < 0, high, torch.where(upper | (inside <= 0), 1e9, low)),
        )
        for end in (torch.ceil, low, 0), (torch.floor, high, 1):
            pixel = (end[1] / PIXEL_RAD + middle - grid.first[axis]) / grid.stride
            ends.append((end[0](pixel) + end[2]).clamp(0, grid.size[axis]))
    unseen = (reach2 <= 0) | ((depth < 0) & (centre[:, 2] <= 0))
    return torch.where(unseen[:, None], 0, torch.stack(ends, dim=1)).long()


@torch.no_grad()
def meetings(splats, view, rows, grid):
    """Which splats count for which rays: (splat, ray), by ray and then along it."""
    left, right, top, bottom = boxes(splats, view, grid).unbind(1)
    wide = (right - left).clamp(min=0)
    number = wide * (bottom - top).clamp(min=0)
    splat = torch.repeat_interleave(number)
    inside = torch.arange(len(splat)) - (torch.cumsum(number, 0) - number)[splat]
    down = top[splat] + inside // wide[splat]
    ray = down * grid.size[0] + left[splat] + inside % wide[splat]
    alpha, t, _ = respond(rows, splat, (grid.rays @ view.frame)[ray])
    counts = torch.nonzero((alpha >= LEAST_ALPHA) & (t > 0))[:, 0]
    splat, ray, alpha, t = splat[counts], ray[counts], alpha[counts], t[counts]
    order = torch.argsort(ray + t.double() / (1 + t.double()))
    splat, ray, alpha = splat[order], ray[order], alpha[order]
    seen = transmittance(alpha, ray) >= LEAST_TRANSMITTANCE
    return splat[seen], ray[seen]


def respond(rows, splat, rays):
    """Of pairs: alpha at the greatest response along the ray, where that is, and the colour."""
    to_unit, start, opacity, color = rows.index_select(0, splat).split([9, 3, 1, 3], dim=1)
    ahead = (to_unit.view(-1, 3, 3) @ rays[:, :, None])[:, :, 0]
    t = -(start * ahead).sum(1) / (ahead * ahead).sum(1)
    nearest = start + t[:, None] * ahead
    alpha = opacity[:, 0] * torch.exp(-0.5 * (nearest * nearest).sum(1))
    return alpha.clamp(max=MOST_ALPHA), t, color


def transmittance(alpha, ray):
    """Of pairs, by ray and along it: what the splats before leave."""
    logs = torch.log1p(-alpha.double())
    before = torch.cumsum(logs, 0) - logs
    return torch.exp(before - before[torch.searchsorted(ray, ray)])


def render(splats, view, grid):
    """The picture of splats, sRGB-encoded (rays, 3)."""
    to_unit = splats.rotations().mT / torch.exp(splats.trained["log_scale"])[:, :, None]
    start = (to_unit @ (view.eye - splats.positions())[:, :, None])[:, :, 0]
    opacity = splats.opacity()[:, None]
    rows = [to_unit.reshape(-1, 9), start, opacity, splats.colors_from(view.eye)]
    rows = torch.cat(rows, dim=1)
    splat, ray = meetings(splats, view, rows, grid)
    alpha, _, color = respond(rows, splat, (grid.rays @ view.frame)[ray])
    weight = transmittance(alpha, ray).float() * alpha
    splats.shown.index_add_(0, splat, weight.detach())
    light = torch.zeros(len(grid.rays), 3).index_add(0, ray, weight[:, None] * color)
    covered = torch.zeros(len(grid.rays)).index_add(0, ray, weight)[:, None]
    own = decode(light / covered.clamp(min=1e-3))
    return encode(covered * own + (1 - covered) * view.sky[grid.pixels])


def decibels(splats, views):
    """Peak signal to noise (dB) of pictures, the mean over them."""
    grid = Grid()
    with torch.no_grad():
        errors = [((render(splats, view, grid) - view.picture) ** 2).mean() for view in views]
    return float(np.mean([-10 * math.log10(float(error)) for error in errors]))


def train(views, *, count, steps, minutes, seed=0):
    """Splats trained on all views but each eighth, and what to say of them."""
    grids = [Grid(STRIDE, i % STRIDE, i // STRIDE) for i in range(STRIDE**2)]
    kept = [view for i, view in enumerate(views) if i % HELD_OUT != HELD_OUT - 1]
    held_out = views[HELD_OUT - 1 :: HELD_OUT]
    splats = Splats(kept, count, seed)
    print(f"before: held-out views at {decibels(splats, held_out):.2f} dB", flush=True)
    began, order = time.monotonic(), []
    for step in range(steps):
        done = max(step / steps, (time.monotonic() - began) / (60 * minutes))
        if done >= 1:
            break
        if not order:
            order = list(splats.random.permutation(len(kept) * STRIDE**2))
            if step:
                moved = splats.move_little_used() if done < 0.8 else 0
                mean = float(np.mean([one.error.mean() for one in kept]))
                print(
                    f"step {step}, {100 * done:.0f} %: error {mean:.4f}, {moved} moved", flush=True
                )
        which = order.pop()
        view, grid = kept[which // STRIDE**2], grids[which % STRIDE**2]
        off = (render(splats, view, grid) - view.picture[grid.pixels]).abs()
        splats.step(off.mean(), 10**-done)
        view.error[grid.pixels] = off.detach().mean(1).numpy()
    took = (time.monotonic() - began) / 60
    print(f"{count} splats, {step} steps in {took:.1f} minutes")
    for name, these in (("trained", kept[:: HELD_OUT - 1]), ("held-out", held_out)):
        print(f"{name} views: {len(these)}, PSNR {decibels(splats, these):.2f} dB")
    return splats


def save(path, splats):
    """A file as 3DGS writes it, and the same as arrays, with where the training cameras were."""
    with torch.no_grad():
        trained = {name: value.numpy() for name, value in splats.trained.items()}
        positions = splats.positions().numpy()
    turn = trained["turn"] / np.linalg.norm(trained["turn"], axis=1, keepdims=True)
    columns = {
        "x y z": positions,
        "nx ny nz": np.zeros_like(positions),
        "f_dc_0 f_dc_1 f_dc_2": trained["color"],
        # All coefficients of red, then of green, then of blue.
        " ".join(f"f_rest_{i}" for i in range(9)): trained["slope"].transpose(0, 2, 1),
        "opacity": trained["logit"],
        "scale_0 scale_1 scale_2": trained["log_scale"],
        "rot_0 rot_1 rot_2 rot_3": turn,
    }
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    lines += [f"property float {name}" for names in columns for name in names.split()]
    table = np.concatenate([value.reshape(len(turn), -1) for value in columns.values()], axis=1)
    head = "\n".join([*lines, "end_header", ""]).encode()
    path.write_bytes(head + table.astype("<f4").tobytes())
    np.savez(
        path.with_suffix(".npz"),
        position_m=positions,
        scale_m=np.exp(trained["log_scale"]),
        quaternion_wxyz=turn,
        opacity=1 / (1 + np.exp(-trained["logit"])),
        harmonics=np.concatenate([trained["color"][:, None], trained["slope"]], axis=1),
        camera_position_m=np.stack([view.eye.numpy() for view in splats.views]),
    )
    print(f"wrote {path}, {path.stat().st_size / 1e6:.2f} MB, and {path.stem}.npz")


def save_held_out(path, splats, views, shown=8):
    """Views that were not trained on: the meadow above, the splats below."""
    views = views[HELD_OUT - 1 :: HELD_OUT][:shown]
    with torch.no_grad():
        pairs = [(view.picture, render(splats, view, Grid())) for view in views]
    both = torch.stack([torch.cat(pair) for pair in pairs]).clamp(0, 1).numpy()
    picture = both.reshape(len(views), 2 * HEIGHT, WIDTH, 3).transpose(1, 0, 2, 3)
    omma.save_png(path, np.round(255 * picture.reshape(2 * HEIGHT, -1, 3)).astype(np.uint8))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("meadow_splats.ply"))
    parser.add_argument("--views", type=int, default=96)
    parser.add_argument("--splats", type=int, default=9_400, help="9,400 are a file of 1 MB")
    parser.add_argument("--steps", type=int, default=6_000)
    parser.add_argument("--minutes", type=float, default=15, help="ends sooner after these")
    parser.add_argument("--quick", action="store_true", help="few of all, in seconds")
    given = parser.parse_args(arguments)
    if given.quick:
        given.views, given.splats, given.steps = 8, 400, 36
    scene = omma.load_scene(omma.examples.meadow())
    views = take_pictures(scene, poses_around(scene, given.views))
    print(f"{len(views)} pictures of {WIDTH} x {HEIGHT}", flush=True)
    splats = train(views, count=given.splats, steps=given.steps, minutes=given.minutes)
    given.output.parent.mkdir(parents=True, exist_ok=True)
    save(given.output, splats)
    save_held_out(given.output.with_suffix(".png"), splats, views)


if __name__ == "__main__":
    main()
