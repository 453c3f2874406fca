"""Printable paper nets."""
