"""Lines of drawn nets."""


def lines_of(drawing, kind):
    """Ends of the folds of a kind, ``"mountain"`` or ``"valley"``."""
    return [fold.line for fold in drawing.folds if fold.kind == kind]
