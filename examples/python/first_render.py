"""A first render: a meadow as a honeybee sees it, its numbers, and how sure they are.

python examples/python/first_render.py [directory to write to]
"""

import sys
from pathlib import Path

import numpy as np

import omma

examples = Path(__file__).resolve().parents[1]
out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

# A scene, and the two eyes of a head. `.eye` files are in millimetres; inside, all is metres.
scene = omma.load_scene(examples / "meadow.glb")
head = omma.eye.merge_eyes(
    [
        omma.load_eye(examples / f"honeybee_worker_{side}.eye", unit="mm")
        for side in ("left", "right")
    ]
)
print(scene)
print(head)

# The acceleration structure is built here, once; after that, poses are cheap.
renderer = omma.Renderer(scene, head, omma.Fixed(16), seed=0)
print(renderer)

# One pose, world_from_head (4, 4): where the head is and where it looks. Here that of a camera.
pose = scene.cameras[0].world_from_camera
responses, errors = renderer.render(pose, standard_error=True)
print("responses", responses.shape, responses.dtype, "pose, ommatidium, channel")
print("mean radiance", responses.mean(axis=(0, 1)), "median standard error", np.median(errors))

# Files: the numbers, a table of them, and pictures to look at.
np.save(out / "first_render.npy", responses)
omma.save_responses(out / "first_render.csv", responses, head, errors, world=renderer.world)
omma.save_png(out / "first_render.png", omma.picture.framed(head, responses))
# With degrees, the scale and the errors beside: pip install 'omma[plots]'.
omma.picture.plot_responses(
    out / "first_render_eyes.png",
    head,
    responses,
    errors=errors,
    title="A meadow as a honeybee worker sees it",
)

# A flight of 200 poses, a metre forward. One array (N, C) at a time comes out, so that a million
# poses would need no more memory. Where does the picture change most?
flight = np.repeat(pose[None], 200, axis=0)
flight[:, :3, 3] -= np.linspace(0, 1, 200)[:, None] * pose[:3, 2]  # the head looks along its -Z
change = np.zeros(len(head))
before = None
for now in renderer.render_iter(flight):
    if before is not None:
        change += np.abs(now - before).mean(axis=1)
    before = now
busiest = int(change.argmax())
print(
    "most change: ommatidium", busiest, "of eye", head.eye_id[busiest], "axis", head.axis[busiest]
)
