"""A window into the eye: a page in the browser that shows what an animal sees, live; it needs the
extra `omma[view]`.

What is shown, without a page and without viser: `poses`, `state`, `painting`, `picked`,
`command`. `live` is the one thread that touches the engine, `motion` what plays and records,
`picture_ids` how large, `own_eye` the eye of a scene's camera; `scene_mesh`, `splat_scene` and
`overlay` shapes for the 3D scene. `page*` are the widgets, `page_files` what runs in the browser,
`keys` and `hands` what its keys do. `door` is the port that browsers come to, in front of viser's
own, with `ports`, `rules` (who may come in), `passing` (what goes on to viser) and `watchers`
(pictures out, hands in). `window` puts them together.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
