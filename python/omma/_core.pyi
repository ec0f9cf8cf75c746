"""The compiled engine behind the package `omma`; use it through `omma`."""

from collections.abc import Callable, Iterable, Sequence
import os
from typing import Any, overload

import numpy
import numpy.typing

import omma.rendering.moves


# Generated, not written; after a change to the bindings:
# python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

__version__: str

class Error(RuntimeError):
    """
    Anything wrong with an input: a file, an argument, a device.

    The message names the file or argument, the place in it, what was expected and what was
    found.
    """

class WholeFiles:
    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self) -> None: ...

    def open(self, path: str | os.PathLike[str]) -> int: ...

    def open_kept(self, path: str | os.PathLike[str], bytes: int) -> int: ...

    def write(self, file: int, data: object) -> None: ...

    def temporary(self, file: int) -> str:
        """
        Where its bytes are meanwhile, for libraries that write to a path themselves.
        """

    def close(self, file: int) -> None: ...

    def sync(self, file: int) -> int: ...

    def finish(self) -> None: ...

    def discard(self) -> None: ...

def check_target(path: str | os.PathLike[str]) -> None: ...

def kept_bytes(path: str | os.PathLike[str]) -> int: ...

def read_file(path: str | os.PathLike[str]) -> bytes:
    """
    All bytes of a regular file; `omma.Error` where it is none or cannot be read.
    """

def left_behind(paths: Sequence[str | os.PathLike[str]]) -> list[tuple[str, int]]:
    """
    What runs that were killed left of files with these names: names and sizes in bytes.
    """

class Background:
    """
    Radiance of a ray that meets no surface, instead of the scene's own background.

    Make one with ``constant``, ``simple_sky``, ``test_pattern`` or ``image`` and pass it to
    `Renderer`.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @staticmethod
    def constant(color: numpy.typing.ArrayLike) -> Background:
        """
        The same linear radiance ``(r, g, b)`` in every direction.

        Raises `omma.Error` where it is not three finite numbers.
        """

    @staticmethod
    def simple_sky() -> Background:
        """
        CompoundRay's ``simple_sky``: (143, 179, 203)/255*0.8 at the horizon and below, linear
        in elevation to (1, 31, 117)/255 at the zenith; taken as linear radiance.
        """

    @staticmethod
    def test_pattern() -> Background:
        """
        CompoundRay's ``default_background``: red grows with azimuth, green with elevation,
        black where a component of the direction is under 0.01.
        """

    @staticmethod
    def image(image: str | os.PathLike[str] | numpy.typing.ArrayLike) -> Background:
        """
        An equirectangular image: forward (-Z) in the middle, +X to the right of it, +Y
        at the top.

        A path to a PNG, JPEG or WebP (8 and 16 bit: sRGB), Radiance HDR or OpenEXR file
        (float: linear radiance, HDR divided by its EXPOSURE; OpenEXR has channels R, G and B,
        or Y alone), turned as its EXIF says, or an array of shape (height, width, 3 or 4)
        or, of greys, (height, width): uint8 is sRGB, float is linear radiance. Between the
        middles of pixels it is interpolated, which takes contrast from what is a few pixels
        wide.

        Raises `omma.Error` where the file or the array is not such an image.
        Warns `UserWarning` where it is not twice as wide as high.
        """

    @property
    def type(self) -> str:
        """'constant', 'simple_sky', 'test_pattern' or 'image'."""

    @property
    def color(self, /) -> tuple[float, float, float]:
        """Linear radiance (r, g, b) of a constant background."""

    @property
    def pixels(self, /) -> numpy.typing.NDArray[Any] | None:
        """
        RGBA of an image, read-only: (height, width, 4), uint8 (sRGB) or float32 (linear).
        """

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Background: ...

    def __deepcopy__(self, memo: object) -> Background: ...

class Camera:
    """
    A camera node of a scene. It looks along its -Z, +Y is up.

    Its type is 'perspective' (vertical field of view ``yfov_rad``, width over height
    ``aspect_ratio``, 0: any), 'orthographic' (half extents ``xmag_m`` and ``ymag_m``),
    'panoramic', or 'compound', of which ``extras`` names the eye ("compound-structure", an
    `.eye` file, and "compound-projection"). What is nearer than ``znear_m`` or farther than
    ``zfar_m`` is seen all the same: the two are for other programs.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, name: str = '', *, type: str = 'perspective', world_from_camera: numpy.typing.ArrayLike | None = None, yfov_rad: float = 1.0, aspect_ratio: float = 0.0, xmag_m: float = 1.0, ymag_m: float = 1.0, znear_m: float = 0.01, zfar_m: float = 1000.0, extras: Any = None, data_name: str = '') -> None: ...

    @property
    def name(self) -> str:
        """Name of the node (of the camera where the node has none)."""

    @property
    def type(self) -> str:
        """'perspective', 'orthographic', 'panoramic' or 'compound'."""

    @property
    def world_from_camera(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """The node's whole transform, its scale too: (4, 4), m."""

    @property
    def extras(self, /) -> Any:
        """The camera's extras in the glTF file, {} where there are none."""

    @property
    def compound_structure(self) -> str:
        """
        The `.eye` file that the camera's extras name, '' where they name none.
        """

    @property
    def compound_projection(self) -> str:
        """
        The projection of its eye that the camera's extras name, '' where they name none.
        """

    @property
    def yfov_rad(self) -> float:
        """Vertical field of view; perspective only."""

    @property
    def aspect_ratio(self) -> float:
        """Width over height, 0 where not given; perspective only."""

    @property
    def xmag_m(self) -> float:
        """Horizontal half extent; orthographic only."""

    @property
    def ymag_m(self) -> float:
        """Vertical half extent; orthographic only."""

    @property
    def znear_m(self) -> float: ...

    @property
    def zfar_m(self) -> float:
        """0 where the file gives none."""

    @property
    def data_name(self) -> str:
        """Name of the camera itself, by which it is found too."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Camera: ...

    def __deepcopy__(self, memo: object) -> Camera: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Camera:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

max_picture_extent: int = 32768

def picture_size(camera: Camera, width: int, height: int) -> tuple[int, int]: ...

def render_camera(world: World, camera: Camera, picture: numpy.typing.NDArray[numpy.float32], samples: int, seed: int, progress: Callable[[float], object] | None) -> None: ...

class Spectrum:
    """
    Values at wavelengths, linear between: a reflectance, a transmittance, the power of a lamp.

    Two to 10,000 wavelengths from 100 to 5,000 nm, ascending, and as many values that are not
    negative.

    Raises `omma.Error`, which names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, wavelength_nm: numpy.typing.ArrayLike, value: numpy.typing.ArrayLike) -> None: ...

    @property
    def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(K,), nm, ascending; read-only."""

    @property
    def value(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(K,); read-only."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Spectrum: ...

    def __deepcopy__(self, memo: object) -> Spectrum: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Spectrum:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Image:
    """
    A picture in memory, row 0 at the top.

    Made from an array of shape (height, width, 3 or 4) or, of greys, (height, width), where
    uint8 is sRGB and float linear, or from the path of a PNG, JPEG, WebP, Radiance HDR or
    OpenEXR file. Alpha is linear always.

    Raises `omma.Error` where the array or the file is not such an image.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, pixels: str | os.PathLike[str] | numpy.typing.ArrayLike, name: str = '') -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def pixels(self, /) -> numpy.typing.NDArray[Any]:
        """RGBA, read-only: (height, width, 4), uint8 (sRGB) or float32 (linear)."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Image: ...

    def __deepcopy__(self, memo: object) -> Image: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Image:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Texture:
    """
    How a picture is read: beyond its edges it repeats, mirrored or not, or goes on as at the
    edge ('repeat', 'mirrored_repeat', 'clamp_to_edge'); between its pixels it is interpolated
    ('linear') or not ('nearest'). ``image`` is an index into the scene's images.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, image: int, wrap_u: str = 'repeat', wrap_v: str = 'repeat', filter: str = 'linear') -> None: ...

    @property
    def image(self) -> int:
        """Index into the scene's images."""

    @property
    def wrap_u(self) -> str: ...

    @property
    def wrap_v(self) -> str: ...

    @property
    def filter(self) -> str: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Texture: ...

    def __deepcopy__(self, memo: object) -> Texture: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Texture:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class TextureUse:
    """
    A texture as a material uses it: an index into the scene's textures, which of a mesh's two
    sets of texture coordinates it is read with, and what becomes of these before: offset +
    rotation · scale · coordinate.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, texture: int, texcoord_set: int = 0, offset: numpy.typing.ArrayLike = (0.0, 0.0), scale: numpy.typing.ArrayLike = (1.0, 1.0), rotation_rad: float = 0.0) -> None: ...

    @property
    def texture(self) -> int:
        """Index into the scene's textures."""

    @property
    def texcoord_set(self) -> int:
        """0 or 1."""

    @property
    def offset(self, /) -> tuple[float, float]: ...

    @property
    def scale(self, /) -> tuple[float, float]: ...

    @property
    def rotation_rad(self) -> float: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> TextureUse: ...

    def __deepcopy__(self, memo: object) -> TextureUse: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> TextureUse:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class ExtraReflectance:
    """
    More reflectance of a surface than red, green and blue say, as a petal's ultraviolet guide:
    the channels of an image, linear, are amounts of up to three spectra, which add to what the
    base colour gives. A spectrum (`omma.light.Spectrum`, 0 to 1) is 0 beyond its wavelengths;
    None: the channel says nothing.

    Raises `omma.Error`, which names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, texture: int | TextureUse, spectra: Sequence[Spectrum | None]) -> None: ...

    @property
    def texture(self) -> TextureUse: ...

    @property
    def spectra(self, /) -> tuple[Spectrum | None, Spectrum | None, Spectrum | None]:
        """Of the channels red, green and blue."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> ExtraReflectance: ...

    def __deepcopy__(self, memo: object) -> ExtraReflectance: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> ExtraReflectance:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class BoundaryTable:
    """
    How a surface reflects by wavelength and angle, as stacks of thin films and metals do
    (`LayerStack` makes such tables).

    wavelength_nm: (W,), 2 to 10,000 from 100 to 5,000 nm, ascending.
    mueller: (W, C, 3), at C cosines of the angle of incidence, even from 0 to 1: with field
    amplitudes r_s and r_p across the plane of incidence and in it,
    a = (|r_s|² + |r_p|²) / 2, the reflectance of unpolarised light,
    b = (|r_s|² - |r_p|²) / 2 and c = Re(r_s r_p*), by which at normal incidence c = -a.
    Linear between, and beyond its wavelengths as at the last one.

    Raises `omma.Error`, which names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, wavelength_nm: numpy.typing.ArrayLike, mueller: numpy.typing.ArrayLike) -> None: ...

    @property
    def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(W,), nm, ascending; read-only."""

    @property
    def mueller(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(W, C, 3): a, b and c; read-only."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> BoundaryTable: ...

    def __deepcopy__(self, memo: object) -> BoundaryTable: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> BoundaryTable:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Material:
    """
    What a surface looks like: base colour × texture × the mesh's vertex colours, and emission
    × its texture beside that. All factors are linear.

    ``alpha_mode`` 'opaque' takes no notice of alpha, 'mask' cuts where it is under
    ``alpha_cutoff``, 'blend' lets light through. Back faces are seen only where
    ``double_sided``. ``unlit`` says that its base colour is its radiance, whatever falls on
    it; in a world with a light it reflects as matter of that colour.

    The others say how it scatters light, as glTF 2.0 and its extensions do, and count in a
    world with a light only. By default it is rough matter, not the metal that glTF's own
    defaults are. ``ior`` is the index of refraction; ``specular`` (and its colour) a factor of
    the reflection by it; ``transmission`` what goes straight through, or bends
    into a volume where ``thickness_m`` is above 0 (how far above does not count): then meshes
    bound it, seen from outside by their front, and it absorbs by ``attenuation_color`` and
    ``attenuation_distance_m`` or, in their place, ``absorption_per_m``, a spectrum in m⁻¹;
    ``diffuse_transmission``
    what leaves a thin sheet scattered on its other side; ``clearcoat`` a second surface on it.
    ``reflectance`` and ``transmittance`` are spectra (`omma.light.Spectrum`, 0 to 1, together
    at most 1) in place of what RGB stands for, where the base colour has the relative
    luminance ``spectral_luminance``, and proportional to it elsewhere. ``extra_reflectance``
    adds an image of spectra, ``emission`` is the spectrum of what shines. ``boundary`` is how its
    metal, the part ``metallic`` of it, reflects by wavelength and angle, in place of the base
    colour (`LayerStack`); that polarises.

    Raises `omma.Error`, which names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, name: str = '', *, base_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0, 1.0), base_color_texture: int | TextureUse | None = None, emissive: numpy.typing.ArrayLike = (0.0, 0.0, 0.0), emissive_texture: int | TextureUse | None = None, alpha_mode: str = 'opaque', alpha_cutoff: float = 0.5, double_sided: bool = False, unlit: bool = False, metallic: float = 0.0, roughness: float = 1.0, metallic_roughness_texture: int | TextureUse | None = None, normal_texture: int | TextureUse | None = None, normal_scale: float = 1.0, ior: float = 1.5, specular: float = 1.0, specular_texture: int | TextureUse | None = None, specular_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), specular_color_texture: int | TextureUse | None = None, transmission: float = 0.0, transmission_texture: int | TextureUse | None = None, thickness_m: float = 0.0, attenuation_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), attenuation_distance_m: float | None = None, absorption_per_m: Spectrum | None = None, diffuse_transmission: float = 0.0, diffuse_transmission_factor_texture: int | TextureUse | None = None, diffuse_transmission_color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), diffuse_transmission_texture: int | TextureUse | None = None, clearcoat: float = 0.0, clearcoat_texture: int | TextureUse | None = None, clearcoat_roughness: float = 0.0, clearcoat_roughness_texture: int | TextureUse | None = None, clearcoat_normal_texture: int | TextureUse | None = None, clearcoat_normal_scale: float = 1.0, reflectance: Spectrum | None = None, transmittance: Spectrum | None = None, spectral_luminance: float = 1.0, extra_reflectance: ExtraReflectance | None = None, emission: Spectrum | None = None, boundary: BoundaryTable | None = None) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def base_color(self, /) -> tuple[float, float, float, float]:
        """Linear factor, RGBA."""

    @property
    def base_color_texture(self, /) -> TextureUse | None: ...

    @property
    def emissive(self, /) -> tuple[float, float, float]:
        """Linear radiance, RGB."""

    @property
    def emissive_texture(self, /) -> TextureUse | None: ...

    @property
    def alpha_mode(self) -> str: ...

    @property
    def alpha_cutoff(self) -> float: ...

    @property
    def double_sided(self) -> bool: ...

    @property
    def unlit(self) -> bool: ...

    @property
    def metallic(self) -> float: ...

    @property
    def roughness(self) -> float: ...

    @property
    def metallic_roughness_texture(self, /) -> TextureUse | None:
        """Metallic in blue, roughness in green; linear."""

    @property
    def normal_texture(self, /) -> TextureUse | None:
        """Linear."""

    @property
    def normal_scale(self) -> float: ...

    @property
    def ior(self) -> float: ...

    @property
    def specular(self) -> float: ...

    @property
    def specular_texture(self, /) -> TextureUse | None:
        """A factor of ``specular``: its alpha."""

    @property
    def specular_color(self, /) -> tuple[float, float, float]: ...

    @property
    def specular_color_texture(self, /) -> TextureUse | None:
        """sRGB."""

    @property
    def transmission(self) -> float: ...

    @property
    def transmission_texture(self, /) -> TextureUse | None:
        """A factor of ``transmission``: its red; linear."""

    @property
    def thickness_m(self) -> float: ...

    @property
    def attenuation_color(self, /) -> tuple[float, float, float]:
        """Linear, what is left of white after ``attenuation_distance_m``."""

    @property
    def attenuation_distance_m(self, /) -> float | None:
        """None: nothing is absorbed."""

    @property
    def absorption_per_m(self, /) -> Spectrum | None:
        """Of the volume, m⁻¹."""

    @property
    def diffuse_transmission(self) -> float: ...

    @property
    def diffuse_transmission_factor_texture(self, /) -> TextureUse | None:
        """A factor of ``diffuse_transmission``: its alpha."""

    @property
    def diffuse_transmission_color(self, /) -> tuple[float, float, float]: ...

    @property
    def diffuse_transmission_texture(self, /) -> TextureUse | None:
        """Of the colour, sRGB."""

    @property
    def clearcoat(self) -> float: ...

    @property
    def clearcoat_texture(self, /) -> TextureUse | None:
        """A factor of ``clearcoat``: its red; linear."""

    @property
    def clearcoat_roughness(self) -> float: ...

    @property
    def clearcoat_roughness_texture(self, /) -> TextureUse | None:
        """A factor of ``clearcoat_roughness``: its green; linear."""

    @property
    def clearcoat_normal_texture(self, /) -> TextureUse | None:
        """
        Linear. Without it a coat has the mesh's normals, whatever ``normal_texture``.
        """

    @property
    def clearcoat_normal_scale(self) -> float: ...

    @property
    def reflectance(self, /) -> Spectrum | None: ...

    @property
    def transmittance(self, /) -> Spectrum | None: ...

    @property
    def spectral_luminance(self) -> float: ...

    @property
    def extra_reflectance(self, /) -> ExtraReflectance | None: ...

    @property
    def emission(self, /) -> Spectrum | None:
        """
        W m⁻² sr⁻¹ nm⁻¹ where the emissive factor times texture has luminance 1.
        """

    @property
    def boundary(self, /) -> BoundaryTable | None: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Material: ...

    def __deepcopy__(self, memo: object) -> Material: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Material:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Mesh:
    """
    Triangles of one material, in a frame of their own.

    Positions (V, 3), m, and the three vertices of each triangle (T, 3), counter-clockwise as
    seen from in front. For each vertex, where there are any: normals (V, 3), none of
    them zero, which count in a world with a light; texture coordinates (V, 2), (0, 0) the upper left corner of the picture and
    (1, 1) the lower right one; linear colours (V, 3 or 4). ``material`` is an index into the
    scene's materials, None white.

    Raises `omma.Error` where sizes do not go together, a triangle has a vertex that is not
    there, or a number is not finite.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, positions_m: numpy.typing.ArrayLike, triangles: numpy.typing.ArrayLike, *, name: str = '', normals: numpy.typing.ArrayLike | None = None, texture_coordinates: numpy.typing.ArrayLike | None = None, second_texture_coordinates: numpy.typing.ArrayLike | None = None, colors: numpy.typing.ArrayLike | None = None, material: int | None = None) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(V, 3), m."""

    @property
    def triangles(self, /) -> numpy.typing.NDArray[numpy.uint32]:
        """(T, 3)."""

    @property
    def normals(self, /) -> numpy.typing.NDArray[numpy.float32] | None:
        """(V, 3), or None."""

    @property
    def texture_coordinates(self, /) -> numpy.typing.NDArray[numpy.float32] | None:
        """(V, 2), or None."""

    @property
    def second_texture_coordinates(self, /) -> numpy.typing.NDArray[numpy.float32] | None:
        """(V, 2), or None: set 1 of a `TextureUse`."""

    @property
    def colors(self, /) -> numpy.typing.NDArray[numpy.float32] | None:
        """Linear RGBA (V, 4), or None."""

    @property
    def material(self, /) -> int | None:
        """Index into the scene's materials; None: white."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Mesh: ...

    def __deepcopy__(self, memo: object) -> Mesh: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Mesh:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Instance:
    """
    A mesh placed in the world: an index into the scene's meshes, where it is
    (``world_from_mesh`` (4, 4), m; None: where its positions say), and the name it is moved
    by. Instances of one ``node`` move together and must be in one place; None: it moves alone.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, mesh: int, world_from_mesh: numpy.typing.ArrayLike | None = None, *, name: str = '', node: int | None = None) -> None: ...

    @property
    def mesh(self) -> int:
        """Index into the scene's meshes."""

    @property
    def world_from_mesh(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(4, 4), m."""

    @property
    def name(self) -> str: ...

    @property
    def node(self, /) -> int | None:
        """Those with the same one move together; None: it moves alone."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Instance: ...

    def __deepcopy__(self, memo: object) -> Instance: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> Instance:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class HitBox:
    """
    A closed surface that marks a region and is never drawn: positions (V, 3), m, triangles
    (T, 3) and where it is, ``world_from_mesh`` (4, 4), m.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, name: str, positions_m: numpy.typing.ArrayLike, triangles: numpy.typing.ArrayLike, world_from_mesh: numpy.typing.ArrayLike | None = None) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(V, 3), m."""

    @property
    def triangles(self, /) -> numpy.typing.NDArray[numpy.uint32]:
        """(T, 3)."""

    @property
    def world_from_mesh(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(4, 4), m."""

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> HitBox: ...

    def __deepcopy__(self, memo: object) -> HitBox: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> HitBox:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class SplatCloud:
    """
    Gaussian splats (Kerbl et al. 2023, doi:10.1145/3592433): a place as photographs have it, N
    soft ellipsoids, each with an opacity and a colour that depends on from where it is seen.
    They hold the light of their capture, and nothing lights them.

    ``positions_m`` (N, 3) are their middles, ``scales_m`` (N, 3), m, standard deviations along
    their own axes, which ``rotations`` (N, 4), unit quaternions x, y, z, w, turn;
    ``opacities`` (N,), 0 to 1; ``harmonics`` (N, 1, 4, 9 or 16, C), spherical harmonics of
    degree 0 to 3 by channel, in the order and with the signs of Kerbl et al.: a colour is 0.5
    and their sum, no less than 0. Channels are RGB; ``bands_nm`` (C, 2) names others, 3 to 16
    bands from one wavelength to another, in which a lit world sees them; one that is not lit
    shows the first three as RGB. ``color_space``, 'srgb' or 'linear', is that in which they were
    trained and are composited; ``direction`` is what colours depend on: 'center', from where a
    ray starts to the middle of a splat, as Kerbl et al. have it, or 'ray', its own direction,
    as Moenne-Loccoz et al. 2024 (doi:10.1145/3687934). ``white`` (C,) is what a colour of 1 is
    in linear numbers, all 1 where it is None; `omma.scene.calibrate` finds it.
    ``world_from_splats`` (4, 4) places them, m.

    Raises `omma.Error`, which names the splat, where sizes do not go together or a number is
    not what it stands for.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, positions_m: numpy.typing.ArrayLike, scales_m: numpy.typing.ArrayLike, rotations: numpy.typing.ArrayLike, opacities: numpy.typing.ArrayLike, harmonics: numpy.typing.ArrayLike, *, color_space: str = 'srgb', direction: str = 'center', white: numpy.typing.ArrayLike | None = None, bands_nm: numpy.typing.ArrayLike | None = None, world_from_splats: numpy.typing.ArrayLike | None = None, name: str = '') -> None: ...

    @property
    def positions_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(N, 3), m, in their own frame."""

    @property
    def scales_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(N, 3), m."""

    @property
    def rotations(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(N, 4), x, y, z, w."""

    @property
    def opacities(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(N,), 0 to 1."""

    @property
    def harmonics(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """(N, 1, 4, 9 or 16, C)."""

    @property
    def color_space(self) -> str: ...

    @property
    def direction(self) -> str: ...

    @property
    def white(self, /) -> tuple[float, ...]:
        """(C,), linear, what a colour of 1 is."""

    @property
    def bands_nm(self, /) -> tuple[tuple[float, float], ...] | None:
        """(C, 2), nm, or None: RGB."""

    @property
    def world_from_splats(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(4, 4), m."""

    @property
    def name(self) -> str: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> SplatCloud: ...

    def __deepcopy__(self, memo: object) -> SplatCloud: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> SplatCloud:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Animation:
    """An animation of a scene's file."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @property
    def name(self) -> str:
        """As the file has it; '' where it has none."""

    @property
    def duration_s(self) -> float:
        """When its last key is, s."""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> Animation: ...

    def __deepcopy__(self, memo: object) -> Animation: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

class Rig:
    """
    How things of a scene move and change their shape: nodes, bones, morph targets and
    animations, as its file says. It goes with the scene's meshes, nodes and cameras:
    `Scene.replace` keeps it.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self) -> None:
        """One in which nothing moves."""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> Rig: ...

    def __deepcopy__(self, memo: object) -> Rig: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

def placed_rig(rig: Rig, world_from_scene: numpy.typing.ArrayLike) -> Rig: ...

def with_scaled_cameras(rig: Rig, factor: float) -> Rig:
    """The same rig with cameras, and so eyes, that are larger by a factor."""

def joined_rig(rig: Rig, other: Rig, meshes: int, cameras: int, nodes: int) -> Rig:
    """
    The rig of two scenes, where so many meshes, cameras and nodes come before the second's.
    """

class PunctualLight:
    """
    A lamp without size, which shines in a world with a light: 'point' to all sides, 'spot' in a
    cone along its -Z, 'directional' along its -Z from afar, as KHR_lights_punctual has them.

    ``color`` is linear, ``intensity`` in cd, of a directional one in lx; ``spectrum`` in
    W sr⁻¹ nm⁻¹, of a directional one in W m⁻² nm⁻¹, stands in place of both. ``range_m`` is
    where it ends, 0 nowhere. A spot has full intensity within ``inner_cone_rad`` of its axis
    and none beyond ``outer_cone_rad``. ``world_from_light`` is (4, 4), m.

    Raises `omma.Error`, which names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, name: str = '', *, type: str = 'point', color: numpy.typing.ArrayLike = (1.0, 1.0, 1.0), intensity: float = 1.0, range_m: float = 0.0, inner_cone_rad: float = 0.0, outer_cone_rad: float = 0.7853981633974483, world_from_light: numpy.typing.ArrayLike | None = None, spectrum: Spectrum | None = None) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def type(self) -> str: ...

    @property
    def color(self, /) -> tuple[float, float, float]: ...

    @property
    def intensity(self) -> float: ...

    @property
    def range_m(self) -> float: ...

    @property
    def inner_cone_rad(self) -> float: ...

    @property
    def outer_cone_rad(self) -> float: ...

    @property
    def world_from_light(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """(4, 4), m."""

    @property
    def spectrum(self, /) -> Spectrum | None: ...

    def __hash__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> PunctualLight: ...

    def __deepcopy__(self, memo: object) -> PunctualLight: ...

    def __reduce__(self) -> tuple[Any, ...]: ...

    def replace(self, **changes: Any) -> PunctualLight:
        """
        Another one that differs in what is given by keyword, as for making one.
        """

class Scene:
    """
    A scene: meshes, instances, materials, textures, cameras, lamps, Gaussian splats and a
    background, in glTF's world frame (right-handed, +Y up, metres). Read-only.

    `omma.load_scene` reads one; here one is made of its parts, which are in `omma.scene`. They
    refer to each other by index: an instance to its mesh, a mesh to its material, a material
    to textures, a texture to its image. Without ``instances`` each mesh is placed once, as its
    positions say; without ``textures`` there is one for each image. ``Scene()`` is empty:
    nothing but background, black unless one is given.

    Raises `omma.Error`, which names the part, where an index leads nowhere, sizes do not go
    together or a number is not finite.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, *, meshes: Iterable[Mesh] = (), instances: Iterable[Instance] | None = None, materials: Iterable[Material] = (), textures: Iterable[Texture] | None = None, images: Iterable[Image] = (), cameras: Iterable[Camera] = (), hit_boxes: Iterable[HitBox] = (), lights: Iterable[PunctualLight] = (), splats: Iterable[SplatCloud] = (), background: Background | None = None, color_rule: str = 'gltf', rig: Rig | None = None) -> None: ...

    @property
    def rig(self, /) -> Rig | None:
        """How its things move in time; None: nothing does."""

    @property
    def animations(self, /) -> list[Animation]:
        """Of the file, in its order: what `World.at` can show."""

    @property
    def meshes(self, /) -> list[Mesh]:
        """
        Meshes stored, one for each glTF primitive; their arrays are the scene's own memory.
        """

    @property
    def instances(self) -> list[Instance]:
        """Meshes placed in the world."""

    @property
    def materials(self) -> list[Material]: ...

    @property
    def textures(self) -> list[Texture]: ...

    @property
    def images(self, /) -> list[Image]: ...

    @property
    def hit_boxes(self, /) -> list[HitBox]:
        """
        Regions, which are not drawn: meshes whose extras say ``hitbox``. One in several places
        is several, of one name.
        """

    @property
    def lights(self) -> list[PunctualLight]:
        """Lamps, which shine in a world with a light."""

    @property
    def splats(self, /) -> list[SplatCloud]:
        """Clouds of Gaussian splats, which hold the light of their capture."""

    @property
    def splat_count(self) -> int:
        """Gaussian splats of all clouds."""

    @property
    def color_rule(self) -> str:
        """'gltf' or 'compoundray': see `omma.load_scene`."""

    def replace(self, **changes: Any) -> Scene:
        """
        Another scene that differs in what is given by keyword, as for making one. It comes
        from no file: its ``path`` is ''.
        """

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __hash__(self) -> int: ...

    @property
    def path(self, /) -> str:
        """The file it came from, '' for one made in memory."""

    @property
    def cameras(self) -> list[Camera]:
        """Camera nodes in the order of the file."""

    def camera(self, name_or_index: str | int) -> Camera:
        """
        The camera of that name, or with that index among ``cameras``; an index may also be
        text, where no camera is called so.

        Raises `omma.Error`, with the names and indices there are, where there is none or
        several are called so.
        """

    @property
    def bounds(self, /) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        Lower and upper corner of the box around everything: (2, 3), m; None for an
        empty scene.
        """

    @property
    def triangle_count(self) -> int:
        """Triangles as seen: each instance counts those of its mesh."""

    @property
    def mesh_count(self) -> int:
        """Meshes stored: one for each glTF primitive."""

    @property
    def instance_count(self) -> int:
        """Meshes placed in the world."""

    @property
    def material_count(self) -> int: ...

    @property
    def texture_count(self) -> int: ...

    @property
    def image_count(self) -> int: ...

    @property
    def node_count(self) -> int:
        """Nodes reached from the loaded scene."""

    @property
    def scene_names(self) -> list[str]:
        """Names of all scenes in the file."""

    @property
    def background(self) -> Background:
        """What a ray sees that meets no surface."""

    @property
    def hit_box_names(self) -> list[str]:
        """Names of the hit boxes, each once."""

    def hit_box_bounds(self, name: str) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        Lower and upper corner of the box around a hit box: (2, 3), m; None where it has no
        triangles.

        Raises `omma.Error`, with the names there are.
        """

    def is_inside(self, name: str, points_m: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.bool_]:
        """
        Which points (N, 3), m, lie inside a hit box, taken as a closed surface: bool (N,).

        Raises `omma.Error`, with the names there are.
        """

    @property
    def warnings(self) -> list[str]:
        """What the loader passed over, a sentence each."""

    def __repr__(self) -> str: ...

    def __eq__(self, other: object) -> bool: ...

    def __copy__(self) -> Scene: ...

    def __deepcopy__(self, memo: object) -> Scene: ...

def load_scene(path: str | os.PathLike[str], scene_index: int = -1, color_rule: str = 'gltf', progress: Callable[[float], object] | None = None) -> Scene: ...

def save_scene(path: str | os.PathLike[str], scene: Scene, progress: Callable[[float], object] | None = None) -> None: ...

def find_animation(scene: Scene, name: str) -> int: ...

def camera_at(scene: Scene, camera: int, time_s: float, animations: Sequence[int]) -> numpy.typing.NDArray[numpy.float64]: ...

def with_path(scene: Scene, path: str | os.PathLike[str], warnings: list[str]) -> Scene:
    """
    The same scene, which says that it came from that file, and what of that was passed over.
    """

class Acceptance:
    """
    The angular sensitivity of an ommatidium: a kernel and its parameters.

    Made by one of its static methods. Directions are given by their polar angle from the axis
    and their azimuth, 0 towards the ommatidium's up vector and growing towards its right.
    Raises `omma.Error` on a parameter that is impossible, or out of the range of animals' eyes
    unless ``allow_unusual`` is said. Sources: docs/eyes.md.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @staticmethod
    def gaussian(width_rad: float, minor_width_rad: float | None = None, major_angle_rad: float = 0.0, *, allow_unusual: bool = False) -> Acceptance:
        """
        A Gaussian per solid angle, round or elliptical: full widths at half maximum and the
        azimuth of the major axis.
        """

    @staticmethod
    def pillbox(width_rad: float, *, allow_unusual: bool = False) -> Acceptance:
        """The same all over a disc of this diameter."""

    @staticmethod
    def compoundray(width_rad: float, *, allow_unusual: bool = False) -> Acceptance:
        """
        CompoundRay's: the polar angle from a one-dimensional normal, for comparison.
        """

    @staticmethod
    def airy(facet_diameter_m: float, wavelength_nm: float, *, allow_unusual: bool = False) -> Acceptance:
        """
        Diffraction at a round facet alone: [2 J1(x)/x]^2 with x = pi D sin(theta)/lambda.
        """

    @staticmethod
    def lens_rhabdom(facet_diameter_m: float, focal_length_m: float, rhabdom_diameter_m: float, wavelength_nm: float, rhabdom_index: float = 1.363, surround_index: float = 1.34, model: str = 'waveguide', *, allow_unusual: bool = False) -> Acceptance:
        """
        Diffraction at the facet and what the rhabdom takes of it: "waveguide" (the modes it
        carries; Stavenga 2004), "geometric" (its disc) or "snyder" (a Gaussian).
        """

    @staticmethod
    def table(angle_rad: numpy.typing.ArrayLike, sensitivity: numpy.typing.ArrayLike, path: str | os.PathLike[str] = '') -> Acceptance:
        """
        A measured radial profile: polar angles (K,), ascending, rad, and sensitivities (K,);
        linear between, 0 beyond the last. Divided by the largest.
        """

    @staticmethod
    def table_2d(right_rad: numpy.typing.ArrayLike, up_rad: numpy.typing.ArrayLike, sensitivity: numpy.typing.ArrayLike, path: str | os.PathLike[str] = '') -> Acceptance:
        """
        A measured map: angles to the right (C,) and up (R,), ascending, rad, and
        sensitivities (R, C); linear between, 0 outside. Divided by the largest.
        """

    @property
    def kernel(self) -> str: ...

    @property
    def model(self) -> str: ...

    @property
    def width_parameter_rad(self) -> float:
        """
        Full width at half maximum that a gaussian (major axis), pillbox or compoundray was made with.
        """

    @property
    def minor_width_rad(self) -> float: ...

    @property
    def major_angle_rad(self) -> float: ...

    @property
    def facet_diameter_m(self) -> float: ...

    @property
    def wavelength_nm(self) -> float: ...

    @property
    def focal_length_m(self) -> float: ...

    @property
    def rhabdom_diameter_m(self) -> float: ...

    @property
    def rhabdom_index(self) -> float: ...

    @property
    def surround_index(self) -> float: ...

    @property
    def table_right_rad(self) -> list[float]:
        """
        Of a table: angles to the right, or the polar angles of a radial profile, rad.
        """

    @property
    def table_up_rad(self) -> list[float]:
        """Of a two-dimensional table: angles up, rad."""

    @property
    def table_sensitivity(self) -> list[float]:
        """Of a table: sensitivities, row by row."""

    @property
    def is_round(self) -> bool:
        """Whether it depends on the polar angle alone."""

    @property
    def mean_width_rad(self) -> float:
        """
        Full width at half maximum; the geometric mean of the widest and the narrowest where not round.
        """

    @property
    def coupling_efficiency(self) -> float:
        """
        Of a distant point's light that the facet lets in, the share that is inside the rhabdom
        where S is 1: of `lens_rhabdom` by its modes or, 'geometric', the Airy pattern within
        the tip. 1 of all others, whose S says nothing absolute.
        """

    def width_rad(self, azimuth_rad: float = 0.0) -> float:
        """Full width at half maximum through the axis along an azimuth."""

    def eval(self, theta_rad: numpy.typing.ArrayLike, azimuth_rad: numpy.typing.ArrayLike = 0.0) -> Any:
        """
        Relative sensitivity in directions, 1 at its largest; arrays are broadcast.
        compoundray's is infinite at the axis and not normalised.
        """

    def pdf(self, theta_rad: numpy.typing.ArrayLike, azimuth_rad: numpy.typing.ArrayLike = 0.0) -> Any:
        """Density of `sample` per steradian; arrays are broadcast."""

    def mtf(self, cycles_per_rad: numpy.typing.ArrayLike, azimuth_rad: numpy.typing.ArrayLike = 0.0) -> Any:
        """
        Modulation transfer for sine gratings that vary along an azimuth; arrays are broadcast.
        """

    def sample(self, count: int, seed: int = 0) -> numpy.typing.NDArray[numpy.float32]:
        """
        Directions drawn in proportion to the sensitivity: (count, 3), with x towards up, y
        towards the right and z along the axis.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> Acceptance: ...

    def __deepcopy__(self, memo: object) -> Acceptance: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

class ReceptorType:
    """
    What a kind of photoreceptor is sensitive to.

    Parameters
    ----------
    name : e.g. "green".
    peak_wavelength_nm : of its visual pigment (template of Govardovskii et al. 2000).
    wavelength_nm, sensitivity : (K,) instead: a table, linear between, 0 outside; divided by
        the largest.
    microvillus_angle_rad : from the ommatidium's up vector towards its right.
    polarisation_sensitivity : PS, at least 1.
    absorption_per_m, length_m : of the rhabdom; 0 where not known.
    right_rad, up_rad : where it looks, from the ommatidium's axis.
    acceptance : its own `Acceptance`; None: the ommatidium's.
    allow_unusual : numbers beyond those of animals' eyes are meant.

    Raises `omma.Error` on a parameter out of range.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, name: str, *, peak_wavelength_nm: float = 0.0, wavelength_nm: numpy.typing.ArrayLike | None = None, sensitivity: numpy.typing.ArrayLike | None = None, microvillus_angle_rad: float = 0.0, polarisation_sensitivity: float = 1.0, absorption_per_m: float = 0.0, length_m: float = 0.0, right_rad: float = 0.0, up_rad: float = 0.0, acceptance: Acceptance | None = None, allow_unusual: bool = False) -> None: ...

    @property
    def name(self) -> str: ...

    @property
    def peak_wavelength_nm(self) -> float: ...

    @property
    def wavelength_nm(self) -> list[float]: ...

    @property
    def sensitivity(self) -> list[float]: ...

    @property
    def microvillus_angle_rad(self) -> float: ...

    @property
    def polarisation_sensitivity(self) -> float: ...

    @property
    def absorption_per_m(self) -> float: ...

    @property
    def length_m(self) -> float: ...

    @property
    def right_rad(self) -> float: ...

    @property
    def up_rad(self) -> float: ...

    @property
    def acceptance(self) -> Acceptance | None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> ReceptorType: ...

    def __deepcopy__(self, memo: object) -> ReceptorType: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

def expect_eye_radius(name: str, radius_m: float, allow_unusual: bool) -> None: ...

class Light:
    """
    What the engine lights a world with; the values of `omma.light` are the ones to use.

    Args:
        wavelength_nm: (K,), ascending.
        weight: (B, K), of the wavelengths in each band, adding up to 1.
        cell_nm: (K,), how much there is about each wavelength that its weight stands for; None:
            the wavelengths alone.
        unit: 'photons' (m^-2 s^-1 sr^-1 nm^-1) or 'watts' (m^-2 sr^-1 nm^-1).
        sky: radiance by direction, (2, rows, columns, components, channels): above and below
            the horizon, from it to the zenith and the nadir, to the right from -Z; 1 component
            (I) or 3 (I, Q, U). None: dark.
        band_from_channel: (B, channels); None: channels are the bands.
        discs: tuples (direction (3,), angular_radius_rad, radiance (B,), limb_darkening (B,)
            or None).
        extinction_per_m: (B,), of the air between surfaces; None: it is clear.
        cloud_shadow: (optical_depth (rows, columns), spacing_m, height_m, (x, z) of the first
            node, m), of clouds that shade what lies below them from discs; None: none do.
        ultraviolet: (M, 4), of each material of the scene that will be lit: reflectance below
            400 nm of what is known in RGB only, as weights of red, green, blue and 1.
        emission_cd_m2: what white emission of 1 is, cd m^-2.
        bottomless: whether the air between surfaces goes on below without end, as water does.

    Raises `omma.Error` that names the argument.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, wavelength_nm: numpy.typing.ArrayLike, weight: numpy.typing.ArrayLike, cell_nm: numpy.typing.ArrayLike | None, unit: str, sky: numpy.typing.ArrayLike | None, band_from_channel: numpy.typing.ArrayLike | None, discs: Iterable[tuple[numpy.typing.ArrayLike, float, numpy.typing.ArrayLike, numpy.typing.ArrayLike | None]], extinction_per_m: numpy.typing.ArrayLike | None, cloud_shadow: tuple[numpy.typing.ArrayLike, float, float, numpy.typing.ArrayLike] | None, ultraviolet: numpy.typing.ArrayLike | None, emission_cd_m2: float = 1.0, bottomless: bool = False) -> None: ...

    @property
    def wavelength_nm(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """Read-only, (K,)."""

    @property
    def weight(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """Read-only, (B, K)."""

    @property
    def unit(self) -> str:
        """'photons' or 'watts'."""

    @property
    def sky(self, /) -> numpy.typing.NDArray[numpy.float32] | None:
        """Read-only, as given; or None."""

    @property
    def band_from_channel(self, /) -> numpy.typing.NDArray[numpy.float64] | None:
        """Read-only, (B, channels); or None."""

    @property
    def discs(self, /) -> tuple[tuple[tuple[float, float, float], float, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None], ...]:
        """Tuples as given."""

    @property
    def extinction_per_m(self, /) -> numpy.typing.NDArray[numpy.float64] | None:
        """Read-only, (B,); or None."""

    @property
    def bottomless(self) -> bool: ...

    @property
    def cloud_shadow(self, /) -> tuple[numpy.typing.NDArray[numpy.float32], float, float, tuple[float, float]] | None:
        """As given, its array read-only; or None."""

    @property
    def ultraviolet(self, /) -> numpy.typing.NDArray[numpy.float64] | None:
        """Read-only, (M, 4); or None."""

def materials_without_ultraviolet(scene: Scene, wavelength_nm: numpy.typing.ArrayLike, weight: numpy.typing.ArrayLike) -> list[int]:
    """
    Materials in use of which nothing is known in some of the bands' ultraviolet: indices, -1 for
    meshes without a material.
    """

class BakedLight:
    """Light that was baked, as the engine reads it."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, unit: float, values: numpy.typing.NDArray[numpy.uint16], errors: numpy.typing.NDArray[numpy.uint32], first_cell: numpy.typing.NDArray[numpy.int32], cell_of_triangle: Sequence[numpy.typing.NDArray[numpy.int32]], probe_origin_m: numpy.typing.ArrayLike, probe_spacing_m: numpy.typing.ArrayLike, probe_values: numpy.typing.NDArray[numpy.uint16], numbers: Sequence[float]) -> None: ...

    @property
    def unit(self) -> float: ...

    @property
    def cell_m(self) -> float: ...

    @property
    def cells(self) -> int: ...

    @property
    def paths(self) -> float: ...

    @property
    def by_probes(self) -> int: ...

    @property
    def seconds(self) -> float: ...

    @property
    def error_median(self) -> float: ...

    @property
    def error_95(self) -> float: ...

    @property
    def numbers(self, /) -> list[float]: ...

    @property
    def errors(self, /) -> numpy.typing.NDArray[numpy.uint32]: ...

    @property
    def bytes(self) -> int: ...

    @property
    def values(self, /) -> numpy.typing.NDArray[numpy.uint16]: ...

    @property
    def first_cell(self, /) -> numpy.typing.NDArray[numpy.int32]: ...

    @property
    def cell_of_triangle(self, /) -> list[numpy.typing.NDArray[numpy.int32]]: ...

    @property
    def probe_origin_m(self, /) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def probe_spacing_m(self, /) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def probe_values(self, /) -> numpy.typing.NDArray[numpy.uint16]: ...

class UnfinishedBake:
    """What is finished of a bake that was cancelled."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @overload
    def __init__(self) -> None: ...

    @overload
    def __init__(self, numbers: Sequence[float], done: numpy.typing.NDArray[numpy.uint8], lines: Sequence[numpy.typing.NDArray[numpy.uint16]], paths_of_group: numpy.typing.NDArray[numpy.uint16]) -> None: ...

    @property
    def share(self) -> float: ...

    @property
    def numbers(self, /) -> list[float]: ...

    @property
    def done(self, /) -> numpy.typing.NDArray[numpy.uint8]: ...

    @property
    def lines(self, /) -> list[numpy.typing.NDArray[numpy.uint16]]: ...

    @property
    def paths_of_group(self, /) -> numpy.typing.NDArray[numpy.uint16]: ...

def bake_light(world: World, cell_m: float, paths: int, most_bytes: int, seed: int, progress: Callable[[float], object] | None, unfinished: UnfinishedBake | None = None) -> BakedLight: ...

def bake_cost(world: World, cell_m: float, paths: int, most_bytes: int, progress: Callable[[float], object] | None) -> tuple[int, int, int, float]: ...

class Eye:
    """
    An eye, or all eyes of a head: N ommatidia, each with its own position, axis, acceptance.

    The frame is that of the head: right-handed, +X right, +Y up, looking along -Z. Read-only;
    the arrays are views, not copies; `replace` makes a changed copy.

    Parameters
    ----------
    position_m : (N, 3), m. Nodal points.
    axis : (N, 3). Viewing directions; normalised.
    acceptance_angle_rad : (N,) or a number. Full width at half maximum, 0 to 2 pi, of round
        Gaussians; may be left out where `acceptance` says more.
    focal_offset_m : (N,) or a number. How far behind the position rays start.
    eye_id : (N,) or a number. Which eye of the head an ommatidium belongs to.
    up : (N, 3). The reference across the axis for what is not round; by default upwards.
    facet_diameter_m : (N,) or a number; 0 where not known.
    aperture_diameter_m : (N,) or a number. Rays start all over a disc this wide, as in
        superposition eyes.
    acceptance : an `Acceptance`, or a list of N; None stands for the round Gaussian.
    receptor_types : list of `ReceptorType`.
    receptors : indices into receptor_types, a list for all ommatidia or a list of N lists.
    columns : dict from names to (N,) numbers or N texts, kept but not used.
    path : the file it came from; eyes that differ in nothing else are equal.

    Raises `omma.Error` on a wrong shape, a zero axis, an acceptance out of range, a NaN; a
    `UserWarning` tells of numbers that no animal has, mostly slips of units.
    """

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, position_m: numpy.typing.ArrayLike, axis: numpy.typing.ArrayLike, acceptance_angle_rad: numpy.typing.ArrayLike | None = None, focal_offset_m: numpy.typing.ArrayLike = 0.0, eye_id: numpy.typing.ArrayLike = 0, *, up: numpy.typing.ArrayLike | None = None, facet_diameter_m: numpy.typing.ArrayLike = 0.0, aperture_diameter_m: numpy.typing.ArrayLike = 0.0, acceptance: Acceptance | Sequence[Acceptance | None] | None = None, receptor_types: Sequence[ReceptorType] | None = None, receptors: Sequence[Any] | None = None, columns: dict[str, Any] | None = None, path: str | os.PathLike[str] = '') -> None: ...

    def replace(self, **changes: Any) -> Eye:
        """
        A copy with these properties changed, named as for making an eye; all else is kept.

        acceptance_angle_rad alone makes all ommatidia round Gaussians. New axes without up
        have the up vectors of a new eye, unless others had been set: those are kept, across
        the new axes, and up=eye.up keeps them always. Raises `omma.Error` or `TypeError` as
        making an eye does.
        """

    @property
    def path(self, /) -> str:
        """The file it came from, '' for one made in memory."""

    @property
    def position_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """Nodal points: (N, 3), m, head frame."""

    @property
    def axis(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """Viewing directions: (N, 3), unit vectors, head frame."""

    @property
    def up(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """
        The reference for what is not round: (N, 3), unit vectors across the axes.
        """

    @property
    def right(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """axis x up: (N, 3), unit vectors."""

    @property
    def acceptance_angle_rad(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """
        Full width at half maximum of the angular sensitivity (its mean where not round): (N,), rad.
        """

    @property
    def focal_offset_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """How far behind the position rays start: (N,), m."""

    @property
    def facet_diameter_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """Facet diameters: (N,), m; 0 where not known."""

    @property
    def aperture_diameter_m(self, /) -> numpy.typing.NDArray[numpy.float32]:
        """Discs on which rays start: (N,), m; 0: the position."""

    @property
    def eye_id(self, /) -> numpy.typing.NDArray[numpy.int32]:
        """Which eye of the head an ommatidium belongs to: (N,)."""

    @property
    def acceptance_of(self, /) -> numpy.typing.NDArray[numpy.int32]:
        """
        Index into acceptances: (N,); -1: a round Gaussian of acceptance_angle_rad.
        """

    @property
    def first_receptor(self, /) -> numpy.typing.NDArray[numpy.int32]:
        """
        Receptors of ommatidium i are first_receptor[i] to first_receptor[i + 1]: (N + 1,).
        """

    @property
    def receptor_type(self, /) -> numpy.typing.NDArray[numpy.int32]:
        """Index into receptor_types: (R,)."""

    @property
    def columns(self, /) -> dict[str, Any]:
        """
        Properties that Omma itself does not use, by name: (N,) float64, or N texts.
        """

    @property
    def acceptances(self) -> list[Acceptance]:
        """
        Angular sensitivities that are not a round Gaussian; see acceptance_of.
        """

    @property
    def receptor_types(self) -> list[ReceptorType]: ...

    def acceptance(self, ommatidium: int) -> Acceptance:
        """The angular sensitivity of one ommatidium."""

    def take(self, ommatidia: numpy.typing.ArrayLike | slice) -> Eye:
        """
        The ommatidia with these indices, of this slice, or where this mask (N,) is true.
        """

    def interommatidial_angle_rad(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        Local interommatidial angle: the mean angle to the (up to) six nearest neighbours of
        the same eye. (N,), rad; 0 where there is no neighbour.
        """

    def select(self, eye_id: int) -> Eye:
        """
        The ommatidia of one eye of a head.

        Raises `omma.Error` where there is no such eye.
        """

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> Eye: ...

    def __deepcopy__(self, memo: object) -> Eye: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

def unusual_of(eye: Eye) -> list[str]:
    """What of an eye is in no animal's range, a sentence for each array."""

def merge_eyes(eyes: Iterable[Eye | tuple[Eye, numpy.typing.ArrayLike]]) -> Eye:
    """
    All eyes of a head as one; ``eye_id`` numbers them from 0 in the order given.

    Each item is an `Eye`, or a pair (eye, head_from_eye) with where it sits in the head as a
    (4, 4) transform, m.

    Raises `omma.Error` where an item is something else or a transform is not usable.
    """

def load_eye(path: str | os.PathLike[str], metres_per_unit: float, head: str) -> Eye: ...

def save_eye(path: str | os.PathLike[str], eye: Eye, metres_per_unit: float, lossy: bool) -> None: ...

def eye_file_losses(path: str | os.PathLike[str], eye: Eye) -> list[str]: ...

def eye_file_heads(path: str | os.PathLike[str]) -> list[str]: ...

def backends() -> list[str]:
    """Names of what can trace rays in this build."""

def use_card_libraries(nvrtc: str, kernel_cache: str, packaged: str) -> None:
    """
    Where the compiler of kernels is, "" for where the system has it, where they are kept, and where those are that came with Omma.
    """

def card_states() -> list[tuple[str, str, str]]:
    """
    Of each card its name, the CUDA that its driver is for, and why it cannot be used; "" for none.
    """

def card_note(devices: Sequence[int], progress: Callable[[float], object] | None) -> str:
    """
    What is to be known of cards' kernels, or "". Compiles them; how far that is nobody knows.
    """

def compiling_kernels() -> bool:
    """Whether a thread of this process is compiling kernels of a card now."""

def compile_kernels(capability: int, nvrtc: str, folder: str) -> None:
    """
    Compiles all kernels for cards of a compute capability, 90 for 9.0, into a folder, which is made where it is not there; no card is needed.
    """

class CardSpan:
    """float32 in a card's memory, for the engine to write into."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, card: int, at: int, size: int, stream: int | None) -> None: ...

class CardMemory:
    """Memory of a card for so many float32."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, size: int, card: int) -> None: ...

    @property
    def card(self) -> int: ...

    @property
    def at(self) -> int: ...

    def array(self, shape: Sequence[int]) -> Any:
        """It as an array that DLPack hands over."""

def card_read(card: int, at: int, to: numpy.typing.NDArray[numpy.uint8]) -> None:
    """Bytes of a card's memory, when all that was asked of the card is done."""

def card_write(card: int, at: int, from_bytes: numpy.typing.NDArray[numpy.uint8]) -> None:
    """Bytes into a card's memory."""

def card_of(at: int) -> int:
    """
    The ordinal of the card that an address is on. Raises `omma.Error` where it is on none.
    """

class WorldInstance:
    """Something in a world that can be moved."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @property
    def name(self) -> str:
        """Of its node in the file; others may have the same one."""

    @property
    def world_from_node(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """Where it was when it was asked for: (4, 4), m."""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple[Any, ...]: ...

    def __setstate__(self, state: tuple[Any, ...]) -> None: ...

    def __copy__(self) -> WorldInstance: ...

    def __deepcopy__(self, memo: object) -> WorldInstance: ...

    def __eq__(self, other: object) -> bool: ...

    def __hash__(self) -> int: ...

class World:
    """The engine's world; `omma.World` is the one to use."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, scene: Scene, threads: int, background: Background | None, backend: str, devices: Sequence[int], band_from_rgb: Sequence[float], lighting: tuple[Light, int, bool, BakedLight | None, bool] | None, progress: object | None) -> None: ...

    def with_lighting(self, lighting: tuple[Light, int, bool, BakedLight | None, bool]) -> World: ...

    def with_background(self, background: Background) -> World: ...

    @property
    def instances(self) -> list[WorldInstance]: ...

    def find_instance(self, name: str) -> int: ...

    def set_transforms(self, instances: numpy.typing.NDArray[numpy.int32], transforms: numpy.typing.NDArray[numpy.float64], progress: Callable[[float], object] | None) -> None: ...

    def set_vertices(self, mesh: int, positions_m: numpy.typing.NDArray[numpy.float32], normals: numpy.typing.NDArray[numpy.float32] | None, progress: Callable[[float], object] | None) -> None: ...

    def set_image(self, image: int, picture: Image) -> None: ...

    def set_color(self, material: int, base_color: Sequence[float], emissive: Sequence[float]) -> None: ...

    @property
    def animated(self) -> list[int]: ...

    def animated_at(self, time_s: float, animations: numpy.typing.NDArray[numpy.int32]) -> numpy.typing.NDArray[numpy.float64]: ...

    @property
    def reshaped(self) -> list[int]: ...

    def positions(self, mesh: int) -> numpy.typing.NDArray[numpy.float32]: ...

    def normals(self, mesh: int) -> numpy.typing.NDArray[numpy.float32]: ...

    def set_time(self, time_s: float, animations: numpy.typing.NDArray[numpy.int32], progress: Callable[[float], object] | None) -> None: ...

    def precision_warning(self, poses: numpy.typing.NDArray[numpy.float64]) -> str: ...

    def pose_slip(self, poses: numpy.typing.NDArray[numpy.float64]) -> str: ...

    @property
    def bands(self) -> int: ...

    @property
    def components(self) -> int: ...

    @property
    def threads(self) -> int: ...

    @property
    def backend(self) -> str: ...

    @property
    def build_times(self, /) -> dict[str, float]: ...

class RenderSettings:
    """What `omma.Renderer` was asked for."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    def __init__(self, *, sampling: tuple[str, int] | tuple[str, float, int, int, float], **options: object) -> None:
        """
        ``sampling`` is ('fixed', samples), ('to_error', error, least, most, relative_error) or
        ('shared', samples); the options are those of RenderSettings in omma/render.h.
        """

    @property
    def sampling(self, /) -> tuple[Any, ...]: ...

    @property
    def options(self, /) -> dict[str, Any]: ...

class Renderer:
    """The engine; `omma.Renderer` is the one to use."""

    # Generated, not written; after a change to the bindings:
    # python -m nanobind.stubgen -m omma._core -p python/src/stub_patterns.txt -o python/omma/_core.pyi

    @overload
    def __init__(self, world: World, eye: Eye, settings: RenderSettings) -> None: ...

    @overload
    def __init__(self, same_world: Renderer, eye: Eye, settings: RenderSettings) -> None: ...

    @overload
    def __init__(self, same_eye: Renderer, world: World) -> None: ...

    def render(self, poses: numpy.typing.NDArray[numpy.float64], responses: numpy.typing.NDArray[numpy.float32] | CardSpan, standard_error: numpy.typing.NDArray[numpy.float32] | CardSpan | None, rays: numpy.typing.NDArray[numpy.int32] | None, ray_radiance: numpy.typing.NDArray[numpy.float32] | None, beside_rays: numpy.typing.NDArray[numpy.float32] | None, first_pose: int | None, output_from_band: numpy.typing.NDArray[numpy.float64] | None, stokes: bool, moves: omma.rendering.moves.EngineMoves | None, progress: Callable[[float], object] | None) -> None: ...

    def ray_directions(self, poses: numpy.typing.NDArray[numpy.float64], first_pose: int, directions: numpy.typing.NDArray[numpy.float32]) -> None: ...

    def precision_warning(self, poses: numpy.typing.NDArray[numpy.float64]) -> str: ...

    def pose_slip(self, poses: numpy.typing.NDArray[numpy.float64]) -> str: ...

    @property
    def eye(self) -> Eye: ...

    @property
    def settings(self) -> RenderSettings: ...

    @property
    def bands(self) -> int: ...

    @property
    def threads(self) -> int: ...

    @property
    def rays_per_frame(self) -> int: ...

    @property
    def shared_ommatidia(self, /) -> numpy.typing.NDArray[numpy.uint8]: ...

    @property
    def backend(self) -> str: ...

    @property
    def build_times(self, /) -> dict[str, float]: ...

rgb_bands: int = 3

most_bands: int = 128

error_scrambles: int = 8

def look_at(position_m: numpy.typing.ArrayLike, target_m: numpy.typing.ArrayLike, up: numpy.typing.ArrayLike = (0.0, 1.0, 0.0)) -> numpy.typing.NDArray[numpy.float64]:
    """
    The pose ``world_from_head`` of a head at a position (3,), m, that looks towards a target
    (3,), m, with ``up`` roughly up: (4, 4) float64.

    Raises `omma.Error` where the target is the position or ``up`` is along the view.
    """

def render_truth(renderer: Renderer, poses: numpy.typing.NDArray[numpy.float64], arrays: dict[str, numpy.typing.NDArray[Any]], first_pose: int | None, moves: omma.rendering.moves.EngineMoves | None, progress: Callable[[float], object] | None) -> None:
    """
    Responses and ground truth, into arrays by name: those of `omma.rendering.GroundTruth`,
    and what it is asked with; see omma/truth.h.
    """

def equirectangular_ids(eye: Eye, width: int, height: int, by_position: bool, max_angle_rad: float) -> numpy.typing.NDArray[numpy.int32]: ...

def projection_ids(eye: Eye, projection: str, width: int, height: int) -> numpy.typing.NDArray[numpy.int32]: ...

def field_ids(eye: Eye, width: int, height: int, side_by_side: bool) -> numpy.typing.NDArray[numpy.int32]: ...

def projection_names() -> list[str]: ...

def encode_ids(ids: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.uint8]:
    """
    An id map (height, width) as an RGBA picture, uint8 (height, width, 4).

    The id is a 32-bit number, its highest byte in R, its lowest in A, as in CompoundRay's
    ``_ids`` projections; -1 is 255, 255, 255, 255. Back again: ``picture.view('>i4')[..., 0]``.

    Raises `omma.Error` where the ids are not two-dimensional whole numbers.
    """

def paint(ids: numpy.typing.ArrayLike, responses: numpy.typing.ArrayLike, gamma: float = 2.2) -> numpy.typing.NDArray[numpy.uint8]:
    """
    One pose's responses (N, 3) through an id map (height, width) as an 8-bit RGB picture
    (height, width, 3). Display value = 255 * clamp(response)^(1/gamma); id -1 is mid grey.

    Raises `omma.Error` on a wrong shape, an id over N or a gamma that is not over 0.
    """

def save_png(path: str | os.PathLike[str], pixels: numpy.typing.NDArray[numpy.uint8]) -> None:
    """
    Write 8-bit pixels (height, width, 3 or 4), row 0 at the top, as a PNG file.

    It is written under another name and renamed, so that no half of a file is left.
    Raises `omma.Error` where the pixels or the path do not do.
    """

def encode_png(path: str | os.PathLike[str], pixels: numpy.typing.NDArray[numpy.uint8], quick: bool = False) -> bytes: ...

def spectral_sensitivity(type: ReceptorType, wavelength_nm: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]: ...

def pigment_bands(peak_wavelength_nm: float, wavelength_nm: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]: ...

def primary_spectra(wavelength_nm: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.float64]: ...

def receptor_weights(type: ReceptorType, ultraviolet: Sequence[float]) -> list[float]: ...

def receptor_views(eye: Eye) -> tuple[Eye, numpy.typing.NDArray[numpy.int32]]: ...
