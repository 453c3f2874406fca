# What other compiled modules use without Python.

from isoembed.intrinsic.loops cimport Mesh

cdef class Layout:
    cdef long long[::1] corners
    cdef long long[::1] twins
    cdef double complex[::1] z
    cdef unsigned char[::1] fixed
    cdef long long[::1] cells
    cdef double curvature

cdef double angle_around(long long h, Layout polygons) noexcept
cpdef (long long, double) sector(long long h, double direction, double total, Mesh mesh) noexcept
cpdef double complex place(long long h, (long long, double complex, double complex) state, Layout polygons) noexcept
cpdef (long long, double complex, double complex) from_corner(long long h, double offset, Layout polygons) noexcept
cpdef (long long, double complex, double complex) from_inside(
    long long f, double complex start, double angle, Layout polygons
)
cdef (long long, double complex, double complex) crossed(
    (long long, double complex, double complex) state, Layout polygons
) noexcept
cdef bint reaches((long long, double complex, double complex) state, double length, Layout polygons) noexcept
cpdef (long long, double complex, double complex) straight(
    (long long, double complex, double complex) state, double length, Layout polygons
) noexcept
