# What `bisection` calls without Python.

cdef class Pattern:
    cdef const int[::1] indptr
    cdef const int[::1] indices

cdef class Band:
    cdef long long[::1] members
    cdef long long[::1] layer
    cdef long long[::1] following
    cdef long long[::1] preceding
    cdef long long[::1] level
    cdef long long[::1] trail
    cdef long long[::1] tried

cdef long long replace_cut(
    Pattern graph, long long[::1] members, long long[::1] cell, long long width, Band band
) noexcept nogil
