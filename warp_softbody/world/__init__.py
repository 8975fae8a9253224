"""Where bodies are, what they stand on, and what is seen of them: scenes, grounds, frames."""
