"""Sweeps: many runs of one deck with other values, by Snakemake; one table of their results."""
