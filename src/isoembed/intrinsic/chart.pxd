# What other compiled modules call without Python.

cdef double complex point(double x, double y) noexcept
cdef double dot(double complex a, double complex b) noexcept
cdef double cross(double complex a, double complex b) noexcept
cdef double norm(double complex a) noexcept
cdef double argument(double complex a) noexcept
cdef double complex from_frame(double complex origin, double complex axis, double x, double y) noexcept
cdef double complex polar(double r, double angle) noexcept
cpdef double complex toward(double complex a, double complex b, double k) noexcept
cpdef double complex moved(double complex z, double complex turn, double complex shift, double k) noexcept
cpdef double turn_at(double complex z, double complex turn, double complex shift, double k) noexcept
cpdef (double complex, double complex) motion(
    double complex a, double complex b, double complex c, double complex d, double k
) noexcept
cdef double complex quotient(double complex a, double complex b) noexcept
cpdef double coordinate(double distance, double k) noexcept
cpdef double distance(double complex z, double k) noexcept
cpdef double stretch(double complex z, double k) noexcept
