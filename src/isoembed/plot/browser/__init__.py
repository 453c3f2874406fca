"""Browser pages: markup, style, script and embedded data."""
