"""Properties are tried on the same examples in every run, so that a failure repeats."""

from hypothesis import settings

settings.register_profile(
    "repeatable", derandomize=True, database=None, deadline=None, max_examples=60
)
settings.load_profile("repeatable")
