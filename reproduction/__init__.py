"""The paper reproduced: its figures and numbers made again, and the methods that it cites, as baselines.

    python -m reproduction --output FOLDER [--quick]

It is no part of the package, and uses only what is public.
"""
