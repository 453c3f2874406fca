"""Files that are damaged: whatever is done to one, it is read or refused in one sentence."""

import random
import warnings

from isoembed.errors import InvalidMetric, MeshNote
from isoembed.io import FileError, read_metric


def damaged(data, step=7, seed=0):
    """Yield the bytes cut short every few bytes, with wrong numbers, and with other bytes here and there."""
    yield from (data[:k] for k in range(0, len(data), step))
    for number in (b"12", b"20", b"30", b"60", b"80"):
        for other in (b"-5", b"0", b"7", b"nan", b"99999999999", 30 * b"9", 5000 * b"9"):
            yield data.replace(number, other)
    rng = random.Random(seed)
    for _ in range(200):
        changed = bytearray(data)
        changed[rng.randrange(len(data))] = rng.choice([rng.randrange(256), *b"09-. \n"])
        yield bytes(changed)


def refusals(path, data, read=read_metric):
    """How many of the damaged files are refused; none has another error, or a message that is no sentence."""
    count = 0
    for changed in damaged(data):
        path.write_bytes(changed)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MeshNote)
                read(path)
        except (FileError, InvalidMetric) as error:
            count += 1
            message = str(error).replace(str(path), "")
            assert message and "\n" not in message and len(message) < 250, message
    return count
