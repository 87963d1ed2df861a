"""Fracture networks: random traces, cleaning, meshes, and runs under in-situ stresses."""
