"""Figures of results: one module a figure, drawn by femdem-plot NAME."""
