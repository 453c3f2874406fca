"""What a page for the browser is made of: its markup, style and script, and the data that they show."""
