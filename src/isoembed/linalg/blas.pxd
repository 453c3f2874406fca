# Products of matrices for compiled modules, by the BLAS of SciPy: no lock of the interpreter is needed.

from scipy.linalg.cython_blas cimport dgemm, sgemm

ctypedef fused Number:
    float
    double


cdef inline void multiply_transposed(
    Number[::1] room, long long left, long long right, long long product,
    long long k, long long width, long long begin, long long end,
) noexcept nogil:
    cdef int rows = end - begin, columns = width - begin, inner = k, stride = width
    cdef Number one = 1, zero = 0
    if Number is double:
        dgemm("N", "T", &columns, &rows, &inner, &one, &room[right + begin], &stride,
              &room[left + begin], &stride, &zero, &room[product], &columns)
    else:
        sgemm("N", "T", &columns, &rows, &inner, &one, &room[right + begin], &stride,
              &room[left + begin], &stride, &zero, &room[product], &columns)
