"""Embeddings, as returned by `isoembed.embed`, with their reports, comparisons and sensitivities."""
