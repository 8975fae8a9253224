"""Search the gains of a scene by seeded random draws, the later ones around the best so far."""
