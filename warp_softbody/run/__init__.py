"""The run loop over steps, its records and its summary."""
