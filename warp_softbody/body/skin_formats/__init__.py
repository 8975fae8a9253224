"""Files of surfaces with texture coordinates and materials are read in this room."""
