"""The general form of a QPCC: penalty method, local search, branch and bound."""
