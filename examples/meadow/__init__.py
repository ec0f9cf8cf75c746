"""The parts of make_meadow.py: shapes, plants, trees, land, textures, the glTF writer."""
