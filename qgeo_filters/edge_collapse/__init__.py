"""Collapse of edges, cheapest first, and the place of each vertex on what is left; arrays in and arrays out."""
