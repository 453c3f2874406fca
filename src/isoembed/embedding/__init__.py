"""Embeddings, what `isoembed.embed` returns, with their reports, comparisons and sensitivities."""
