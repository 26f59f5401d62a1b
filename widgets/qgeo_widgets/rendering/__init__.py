"""Shapes in the browser: what the widgets ask for, and the two backends that draw it."""
