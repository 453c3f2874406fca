"""Pictures of a run: its numbers against time, and its horizons as ParaView, films and pages show them."""
