"""Files that appear whole or not at all: temporary name, sync, rename."""

import gzip
import os
import stat

from .refused import Refused


def write(path, content):
    """Bytes to a path; a device or pipe is written as it is."""
    try:
        if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
            with open(path, "wb") as file:
                file.write(content)
            return
        target = os.path.realpath(path)
        temporary = f"{target}.tmp-{os.getpid()}"
        try:
            with open(temporary, "xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, target)
        except OSError:
            if os.path.exists(temporary):
                os.unlink(temporary)
            raise
    except OSError as error:
        raise Refused(1, f"{path}: cannot be written: {error.strerror}") from error


def write_text(path, text):
    content = text.encode()
    write(path, gzip.compress(content, 6, mtime=0) if str(path).endswith(".gz") else content)
