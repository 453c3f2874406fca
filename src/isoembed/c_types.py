"""C types of compiled modules, declared in ``c_types.pxd``: Python types for interpreted runs."""

Int = ConstInt = Int32 = ConstInt32 = Int8 = Flag = ConstFlag = Byte = ConstByte = int
Real = ConstReal = Single = float
Complex = ConstComplex = complex
