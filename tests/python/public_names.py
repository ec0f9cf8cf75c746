"""What the package offers, at its top and in its subpackages."""

import inspect

import omma


def subpackages():
    """The package and its public subpackages, by name; the package itself is ""."""
    found = {"": omma}
    for name in omma.__all__:
        thing = getattr(omma, name)
        if inspect.ismodule(thing):
            found[name] = thing
    return found


def public_things():
    """(subpackage, name, thing) of everything public but the subpackages themselves and the
    version."""
    for subpackage, module in subpackages().items():
        for name in module.__all__:
            thing = getattr(module, name)
            if not inspect.ismodule(thing) and not name.startswith("__"):
                yield subpackage, name, thing
