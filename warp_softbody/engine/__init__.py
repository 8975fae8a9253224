"""One step: model and state on the device, assembly, contact, and the reduced dynamics."""
