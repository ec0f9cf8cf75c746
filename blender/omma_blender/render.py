"""*Render with Omma*: the scene is exported, omma renders it in a process of its own, and Blender
gets the picture. Blender can be used meanwhile; Esc stops it."""

import shlex
import tempfile
from contextlib import suppress
from pathlib import Path

import bpy
import numpy as np

from .export import export_scene
from .package import OmmaError, Work, find_python
from .preferences import program, tell
from .properties import FIELD

PICTURE = "Omma: {}"


class Render:
    """One picture on its way. `poll` until it is True, then `finish`; or `stop`."""

    def __init__(self, context: bpy.types.Context, camera: bpy.types.Object | None) -> None:
        """Exports and starts omma.

        Raises:
            OmmaError: no camera, no eye, no omma, or a scene that does not export.
        """
        if camera is None or camera.type != "CAMERA":
            raise OmmaError(
                "The scene has no camera to see from: add one (Add > Camera > Compound Eye), or "
                "make one active"
            )
        if camera.name not in context.scene.objects or camera.hide_render:
            raise OmmaError(f"The camera {camera.name} is hidden in renders or of another scene")
        settings, eye = context.scene.omma_render, camera.data.omma_eye
        python = find_python(program())
        self.camera = camera.name
        self._temporary = None
        if settings.numbers.startswith("//") and not bpy.data.filepath:
            raise OmmaError(
                f"{settings.numbers}: is beside the .blend file, which is not saved yet. Save it, "
                "or name another folder for the numbers"
            )
        if settings.numbers:
            folder = Path(bpy.path.abspath(settings.numbers))
        else:
            self._temporary = tempfile.TemporaryDirectory(prefix="omma-render-")
            folder = Path(self._temporary.name)
        try:
            stem = bpy.path.clean_name(f"{context.scene.name}-{camera.name}")
            exported = export_scene(
                context, folder / f"{stem}.glb", animations=False, only=camera.data
            )
            self.warnings = exported.warnings
            self.outputs = [str(folder / f"{stem}.npy")]
            options = {
                "samples": eye.samples if eye.is_compound else settings.camera_samples,
                "seed": settings.seed,
            }
            if eye.is_compound:
                options["kernel"] = eye.kernel
                options["standard_error"] = settings.standard_error
            self.command = ""
            if settings.light == "none":
                self.command = _command(exported.files[0], camera.name, options, self.outputs)
            elif settings.light == "sky":
                angles = ("sun_elevation_deg", "sun_azimuth_deg")
                light = {name: getattr(settings, name) for name in angles}
                options["light"] = {"kind": "sky", **light}
            else:
                options["light"] = {"kind": "world"}
            self._picture = tempfile.NamedTemporaryFile(suffix=".npy", delete=False)  # noqa: SIM115
            self._picture.close()
            if eye.is_compound and eye.projection != FIELD:
                options["projection"] = eye.projection
            self._work = Work(
                python,
                "render",
                scene=str(exported.files[0]),
                outputs=self.outputs,
                picture=self._picture.name,
                camera=camera.name,
                width=settings.width,
                **options,
            )
        except BaseException:
            self._clean()
            raise

    @property
    def progress(self) -> tuple[str, float | None]:
        """What is being done, and its finished share."""
        return self._work.stage, self._work.fraction

    def poll(self) -> bool:
        return self._work.poll()

    def finish(self) -> tuple[bpy.types.Image, dict]:
        """Waits where it must; the picture in Blender, and what omma said of the render.

        Raises:
            OmmaError: what omma said went wrong.
        """
        try:
            done = self._work.result()
            self.warnings += [_in_blenders_words(one) for one in self._work.warnings]
            return show_picture(self.camera, np.load(self._picture.name)), done
        finally:
            self._clean()

    def stop(self) -> None:
        """Ends omma; nothing stays but what was exported to a folder that was named."""
        self._work.close()
        self._clean()

    def _clean(self) -> None:
        if hasattr(self, "_picture"):
            Path(self._picture.name).unlink(missing_ok=True)
        if self._temporary is not None:
            self._temporary.cleanup()


def _in_blenders_words(warning: str) -> str:
    if "without a light surfaces show their own colours" in warning:
        return (
            "Nothing is lit: surfaces show their base colour and what they emit. To light them "
            "choose Properties > Output > Omma > Light"
        )
    return warning


def _command(scene: Path, camera: str, options: dict, outputs: list[str]) -> str:
    """The command that renders the same numbers from the exported scene."""
    words = ["omma", "render", str(scene), "--camera", camera]
    for name, value in options.items():
        if value is True:
            words.append(f"--{name.replace('_', '-')}")
        elif value is not False:
            words += [f"--{name.replace('_', '-')}", str(value)]
    for output in outputs:
        words += ["-o", output]
    return shlex.join(words)


def show_picture(camera: str, seen: np.ndarray) -> bpy.types.Image:
    """A picture in linear floats, (height, width, 3), as an image of Blender's, transparent where
    nothing looks. That of the same camera is replaced."""
    height, width = seen.shape[:2]
    name = PICTURE.format(camera)
    image = bpy.data.images.get(name)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    image.alpha_mode = "STRAIGHT"
    rgba = np.zeros((height, width, 4), np.float32)
    looked_at = np.isfinite(seen[..., :3]).all(axis=-1)
    rgba[looked_at, :3] = seen[looked_at, :3]
    rgba[looked_at, 3] = 1
    image.pixels.foreach_set(np.ascontiguousarray(rgba[::-1]).ravel())
    image.update()
    image.pack()  # so that it is saved with the file
    return image


class OMMA_OT_render(bpy.types.Operator):
    """Render what this camera's eye sees by Omma, into the image editor"""

    bl_idname = "omma.render"
    bl_label = "Render with Omma"

    camera: bpy.props.StringProperty(
        name="Camera", description="Empty: the active camera object, else the scene's camera"
    )

    def _start(self, context: bpy.types.Context) -> Render:
        if self.camera:
            camera = context.scene.objects.get(self.camera)
            if camera is None:
                raise OmmaError(f"There is no camera {self.camera} in this scene")
        else:
            active = context.view_layer.objects.active
            camera = active if active and active.type == "CAMERA" else context.scene.camera
        return Render(context, camera)

    def _finish(self, context: bpy.types.Context, render: Render) -> set[str]:
        try:
            image, done = render.finish()
        except OmmaError as error:
            return tell(self, error)
        for warning in render.warnings:
            self.report({"WARNING"}, warning)
        _show_in_editor(context, image)
        what = f"{done['ommatidia']:,} ommatidia" if done["ommatidia"] else "a picture"
        where = f", {done['outputs'][0]}" if context.scene.omma_render.numbers else ""
        self.report({"INFO"}, f"{what}, {done['rays']:,} rays, {done['seconds']:.2f} s{where}")
        if render.command and context.scene.omma_render.numbers:
            print(render.command)  # to the console, for whoever wants to go on without Blender
        return {"FINISHED"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Waits for the picture: where there is no window, and for scripts."""
        try:
            render = self._start(context)
        except OmmaError as error:
            return tell(self, error)
        return self._finish(context, render)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        try:
            self._render = self._start(context)
        except OmmaError as error:
            return tell(self, error)
        manager = context.window_manager
        self._timer = manager.event_timer_add(0.1, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self._end_modal(context)
            self._render.stop()
            self.report({"INFO"}, "Omma: stopped")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self._render.poll():
            self._end_modal(context)
            return self._finish(context, self._render)
        stage, fraction = self._render.progress
        share = "" if fraction is None else f" {100 * fraction:.0f} %"
        context.workspace.status_text_set(f"Omma: {stage}{share}    Esc: stop")
        context.window_manager.progress_update(100 * (fraction or 0))
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends, or another file is opened."""
        self._end_modal(context)
        self._render.stop()

    def _end_modal(self, context: bpy.types.Context) -> None:
        context.workspace.status_text_set(None)
        context.window_manager.progress_end()
        context.window_manager.event_timer_remove(self._timer)


def _show_in_editor(context: bpy.types.Context, image: bpy.types.Image) -> None:
    """In the image editors that are open; else where Blender shows its own renders."""
    if bpy.app.background or context.window is None:
        return
    if not _image_editors(context):
        with suppress(RuntimeError):  # then the picture waits among Blender's images
            bpy.ops.render.view_show("INVOKE_DEFAULT")
    for editor in _image_editors(context):
        editor.image = image


def _image_editors(context: bpy.types.Context) -> list[bpy.types.SpaceImageEditor]:
    return [
        area.spaces.active
        for window in context.window_manager.windows
        for area in window.screen.areas
        if area.type == "IMAGE_EDITOR"
    ]


_register, _unregister = bpy.utils.register_classes_factory((OMMA_OT_render,))


def _draw_render(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.operator(OMMA_OT_render.bl_idname)


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_render.append(_draw_render)


def unregister() -> None:
    bpy.types.TOPBAR_MT_render.remove(_draw_render)
    _unregister()
