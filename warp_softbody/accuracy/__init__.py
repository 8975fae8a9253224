"""Speed against accuracy: charts of a scene's knobs, and the settings that are just good enough.

Names are imported from the modules themselves, so that looking up stored settings loads neither the
engine nor a plotting library.
"""
