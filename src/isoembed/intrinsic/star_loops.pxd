# What other compiled modules use without Python.

from isoembed.intrinsic.loops cimport Mesh

cdef bint retriangulate_star(
    long long h,
    Mesh mesh,
    long long[::1] leaving,
    unsigned char[::1] alive,
    long long[::1] moved,
    long long[::1] stack,
)
