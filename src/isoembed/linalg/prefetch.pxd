# cython: boundscheck=False, wraparound=False, initializedcheck=False
# Prefetching for compiled modules: a hint to the processor, which changes no result.

cdef extern from *:
    """
    #if defined(__GNUC__) || defined(__clang__)
    #define ISOEMBED_PREFETCH(address) __builtin_prefetch(address)
    #else
    #define ISOEMBED_PREFETCH(address) ((void) (address))
    #endif
    """
    void ISOEMBED_PREFETCH(const void *address) noexcept nogil

ctypedef fused Number:
    float
    double


cdef inline void prefetch(Number[::1] values, long long first, long long last) noexcept nogil:
    cdef long long i = max(first, 0), end = min(last, <long long> values.shape[0])
    while i < end:
        ISOEMBED_PREFETCH(&values[i])
        i += 64 // <long long> sizeof(Number)
