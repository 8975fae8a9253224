"""Contact with the ground and between surfaces."""
