"""Scenes, grounds and frames say where bodies are, what they stand on and what is seen of them."""
