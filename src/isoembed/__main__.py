"""Run the command as ``python -m isoembed``."""

import sys

from isoembed.cli import main

if __name__ == "__main__":
    sys.exit(main())
