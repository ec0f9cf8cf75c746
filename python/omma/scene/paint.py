"""What solids and walls look like, as it is given: a colour or a picture."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omma._core import Error, Image, Instance, Material, Mesh, Scene, Texture
from omma.base.arguments import array_of
from omma.base.orientation import upright_picture
from omma.base.pixels import check_picture

# A linear colour (r, g, b) or (r, g, b, a); a `Material` without textures; or a picture: an
# `Image`, an array (height, width, 3 or 4), or the path of a file, turned as its EXIF says.
Paint = Any

Surface = tuple[NDArray[np.float64], NDArray[np.integer], NDArray[np.float64]]


def painted_scene(
    surfaces: list[tuple[str, Surface, Paint]],
    name: str,
    center_m: Any,
    *,
    double_sided: bool = False,
    wrap_u: str = "clamp_to_edge",
    sharp: bool = False,
) -> Scene:
    """A scene of one thing, around ``center_m``, that is made of several surfaces.

    Args:
        surfaces: of each what its paint is called in errors, its triangles as (positions (V, 3), m,
            triangles (T, 3), texture coordinates (V, 2)), and the paint.
        wrap_u: how pictures go on sideways: "repeat" where they come round or several times.
        sharp: whether pixels of pictures have hard edges.
    """
    meshes: list[Mesh] = []
    materials: list[Material] = []
    images: list[Image] = []
    for argument, (positions, triangles, coordinates), paint in surfaces:
        image = None
        if isinstance(paint, Material):
            materials.append(_without_textures(paint, argument))
        else:
            color, image = color_or_image(paint, argument)
            if image is not None:
                images.append(image)
            materials.append(
                Material(
                    name,
                    base_color=color,
                    base_color_texture=None if image is None else len(images) - 1,
                    alpha_mode="blend" if color[3] < 1 else "opaque",
                    double_sided=double_sided,
                )
            )
        # What is beyond the range of float32 becomes infinite, which a mesh refuses.
        with np.errstate(over="ignore"):
            mesh = Mesh(
                positions,
                triangles,
                name=name,
                texture_coordinates=None if image is None else coordinates,
                material=len(materials) - 1,
            )
        meshes.append(mesh)
    world_from_mesh = np.eye(4)
    world_from_mesh[:3, 3] = point(center_m, "center_m")
    return Scene(
        meshes=meshes,
        # One node: all of it moves together.
        instances=[
            Instance(number, world_from_mesh, name=name, node=0) for number in range(len(meshes))
        ],
        materials=materials,
        images=images,
        textures=[
            Texture(number, wrap_u, "clamp_to_edge", "nearest" if sharp else "linear")
            for number in range(len(images))
        ],
    )


def point(value: Any, name: str) -> NDArray[np.float64]:
    """Three finite numbers."""
    found = array_of(value, name, (3,))
    if not np.isfinite(found).all():
        raise Error(f"{name}: expected three finite numbers, found {found.tolist()}")
    return found


def _without_textures(material: Material, name: str) -> Material:
    for attribute in dir(material):
        if attribute.endswith("_texture") and getattr(material, attribute) is not None:
            raise Error(
                f"{name}: expected a material without textures, as there are no images beside it; "
                f"found {attribute}. Put it into the scene: replace(materials=, images=, "
                "textures=)"
            )
    return material


def color_or_image(paint: Paint, name: str) -> tuple[tuple[float, ...], Image | None]:
    """The linear RGBA that a paint multiplies, and the image where it is a picture."""
    white = (1.0, 1.0, 1.0, 1.0)
    if isinstance(paint, Image):
        check_picture(paint.pixels, name)
        return white, paint
    if isinstance(paint, (str, os.PathLike)):
        image = upright_picture(paint)
        check_picture(image.pixels, f"{name}: {os.fsdecode(paint)}")
        return white, image
    given = array_of(paint, name, dtype=None)
    if given.ndim in (2, 3):
        try:
            made = Image(given)
        except Error as error:
            raise Error(f"{name}: {error}") from None
        check_picture(made.pixels, name)
        return white, made
    if given.shape not in ((3,), (4,)):
        raise Error(
            f"{name}: expected a colour (r, g, b), a material, or a picture of shape (height, "
            f"width, 3 or 4), or (height, width) of greys, found shape {given.shape}"
        )
    color = [float(value) for value in given]
    if not (np.isfinite(color).all() and min(color) >= 0):
        raise Error(f"{name}: expected a colour of finite numbers from 0, found {color}")
    return (*color, *[1.0] * (4 - len(color))), None
