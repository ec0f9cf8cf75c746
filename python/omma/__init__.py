"""What an animal with compound eyes sees.

    import omma

    scene = omma.load_scene(omma.examples.meadow())
    eye = omma.species.honeybee_worker().eye
    renderer = omma.Renderer(scene, eye, omma.Fixed(16))
    responses = renderer.render(omma.look_at((0, 1, 0), (0, 1, -5)))  # float32 (1, N, 3), linear
    omma.save_png("view.png", omma.picture.framed(eye, responses[0]))

The response of ommatidium i in band b is the radiance around it, weighted by its angular
sensitivity: an evenly lit surround of radiance 1 gives exactly 1. Linear, never clipped. Poses are
``world_from_head``: the head looks along its -Z, +X is its right, +Y up; lengths are metres, angles
radians, where a name does not say otherwise.

At the top is what a first hour needs; the rest is in subpackages, loaded when they are used:

- `omma.eye`: eyes made, changed, measured, read and written; `omma.species`: those of ten animals
- `omma.receptors`, `omma.light`: sensitivities to wavelengths; bands
- `omma.colour_vision`: colours as animals tell them apart, from how far they detect them
- `omma.photoreceptors`: what receptors make of light in time, noise, adaptation
- `omma.scene`, `omma.rendering`: worlds and their parts; the renderer and its reports
- `omma.stimuli`: gratings, bars, looming discs, targets, dots, panoramas and LED arenas that move
- `omma.motion`: motion detectors over responses
- `omma.picture`: pictures of responses and of eyes
- `omma.study`: how many rays a scene needs; `omma.job`: whole renders from files to files
- `omma.datasets`: millions of views as jobs, in stores for training
- `omma.gym`: closed loops as Gymnasium environments; `omma.columns`: medulla columns, hexagonal
  lattices
- `omma.mujoco`: worlds of MuJoCo models, a retina for FlyGym
- `omma.view`: a page in the browser that shows what an animal sees, live
- `omma.examples`: a meadow and a flight over it; `omma.compat`: for the scripts of CompoundRay
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
