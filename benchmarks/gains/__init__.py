"""Search the gains of a scene by CMA-ES, each candidate judged by its worst run of a family."""
