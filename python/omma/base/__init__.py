"""What all subpackages stand on: checks of arguments, directions and poses, whole files, tables,
the look of figures. What is public of it is found elsewhere.
"""
