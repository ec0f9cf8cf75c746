"""What all subpackages stand on: checks of arguments, directions and poses, whole files, tables,
the look of figures. What is public of it is found elsewhere.

Files: `arguments` (what a caller gave, checked), `renamed` (old names, with a warning), `files`
(whole files), `locks` (by what a system has), `poses`, `spirals`, `srgb`, `figures`, `values`
(results compared and pickled), `dlpack` (arrays of other libraries), `card_arrays` (those on a
card), `card_compiler` (what compiles its kernels), `backend_names`; `obj_files`, `mtl_files`,
`ply_files`, whose `mesh_parts` become scenes and surfaces of eyes.
"""
