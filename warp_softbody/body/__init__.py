"""A body is described by its mesh, material and muscles; this room also reads and makes meshes."""
