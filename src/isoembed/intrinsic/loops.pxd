# What other compiled modules use without Python.

cdef class Mesh:
    cdef long long[::1] corners
    cdef long long[::1] twins
    cdef double[::1] lengths
    cdef double[::1] directions
    cdef double curvature

cdef class Rule:
    cdef long long[::1] twins
    cdef long long attempt(self, long long h) noexcept

cpdef double modulo(double angle, double total) noexcept
cdef long long following(long long h) noexcept
cdef long long preceding(long long h) noexcept
cdef void glue(long long g, long long h, long long[::1] twins) noexcept
cpdef leaving_halfedges(const long long[::1] corners, long long n)
cdef long long edges_between(
    long long h, long long v, const long long[::1] corners, const long long[::1] twins
) noexcept
cpdef double corner_angle(long long h, Mesh mesh) noexcept
cpdef double total_angle(long long h, Mesh mesh) noexcept
cpdef double complex third_corner(long long h, double complex p, double complex q, Mesh mesh) noexcept
cdef void swap_diagonals(long long h, long long[::1] corners, long long[::1] twins) noexcept
cdef void push(long long h, long long[::1] stack, long long[::1] twins) noexcept
cdef (long long, long long) restore_delaunay(long long[::1] stack, Rule rule) noexcept
cpdef flip_edges(const long long[::1] edges, Rule rule)
cdef long long degree(long long h, const long long[::1] twins, long long most) noexcept
cpdef bint flip(long long h, Mesh mesh, double thinnest) noexcept
