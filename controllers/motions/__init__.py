"""The controllers of the shipped motions."""
