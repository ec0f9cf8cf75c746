"""Makes docs/species.md, the page of all animals' numbers, and its figures.

.venv/bin/python docs/make_species_figures.py            the page only, at once
.venv/bin/python docs/make_species_figures.py figures    the figures too, minutes
"""

import sys
from pathlib import Path

import numpy as np

import omma
from omma.picture import plot_eye_maps

DOCS = Path(__file__).resolve().parent
FIGURES = omma.species.names()

HEAD = """# Species

Eyes of animals, made from published numbers:

```python
robber_fly = omma.species.holcocephala()
renderer = omma.Renderer(scene, robber_fly.eye)
```

or `omma eye species holcocephala -o robber_fly.csv`. Each is a whole head: both eyes, with
positions, axes, facets, an angular sensitivity and receptors for every ommatidium, and a column
`region`. The eyes are stored with the package and read in a moment; `omma.species.build(name)`
grows one anew, which takes up to a minute, and `scripts/make_species.py` stores them.

Every number that goes into them is below and in `omma.species.facts()`, with its standing:
**measured**, a number that the source prints or that is computed from its data; **interpolated**,
worked out from such numbers; **assumed**, nobody's measurement. Below the tables it is said how
each source was read: many only as an abstract, some at second hand, and those marked "recalled" not
at all. If you know better numbers, change `python/omma/species/facts.csv` and run
`scripts/make_species.py`, which stores the eyes anew. Some shapes are not in the table. All of them
are assumed, and written where they are used, in `bees.py`, `flies.py`, `ants.py` and
`hunters.py` of `python/omma/species`: outlines of fields of view, and from where to where one angle
or facet blends into another. This page is made by `docs/make_species_figures.py`.

![Interommatidial angles, facets, acceptance angle: robber fly](species-holcocephala.png)
![The same, honeybee drone](species-honeybee_drone.png)
![The same, fiddler crab](species-fiddler_crab.png)

## How they are made

- The honeybee worker's axes are rows by the published formulas.
  Its receptors are those of `omma.receptors.honeybee_ommatidia`; as their pigments screen
  themselves in rhabdoms of 320 µm, the blue one gets 0.60 of a flat white from 400 to 700 nm (0.67
  without screening).
- Most others: a function of direction gives the local interommatidial angle,
  `omma.eye.lay_directions` a hexagonal lattice in it with as many ommatidia as counted. Lenses sit
  on an ellipsoid whose size follows from the facets; the axes are skewed against it.
- Where the table has no course of facets, they are as wide as the lenses are apart on the assumed
  surface. In the honeybee worker this gives 15 to 31 µm where the largest measured is 20 µm: do not
  take its facets for the animal's.
- *Drosophila* and *Calliphora* have R1 to R6 look along the axes of six neighbours
  (`omma.eye.fly_receptors`), so `Renderer.render_receptors` renders each in its own direction, and
  `omma.eye.pool` with `omma.eye.neural_superposition_wiring` gives what the cartridges see. In
  *Drosophila* seven in ten inner cartridges away from the equator pool six, in *Calliphora* nine in
  ten; the others pool mostly four, five or seven, because rows of such a lattice end where the
  angle grows.
- The robber fly and the dragonfly are made from the surface. Facets of 78 µm that look 0.28° apart
  along the surface's normals need a radius of curvature of 16 mm, on a fly of 6 mm: the front of
  the eye is nearly flat. Outside the fovea the surface bends, and angles grow to several degrees
  away from the fovea but much less around it. The same holds for the dragonfly's dorsal
  band, where 0.24° is the angle across.
- In such a stretched lattice the six nearest axes are not the six neighbours on the surface. Maps
  go by the neighbours on the surface, and show the smaller and the larger angle, as the mean would
  hide what is fine in one direction only; by the nearest axes the robber fly's would show a star
  that is not the eye's. By neighbours on the surface, Δφ (as a root mean square) 10 to 45° from the
  fovea is even around it to 8 %. There steps away from the fovea are four to six times those around
  it.
"""


def page():
    parts = [HEAD]
    for name in (*omma.species.names(), "megalopta"):
        title = name.replace("_", " ").capitalize()
        parts += [f"## {title}\n"]
        if name == "megalopta":
            example = "[an example](../examples/python/nocturnal_bee.py)"
            parts += [f"For {example} only; no eye is made.\n"]
        else:
            maker = getattr(omma.species, name)
            lines = [line.strip() for line in maker.__doc__.strip().splitlines()]
            parts += ["\n".join(lines) + "\n"]
        parts += [omma.species.facts_text(name)]
    parts += ["## Sources\n"]
    parts += [
        f"- `{source.key}`: {source.citation}" + (f" (read: {source.read})" if source.read else "")
        for source in omma.species.sources()
    ]
    return "\n".join(parts) + "\n"


def main():
    if sys.argv[1:] == ["figures"]:
        for name in FIGURES:
            animal = omma.species.make(name)
            angle = np.degrees(animal.eye.interommatidial_angle_rad())
            plot_eye_maps(
                DOCS / f"species-{name}.png",
                animal.eye,
                ["smaller", "larger", "facet", "acceptance"],
                title=animal.latin,
            )
            print(f"wrote species-{name}.png: Δφ {angle.min():.2f} to {angle.max():.2f}°")
    (DOCS / "species.md").write_text(page(), encoding="utf-8")
    print("wrote species.md")


if __name__ == "__main__":
    main()
