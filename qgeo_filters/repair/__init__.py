"""Repair of triangle soups, arrays in and arrays out; `hosts.repair` has what users call."""
