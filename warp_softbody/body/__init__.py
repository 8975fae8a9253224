"""What a body is: mesh, material, muscles, and how these are read and made."""
