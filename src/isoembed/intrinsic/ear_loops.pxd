# What other compiled modules use without Python.

cdef double turn(double ax, double ay, double bx, double by, double cx, double cy) noexcept
