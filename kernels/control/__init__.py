"""The host side of control in native code, for processors."""
