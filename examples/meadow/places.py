"""What grows where in the meadow: trees, drifts of flowers, bushes, hedges and stones, metres."""

from .shapes import linear

# name, x, z, size, turn about the vertical (small, as the sun side is baked in)
TREES = [
    ("oak", -8.6, -7.4, 1.3, 0.0),
    ("oak", 19.0, -27.0, 1.1, 0.3),
    ("oak", -15.0, 9.5, 1.25, -0.25),
    ("oak", -27.0, -30.0, 1.1, 0.2),
    ("birch", 6.9, -6.6, 1.3, 0.0),
    ("birch", 9.6, -9.0, 1.15, 0.35),
    ("birch", 6.2, -11.5, 1.0, -0.3),
    ("birch", -3.5, -31.0, 1.1, 0.2),
    ("birch", 12.0, 6.4, 1.35, -0.2),
    ("birch", 14.4, 8.6, 1.1, 0.2),
    ("birch", -9.0, 24.0, 1.2, 0.3),
]
CROWN = {"oak": (4.4, 5.6), "birch": (2.2, 5.5)}  # radius and height of the middle, metres

# Drifts of flowers: kind, x, z, radius, number of plants. The first rows frame the camera "bee".
DRIFTS = [
    ("poppies", -0.66, 3.9, 0.4, 11),
    ("cornflowers", 0.64, 3.95, 0.3, 9),
    ("daisies", 0.1, 3.45, 0.42, 10),
    ("buttercups", -0.25, 2.7, 0.55, 10),
    ("poppies", -1.6, 3.1, 0.7, 20),
    ("cornflowers", 2.5, 3.0, 0.8, 24),
    ("poppies", 2.5, 0.6, 0.9, 16),
    ("poppies", -3.6, 0.4, 1.5, 40),
    ("poppies", 5.0, -3.0, 2.4, 80),
    ("cornflowers", -1.6, 1.4, 1.0, 18),
    ("cornflowers", 4.6, 1.0, 1.6, 30),
    ("daisies", -0.5, 1.9, 0.8, 14),
    ("daisies", 2.4, 2.2, 0.8, 16),
    ("daisies", -2.6, 3.6, 1.0, 18),
    ("daisies", -4.8, -3.6, 2.4, 60),
    ("daisies", 7.2, -2.2, 2.0, 30),
    ("daisies", 0.1, 4.6, 1.1, 18),
    ("buttercups", -0.1, 4.5, 1.2, 20),
    # Around and behind it: a bee sees almost everything.
    ("daisies", 0.9, 5.7, 0.6, 14),
    ("poppies", -0.9, 5.6, 0.7, 16),
    ("buttercups", -2.0, 5.2, 0.8, 14),
    ("cornflowers", -0.2, 6.4, 0.7, 12),
    ("clover", 0.3, 5.4, 0.5, 6),
    ("poppies", 3.8, 5.0, 1.2, 28),
    ("daisies", -4.2, 6.6, 1.5, 24),
    ("poppies", 0.4, 8.4, 1.5, 34),
    ("cornflowers", -3.6, 9.0, 1.3, 16),
    ("daisies", 4.2, 8.0, 1.4, 20),
    ("buttercups", -0.4, 1.2, 1.1, 26),
    ("buttercups", -1.8, -4.6, 2.4, 46),
    ("buttercups", 3.2, -8.0, 2.2, 34),
    ("clover", 0.2, 3.9, 0.6, 8),
    ("clover", -1.7, 4.4, 0.8, 12),
    ("clover", 2.9, 2.0, 1.1, 18),
]
DRIFT_COLOURS = {
    "poppies": linear(206, 50, 28),
    "cornflowers": linear(82, 104, 210),
    "daisies": linear(236, 236, 224),
    "buttercups": linear(240, 206, 40),
    "clover": linear(196, 126, 172),
}
PETALS = {  # natural materials
    "poppies": "red petal with ultraviolet",
    "cornflowers": "blue petal",
    "daisies": "white petal",
    "buttercups": "yellow petal with ultraviolet",
    "clover": "pink petal",
}
FLOWER_HEIGHTS = {  # of the heads in a distant drift, metres
    "poppies": (0.4, 0.6),
    "cornflowers": (0.35, 0.6),
    "daisies": (0.3, 0.5),
    "buttercups": (0.25, 0.45),
    "clover": (0.15, 0.25),
}
BUSHES = [(-15.5, -13, 1.5), (-13.2, -17, 1.2), (13.5, -17.5, 1.4), (16, -15, 1.0), (25, -18, 1.5)]
BUSHES += [(-30, -8, 1.7), (-6.5, -24, 1.2), (28, 2, 1.5), (-20, 24, 1.6), (14, 27, 1.4)]
# Hedges between the fields: from x, z to x, z.
HEDGES = [(-62, -50, -20, -62), (-20, -62, 34, -58), (34, -58, 66, -40), (-20, -62, -30, -104)]
HEDGES += [(34, -58, 44, -98), (60, 20, 44, 66), (-50, 40, -66, -8)]
STONES = [(-2.9, 1.9, 0.55), (-3.4, 2.5, 0.3), (3.6, -1.6, 0.7), (4.3, -1.3, 0.35)]
STONES += [
    (-6.0, -8.5, 1.3),
    (-5.2, -7.6, 0.6),
    (11.5, -7.0, 1.0),
    (2.9, -14, 0.8),
    (-14, 3, 0.9),
    (15, 5, 1.2),
]
