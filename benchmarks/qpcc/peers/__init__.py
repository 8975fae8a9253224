"""Other solvers of QPCCs, each called by one file and each used only where it is installed."""
