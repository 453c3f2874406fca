"""Series: horizons of a whole evolution with their slices, embedded."""
