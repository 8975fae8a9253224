"""The contact form of a QPCC: one QP for each choice of contact modes, and a search over these."""
