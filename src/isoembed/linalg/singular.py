"""Exception for singular matrices and failed factorizations."""


class SingularMatrix(ArithmeticError):  # noqa: N818  (named for what it says, as InvalidMetric is)
    """The matrix is singular, not positive definite where it has to be, or not finite."""
