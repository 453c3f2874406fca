# What other compiled modules call without Python.

cpdef double sn(double x, double k) noexcept
cpdef double cs(double x, double k) noexcept
cpdef double tn(double x, double k) noexcept
cpdef double chord(double l, double k) noexcept
cpdef double arc(double c, double k) noexcept
cpdef double twice_area(double a, double b, double c) noexcept
cpdef double amplitude(double a, double b, double c, double k) noexcept
cpdef double triangle_area(double a, double b, double c, double k) noexcept
cpdef double angle_between(double a, double b, double across, double k) noexcept
cpdef (double, double) apex(double l, double second, double third, double k) noexcept
