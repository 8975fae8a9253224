"""The general QPCC."""
