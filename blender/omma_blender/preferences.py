"""Where omma is, and how people are told what went wrong."""

import bpy

from . import package
from .package import OmmaError


class OmmaPreferences(bpy.types.AddonPreferences):
    """Preferences > Add-ons > Omma."""

    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="omma or its Python",
        description="The executable omma, a Python that has the package, or the folder of its "
        "environment. Empty: looked for in the search path and the usual places",
        subtype="FILE_PATH",
    )

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop(self, "program")
        row = self.layout.row()
        row.operator("omma.check_package")
        if facts := _facts.get(program()):
            row.label(text=f"omma {facts['version']}, {facts['python']}")


# By what the preference said: what the package there has said of itself; None where there was none.
_facts: dict[str, dict | None] = {}


def program() -> str:
    """What the preferences name, "" where that is nothing."""
    addon = bpy.context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.program) if addon and addon.preferences else ""


def package_facts() -> dict:
    """What the package offers; OmmaError where there is none."""
    name = program()
    if not _facts.get(name):
        _facts[name] = None
        _facts[name] = package.ask(name, "facts")
    return _facts[name]


def known(what: str) -> list[str]:
    """Names that the package knows, for fields that offer them; none where it is not there."""
    if _facts.get(program(), {}) is None:
        return []  # it was looked for; not again with every letter that is typed
    try:
        return package_facts()[what]
    except OmmaError:
        return []


def tell(operator: bpy.types.Operator, error: Exception | str) -> set[str]:
    """Says where the user looks why an operator stops: in the status bar and in a box."""
    message = str(error)
    if not bpy.app.background:

        def draw(menu: bpy.types.UIPopupMenu, context: bpy.types.Context) -> None:
            for line in _lines(message):
                menu.layout.label(text=line)

        bpy.context.window_manager.popup_menu(draw, title="Omma", icon="ERROR")
    operator.report({"ERROR"}, message)
    return {"CANCELLED"}


def _lines(message: str, width: int = 80) -> list[str]:
    lines = [""]
    for word in message.split():
        if lines[-1] and len(lines[-1]) + len(word) >= width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


class OMMA_OT_check_package(bpy.types.Operator):
    """Start omma and ask for its version"""

    bl_idname = "omma.check_package"
    bl_label = "Look for omma"

    def execute(self, context: bpy.types.Context) -> set[str]:
        _facts.clear()
        try:
            found = package_facts()
        except OmmaError as error:
            return tell(self, error)
        self.report({"INFO"}, f"omma {found['version']}, {found['python']}")
        return {"FINISHED"}


_register, _unregister = bpy.utils.register_classes_factory(
    (OmmaPreferences, OMMA_OT_check_package)
)


def register() -> None:
    _register()


def unregister() -> None:
    _facts.clear()
    _unregister()
