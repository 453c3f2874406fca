"""Studies: the paper's figures and numbers made again, and the methods that it cites, as baselines.

Nothing in the library imports from here.
"""
