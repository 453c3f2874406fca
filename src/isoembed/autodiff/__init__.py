"""Surfaces as differentiable functions of their lengths, for JAX and PyTorch.

Import `isoembed.autodiff.jax` or `isoembed.autodiff.torch`; each needs its package.
"""
