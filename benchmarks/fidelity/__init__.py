"""Whether every motion survives a better, a coarser or another computation of its physics."""
