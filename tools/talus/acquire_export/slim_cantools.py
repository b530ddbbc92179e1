"""cantools without asammdf: where that is installed, python-can imports it for a reader of MDF that nobody asks for here, and the
export would begin with 100 MB more."""

import sys

NAME = "asammdf"
if NAME in sys.modules:
    import cantools
else:
    sys.modules[NAME] = None  # importing it fails
    try:
        import cantools
    finally:
        del sys.modules[NAME]

__all__ = ["cantools"]
