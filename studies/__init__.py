"""Measures, comparisons, figures and the command line."""
