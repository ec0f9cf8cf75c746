"""What scenes are made of, under the names by which it is public."""

from omma._core import Animation as Animation
from omma._core import BoundaryTable as BoundaryTable
from omma._core import ExtraReflectance as ExtraReflectance
from omma._core import HitBox as HitBox
from omma._core import Image as Image
from omma._core import Instance as Instance
from omma._core import Material as Material
from omma._core import Mesh as Mesh
from omma._core import PunctualLight as PunctualLight
from omma._core import Rig as Rig
from omma._core import SplatCloud as SplatCloud
from omma._core import Texture as Texture
from omma._core import TextureUse as TextureUse
