"""From runs to references, charts and settings tuned for an error."""
