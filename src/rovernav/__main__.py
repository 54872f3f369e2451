"""``python -m rovernav`` is the command ``rovernav``."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
