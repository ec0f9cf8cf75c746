"""What the package offers, at its top and in its rooms."""

import inspect

import omma


def rooms():
    """The package and its subpackages that are public, by name; the package itself is ""."""
    found = {"": omma}
    for name in omma.__all__:
        thing = getattr(omma, name)
        if inspect.ismodule(thing):
            found[name] = thing
    return found


def public_things():
    """(room, name, thing) of everything public but the rooms themselves and the version."""
    for room, module in rooms().items():
        for name in module.__all__:
            thing = getattr(module, name)
            if not inspect.ismodule(thing) and not name.startswith("__"):
                yield room, name, thing
