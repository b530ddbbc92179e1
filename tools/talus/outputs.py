"""Files that appear whole or not at all: temporary name, sync, rename."""

from __future__ import annotations

import gzip
import os
import stat
from collections.abc import Iterable, Mapping
from typing import IO

from .refused import Refused


def write(path: str | os.PathLike[str], chunks: Iterable[bytes]) -> None:
    """Bytes, piece by piece, to a path; a device or pipe is written as it is."""
    try:
        if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
            with open(path, "wb") as file:
                fill(file, path, chunks)
            return
        target = os.path.realpath(path)
        temporary = f"{target}.tmp-{os.getpid()}"
        try:
            with open(temporary, "xb") as file:
                fill(file, path, chunks)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, target)
        except BaseException:
            if os.path.exists(temporary):
                os.unlink(temporary)
            raise
    except OSError as error:
        raise Refused(1, f"{path}: cannot be written: {error.strerror}") from error


def folder_beside(path: str | os.PathLike[str]) -> str | None:
    """Where temporary files may stand: beside an output that is a file, else where the system keeps such."""
    folder = os.path.dirname(os.path.realpath(path))
    is_file = not os.path.exists(path) or stat.S_ISREG(os.stat(path).st_mode)
    return folder if is_file and os.access(folder, os.W_OK) else None


def fill(file: IO[bytes], path: str | os.PathLike[str], chunks: Iterable[bytes]) -> None:
    """The same bytes at any time of day: no name and no time in a compressed file's header."""
    if not str(path).endswith(".gz"):
        file.writelines(chunks)
        return
    with gzip.GzipFile(filename="", mode="wb", compresslevel=6, fileobj=file, mtime=0) as compressed:
        for chunk in chunks:
            compressed.write(chunk)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """A text as a file, whole or not at all."""
    write(path, [text.encode()])


def write_texts(texts: Mapping[str, str]) -> None:
    """Several files, all or none: all are written beside their places first, then renamed."""
    waiting: list[tuple[str, str]] = []
    try:
        for path, text in texts.items():
            temporary = f"{path}.{os.getpid()}.tmp"
            waiting.append((temporary, path))
            with open(temporary, "x", encoding="utf-8") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        for temporary, path in waiting:
            if os.path.isdir(path):
                raise OSError(21, "Is a directory", path)
            os.replace(temporary, path)
    except OSError as error:
        for temporary, _ in waiting:
            if os.path.exists(temporary):
                os.unlink(temporary)
        raise Refused(1, f"{path}: cannot be written: {error.strerror}") from error
