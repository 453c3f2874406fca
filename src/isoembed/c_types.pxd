# Types of C, for annotations of compiled modules.  Arrays that are only read are of the constant ones.

ctypedef long long Int
ctypedef const long long ConstInt
ctypedef int Int32
ctypedef const int ConstInt32
ctypedef signed char Int8
ctypedef double Real
ctypedef const double ConstReal
ctypedef float Single
ctypedef double complex Complex
ctypedef const double complex ConstComplex
ctypedef unsigned char Flag
ctypedef const unsigned char ConstFlag
ctypedef unsigned char Byte
ctypedef const unsigned char ConstByte
