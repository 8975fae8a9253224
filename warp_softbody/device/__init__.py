"""What the package asks of Warp as a whole, and reading device arrays on the host."""
