"""What a computation did and is doing: stages, snapshots, the time left, and what a checkpoint belongs to."""
