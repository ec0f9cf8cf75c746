"""Omma in Blender: compound eyes as cameras, scenes as Omma reads them, renders by Omma.

docs/blender.md says how it is used. Blender's Python has no omma: what needs it is done by
worker.py in a process of its own (package.py).
"""

from . import export, eye_objects, panels, preferences, properties, render, spectra

_PARTS = (preferences, properties, eye_objects, spectra, export, render, panels)


def register() -> None:
    for part in _PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(_PARTS):
        part.unregister()
