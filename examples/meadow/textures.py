"""Draws the meadow's textures: tileable ground, cut-out grass and leaves, bark.

All are drawn, none is a photograph. The ground is nearly neutral (its hue comes from the terrain's
vertex colours) so that one picture serves lush grass, dry grass, soil and stones.

For lit materials the colours of grass and leaves hold no light: all blades and leaves are a light
grey that only varies from one to the next; their hue and brightness come from the material.
"""

import io
import math

import numpy as np
from PIL import Image, ImageDraw

SUPERSAMPLING = 4
NEUTRAL = np.full(3, 205.0)  # of blades and leaves without light
# Of the lightest: even dry grass, of which 0.72 comes out again, is not to send back more than it
# gets where its picture is lightest.
LIGHTEST = 220


def encoded(image, **options):
    stream = io.BytesIO()
    image.save(stream, **options)
    return stream.getvalue()


def smooth_noise(rng, size, slope, low=0.0):
    """Tileable noise (size, size), mean 0, deviation 1, amplitude ~ frequency^-slope above low."""
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.fftfreq(size)[None, :]) * size
    amplitude = np.where(frequency > low, np.maximum(frequency, 1) ** -slope, 0)
    amplitude[0, 0] = 0
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal((size, size))) * amplitude).real
    return field / field.std()


def ground_jpeg(rng, size=1024):
    """Short turf from above: thousands of small blades over soil, on mixed scales."""
    draw_size = size * 2
    image = Image.new("RGB", (draw_size, draw_size), (132, 124, 98))
    draw = ImageDraw.Draw(image)
    count = 44000
    for i in range(count):
        # Later strokes lie on top and are lighter: blades above, litter below.
        depth = i / count
        x, y = rng.uniform(0, draw_size, 2)
        angle = rng.uniform(0, 2 * math.pi)
        length = rng.uniform(14, 60)
        dx, dy = length * math.cos(angle), length * math.sin(angle)
        light = 124 + 84 * depth + rng.normal(0, 20)
        dry = rng.random() < 0.16
        warm = np.array([1.08, 1.0, 0.84]) if dry else np.array([0.99, 1.01, 0.92])
        colour = tuple(int(c) for c in np.clip(light * warm * rng.uniform(0.95, 1.05, 3), 0, 255))
        bend = rng.normal(0, 0.2, 2) * length
        for ox in (-draw_size, 0, draw_size):
            for oy in (-draw_size, 0, draw_size):
                px, py = x + ox, y + oy
                if -80 < px < draw_size + 80 and -80 < py < draw_size + 80:
                    middle = (px + dx / 2 + bend[0], py + dy / 2 + bend[1])
                    draw.line([(px, py), middle, (px + dx, py + dy)], colour, rng.integers(3, 7))
    pixels = np.asarray(image.resize((size, size), Image.Resampling.BOX)).astype(float)
    patches = 1 + 0.02 * smooth_noise(rng, size, 1.3) + 0.03 * smooth_noise(rng, size, 0.9)
    warmth = 0.012 * smooth_noise(rng, size, 1.4)[..., None] * np.array([1.0, 0.0, -1.0])
    pixels = np.clip(pixels * (patches[..., None] + warmth), 0, 255)
    image = Image.fromarray(pixels.astype(np.uint8))
    return encoded(image, format="JPEG", quality=62, optimize=True, subsampling=2)


def cutout_png(image, lightest=255):
    """RGBA drawn large -> RGBA small with the colour spread into the holes, encoded as PNG."""
    width, height = (v // SUPERSAMPLING for v in image.size)
    large = np.asarray(image).astype(float)
    alpha = large[..., 3:] / 255
    blocks = (height, SUPERSAMPLING, width, SUPERSAMPLING, -1)
    weight = alpha.reshape(blocks).mean(axis=(1, 3))
    colour = (large[..., :3] * alpha).reshape(blocks).mean(axis=(1, 3))
    known = weight > 0.02
    colour = np.where(known, colour / np.maximum(weight, 0.02), 0)
    # Interpolation at a cut-out's rim reads the colour outside it, so that must not be black.
    for _ in range(8):
        total = np.zeros_like(colour)
        count = np.zeros_like(weight)
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            total += np.roll(np.where(known, colour, 0), step, axis)
            count += np.roll(known.astype(float), step, axis)
        grown = ~known & (count > 0)
        colour = np.where(grown, total / np.maximum(count, 1), colour)
        known = known | grown
    mean = (colour * weight).sum(axis=(0, 1)) / weight.sum()
    colour = np.minimum(np.where(known, colour, mean), lightest)
    # Steps of 4 cannot be seen here and make the PNG a third smaller. Alpha above and below the
    # cut-off stays where it is.
    colour = np.round(colour / 4) * 4
    opacity = np.round(weight * 15) * 17
    pixels = np.clip(np.concatenate([colour, opacity], axis=2), 0, 255).astype(np.uint8)
    return encoded(Image.fromarray(pixels, "RGBA"), format="PNG", optimize=True)


def draw_blade(draw, base, tip, bend, width, low, high, steps=9):
    """One blade of grass, a bent taper from base to tip, its colour going from low to high."""
    base, tip = np.array(base, float), np.array(tip, float)
    middle = (base + tip) / 2 + np.array([bend, 0.0])
    along = np.linspace(0, 1, steps + 1)[:, None]
    line = (1 - along) ** 2 * base + 2 * along * (1 - along) * middle + along**2 * tip
    half = width / 2 * (1 - along[:, 0] ** 2.2) + 0.4
    for i in range(steps):
        a, b = line[i], line[i + 1]
        fraction = (i + 0.5) / steps
        colour = tuple(int(v) for v in np.clip(low + (high - low) * fraction, 0, 255))
        # The left half a little lighter than the right: a fold along the blade.
        other = tuple(int(v * 0.87) for v in colour)
        left = [(a[0] - half[i], a[1]), tuple(a), tuple(b), (b[0] - half[i + 1], b[1])]
        right = [(a[0] + half[i], a[1]), tuple(a), tuple(b), (b[0] + half[i + 1], b[1])]
        draw.polygon(left, (*colour, 255))
        draw.polygon(right, (*other, 255))


def grass_png(rng, lit=False, size=512):
    """Two strips, one above the other: short lush grass, and tall thin grass with seed heads."""
    s = SUPERSAMPLING
    width, height = size * s, size * s // 2
    sheet = Image.new("RGBA", (width, height * 2), (0, 0, 0, 0))
    low, high = np.array([58, 74, 27]), np.array([166, 188, 84])
    straw_low, straw_high = np.array([70, 84, 36]), np.array([196, 184, 118])
    if lit:
        low = high = straw_low = straw_high = NEUTRAL
    lush = Image.new("RGBA", (width, height), (0, 0, 0, 0))
    draw = ImageDraw.Draw(lush)
    for i in range(105):
        depth = i / 105
        x = rng.uniform(0.03, 0.97) * width
        reach = rng.uniform(0.45, 0.97) * height * (1 - 0.25 * abs(2 * x / width - 1))
        lean = rng.normal(0, 0.11) * width
        tint = rng.normal(1, 0.09) * (1 if lit else 0.72 + 0.33 * depth)
        hue = np.array([rng.normal(1, 0.10), 1.0, rng.normal(1, 0.08)])
        if rng.random() < 0.10:
            hue = np.array([1.22, 1.02, 0.9])  # a dry one
        if lit:
            tint, hue = (1 + tint) / 2, 1.0
        tip = (np.clip(x + lean, 0.01 * width, 0.99 * width), height - reach)
        bend = lean * rng.uniform(-0.8, -0.2)
        draw_blade(draw, (x, height), tip, bend, rng.uniform(4, 8.5) * s, low, high * tint * hue)
    tall = Image.new("RGBA", (width, height), (0, 0, 0, 0))
    draw = ImageDraw.Draw(tall)
    for _ in range(46):
        x = rng.uniform(0.05, 0.95) * width
        reach = rng.uniform(0.3, 0.62) * height
        tip = (np.clip(x + rng.normal(0, 0.08) * width, 0, width), height - reach)
        tint = rng.uniform(0.8, 1.08)
        draw_blade(draw, (x, height), tip, 0, rng.uniform(3.5, 6) * s, low, high * tint)
    for _ in range(17):
        x = rng.uniform(0.06, 0.94) * width
        reach = rng.uniform(0.66, 0.93) * height
        tip = (np.clip(x + rng.normal(0, 0.05) * width, 0.03 * width, 0.97 * width), height - reach)
        tint = rng.uniform(0.85, 1.1)
        draw_blade(draw, (x, height), tip, 0, 3.2 * s, straw_low, straw_high * tint)
        for k in range(16):
            fraction = k / 16
            spread = 5.5 * s * (1 - fraction) * (1 if k % 2 else -1) + rng.normal(0, s)
            y = tip[1] + (0.17 * height) * (1 - fraction)
            dot = (tip[0] + spread, y)
            seed = np.clip(straw_high * tint * rng.uniform(0.75, 1.1), 0, 255)
            seed = tuple(int(v) for v in seed)
            box = [dot[0] - 1.5 * s, dot[1] - 3.5 * s, dot[0] + 1.5 * s, dot[1] + 3.5 * s]
            draw.ellipse(box, (*seed, 255))
    sheet.paste(lush, (0, 0))
    sheet.paste(tall, (0, height))
    return cutout_png(sheet, LIGHTEST if lit else 255)


def draw_leaf(draw, centre, angle, length, width, colour):
    along = np.linspace(0, 1, 9)
    half = width / 2 * np.sin(np.pi * along**0.8)
    spine = np.stack([length * (along - 0.5), 0 * along], axis=1)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    for sign, light in ((1, 1.0), (-1, 0.84)):
        edge = np.stack([spine[:, 0], sign * half], axis=1)
        outline = np.concatenate([spine, edge[::-1]]) @ turn.T + centre
        shade = tuple(int(v) for v in np.clip(np.asarray(colour) * light, 0, 255))
        draw.polygon([tuple(p) for p in outline], (*shade, 255))


def leaves_png(rng, lit=False, size=512):
    """Four sprays of leaves: broad (oak), small and light (birch), bush, dense far foliage."""
    s = SUPERSAMPLING
    half = size * s // 2
    sheet = Image.new("RGBA", (2 * half, 2 * half), (0, 0, 0, 0))
    kinds = [
        (120, 30, 15, (116, 146, 58)),
        (170, 17, 12, (136, 160, 66)),
        (150, 22, 13, (96, 128, 58)),
        (260, 19, 13, (108, 136, 60)),
    ]
    for k, (count, length, width, colour) in enumerate(kinds):
        tile = Image.new("RGBA", (half, half), (0, 0, 0, 0))
        draw = ImageDraw.Draw(tile)
        for i in range(count):
            radius = 0.42 * math.sqrt(rng.random()) * half
            direction = rng.uniform(0, 2 * math.pi)
            # An uneven rim, so that a card's outline is not a disc.
            radius *= 0.82 + 0.2 * math.sin(3 * direction + k) * math.cos(2 * direction)
            centre = np.array([math.cos(direction), math.sin(direction)]) * radius + half / 2
            light = (1 if lit else 0.55 + 0.5 * i / count) + rng.normal(0, 0.07)
            hue = np.array([rng.normal(1, 0.07), 1, rng.normal(1, 0.06)])
            angle = direction + rng.normal(0, 0.9)
            scale = s * rng.uniform(0.75, 1.2)
            shown = (NEUTRAL if lit else colour) * hue * light
            draw_leaf(draw, centre, angle, length * scale, width * scale, shown)
        sheet.paste(tile, ((k % 2) * half, (k // 2) * half))
    return cutout_png(sheet)


def bark_jpeg(rng, size=256):
    """Left half: furrowed bark. Right half: white bark with dark bands. Both tile upwards."""
    half = size // 2
    furrows = np.repeat(smooth_noise(rng, size, 0.8, 4)[::4][:, :half], 4, axis=0)
    rough = np.clip(0.62 + 0.16 * furrows + 0.05 * rng.standard_normal((size, half)), 0.15, 1)
    left = rough[..., None] * np.array([150, 128, 102])
    right = np.full((size, half, 3), 222.0) * np.array([1, 0.99, 0.95])
    right *= 1 + 0.05 * rng.standard_normal((size, half, 1))
    for _ in range(34):
        row, column = rng.integers(0, size), rng.integers(0, half)
        tall, wide = rng.integers(2, 7), rng.integers(12, 52)
        rows = (row + np.arange(tall)) % size
        columns = (column + np.arange(wide)) % half
        right[np.ix_(rows, columns)] *= rng.uniform(0.25, 0.6)
    pixels = np.clip(np.concatenate([left, right], axis=1), 0, 255).astype(np.uint8)
    return encoded(Image.fromarray(pixels), format="JPEG", quality=72, optimize=True)
