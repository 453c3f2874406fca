"""Exit statuses."""

OK = 0
WRONG = 2
NOT_EMBEDDED = 3
INTERRUPTED = 130
