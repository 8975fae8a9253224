"""The contact QPCC of one control step."""
