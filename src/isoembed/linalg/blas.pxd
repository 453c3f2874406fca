# cython: boundscheck=False, wraparound=False, initializedcheck=False
# Products of matrices for compiled modules, by the BLAS of SciPy: no lock of the interpreter is needed.

from scipy.linalg.cython_blas cimport dgemm, sgemm

ctypedef fused Number:
    float
    double


cdef inline void multiply_transposed(
    Number[::1] work, long long k, long long rows, Number[::1] right, long long stride, long long columns,
) noexcept nogil:
    cdef int m = rows, n = columns, inner = k, ld = stride
    cdef Number one = 1, zero = 0
    if Number is double:
        dgemm("N", "T", &n, &m, &inner, &one, &right[0], &ld, &work[0], &m, &zero, &work[k * rows], &n)
    else:
        sgemm("N", "T", &n, &m, &inner, &one, &right[0], &ld, &work[0], &m, &zero, &work[k * rows], &n)
