# What other compiled modules use without Python.

from isoembed.intrinsic.loops cimport Mesh, Rule

cdef class Tracked(Rule):
    cdef Mesh mesh
    cdef unsigned char[::1] kept
    cdef long long[::1] leaving
    cdef double[::1] weights

cdef bint flip_tracked(long long h, Mesh mesh, Tracked carried, double thinnest) noexcept
cdef bint looks_outward(const double[:, ::1] u, long long a, long long b, long long c) noexcept
