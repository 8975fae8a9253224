"""Files of meshes and surfaces: what they hold is what they say, or they are refused.

Tets are read by meshio in a child process with limits of time and memory, and compared with what
the file itself declares; surfaces (.stl, .obj, .ply, .off) are read here by strict readers.
"""

from __future__ import annotations
