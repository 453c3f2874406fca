"""The seeds of the property tests are fixed: a failure today is a failure tomorrow."""

from hypothesis import settings

settings.register_profile("isoembed", derandomize=True, deadline=None, max_examples=30)
settings.load_profile("isoembed")
