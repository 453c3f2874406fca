"""Progress of a computation: its stages, snapshots, the time left, checkpoints and their fingerprints."""
