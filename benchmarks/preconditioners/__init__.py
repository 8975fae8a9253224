"""What preconditioners give on the matrix of the benchmark beam in mid swing."""
