"""Eyes: made, changed, measured, read and written. Lenses and rhabdoms are `omma.Acceptance`;
animals are in `omma.species`.

- Make: `generate_eye` from a density (`AcuteZone`, `acute_zones`), `lay_directions` from
  interommatidial angles (`acute_angle`) in a field of view (`window`), `eye_on_surface` and
  `lay_on_surface` on the surface of an eye; `direction` and `azimuth_elevation_deg_of` say where
  ommatidia look.
- Change: `merge_eyes`, `join_eyes`, `pair_of_eyes`, `mirror_eye`, `split_eye`, `place_on_head`,
  `rescale_eye`; `set_acceptance`, `set_facets`, `acceptance_from_facets`.
- Measure: `measure_eye` gives `EyeMeasures`, which `eye_summary` and `eye_table` make numbers of;
  `PROPERTIES` are what figures show; `facet_diameters_m`, `hexagonal_coordinates`.
- Files: `omma.load_eye` and `omma.save_eye`; `eye_file_heads`, `eye_file_losses`,
  `save_eye_table`, `load_acceptance`; `convert_eye` gives a `ConvertedEye`.

What belongs to one matter alone is in modules of their own:

- `omma.eye.angles`: interommatidial angles from tables and fields of view from outlines, for
  `lay_directions`
- `omma.eye.lattice`: what `lay_directions` gives, and how good a lattice is
- `omma.eye.surfaces`: what eyes lie on; `omma.eye.skew`: axes that are no normals of it
- `omma.eye.hexagonal`: what `hexagonal_coordinates` gives
- `omma.eye.scans`: eyes from what was marked in scans
- `omma.eye.superposition`: receptors and facets whose light counts as one
"""

import lazy_loader

from omma.base.renamed import moved_names

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__getattr__ = moved_names(
    __getattr__,
    __name__,
    angles=("angle_table", "load_angle_table", "outline"),
    hexagonal=("DIRECTIONS", "NO_COORDINATE", "HexagonalCoordinates"),
    lattice=("Lattice", "LatticeCheck", "check_lattice"),
    scans=("ImportedEye", "LensConeEye", "import_lens_cone", "import_oda"),
    skew=("skew_rad", "squeeze_for_skew", "squeezed"),
    superposition=(
        "Wiring",
        "fly_receptors",
        "neural_superposition_wiring",
        "pool",
        "receptor_wiring",
        "superposition_facets",
    ),
    surfaces=("ellipsoid", "load_surface", "mesh_surface", "sphere"),
)
