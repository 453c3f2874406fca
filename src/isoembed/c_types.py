"""Types of C in compiled modules, declared in ``c_types.pxd``; here for those that run as Python."""

Int = ConstInt = Int32 = ConstInt32 = Int8 = Flag = ConstFlag = Byte = ConstByte = int
Real = ConstReal = Single = float
Complex = ConstComplex = complex
