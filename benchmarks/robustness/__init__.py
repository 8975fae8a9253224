"""Whether every motion holds where its gains were not searched."""
