"""How many minima a solve hands on to the next; apart, as options of a command line know it too."""

OTHERS = 3
"""Minima beside the best one that a solve of the contact form hands on to the next."""
