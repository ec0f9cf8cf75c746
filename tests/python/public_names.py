"""What the package offers, at its top and in its subpackages."""

import inspect

import omma


def subpackages():
    """The package and its public subpackages and modules of these, by name; the package itself is
    ""."""
    found = {"": omma}

    def add(package, prefix):
        for name in package.__all__:
            thing = getattr(package, name)
            if inspect.ismodule(thing):
                found[prefix + name] = thing
                add(thing, f"{prefix}{name}.")

    add(omma, "")
    return found


def public_things():
    """(subpackage, name, thing) of everything public but the subpackages themselves and the
    version."""
    for subpackage, module in subpackages().items():
        for name in module.__all__:
            thing = getattr(module, name)
            if not inspect.ismodule(thing) and not name.startswith("__"):
                yield subpackage, name, thing
