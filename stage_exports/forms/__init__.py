"""Takes of a stage in the forms of other programs."""
