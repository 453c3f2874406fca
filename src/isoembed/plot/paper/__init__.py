"""Paper nets to print, cut, fold and glue."""
