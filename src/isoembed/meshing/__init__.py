"""Good triangulations of smooth surfaces and metrics: points, spreading, relaxation, flips."""
