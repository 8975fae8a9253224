"""What the shipped motions cost and how they look: ``python -m benchmarks.motions``."""
