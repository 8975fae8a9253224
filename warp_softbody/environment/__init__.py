"""Scenes as Gymnasium environments: activations in, observations out (docs/environments.md)."""
