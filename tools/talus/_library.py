"""Loads libtalus.so and declares what the public headers declare."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib.util
import io
import os
import re
import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cffi

_HERE = Path(__file__).resolve().parent
_REPOSITORY = _HERE.parents[1]
_PACKED = _HERE / "_native"  # in an installed package all that `make` builds for Python lies beside it
_BUILD = Path(os.environ.get("TALUS_BUILD") or (_PACKED if _PACKED.is_dir() else _REPOSITORY / "build"))
_LIBRARY = Path(os.environ.get("TALUS_LIBRARY") or _BUILD / "lib" / "libtalus.so")
_FILES = _BUILD / "lib" / "libtalus_files.so"


def _load() -> tuple[Any, Any]:
    header = _BUILD / "python" / "talus_cdef.h"
    for path in (header, _LIBRARY):
        if not path.exists():
            raise ImportError(f"{path} is not there; run `make` in {_REPOSITORY}")
    ffi = _declarations(header)
    # an absolute path: a name without a slash would be looked for among the system's libraries
    return ffi, ffi.dlopen(str(_LIBRARY.resolve()), ffi.RTLD_LAZY)


def _declarations(header: Path) -> Any:
    """What the headers declare. Reading C takes a third of a second: what was read is kept beside the header, where that
    can be written."""
    text = header.read_text()
    name = "talus_cffi_" + hashlib.sha256((cffi.__version__ + text).encode()).hexdigest()[:16]
    kept = header.with_name(f"{name}.py")
    if not kept.exists():
        builder = cffi.FFI()
        builder.set_source(name, None)
        builder.cdef(text)
        try:
            with tempfile.TemporaryDirectory(dir=header.parent, prefix=".cffi-") as folder:
                fresh = Path(folder) / kept.name
                with contextlib.redirect_stdout(io.StringIO()):  # it says what it does
                    builder.emit_python_code(str(fresh))
                fresh.replace(kept)
        except OSError:
            return builder
    spec = importlib.util.spec_from_file_location(name, kept)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.ffi


def _read_constants(text: str) -> SimpleNamespace:
    """Values of the object-like macros: integers, reals, and what follows from them by + - * ( )."""
    macros = dict(re.findall(r"^#define (TL_\w+) (\S.*)$", text, re.MULTILINE))
    number = r"(0[xX][0-9a-fA-F]+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)[uUlLfF]*"
    values = {}
    for name in macros:
        expression = macros[name]
        for _ in macros:  # as deep as definitions can nest
            expression = re.sub(r"TL_\w+", lambda m: "(" + macros.get(m[0], "?") + ")", expression)
        if re.fullmatch(rf"(?:{number}|[-+*() ])+", expression):
            # only digits and operators are left, so this evaluates arithmetic and nothing else
            values[name] = eval(re.sub(number, r"\1", expression))  # noqa: S307
    return SimpleNamespace(**values)


BUILD = _BUILD  # what `make` built: bin/ has the programs
ffi, lib = _load()
constants = _read_constants((_BUILD / "python" / "talus_macros.h").read_text())
constants.TL_VERSION = ".".join(
    str(getattr(constants, f"TL_VERSION_{part}")) for part in ("MAJOR", "MINOR", "PATCH")
)


class TalusError(Exception):
    """A call answered a failure; `status` is its tl_status, e.g. lib.TL_ERR_RANGE.

    >>> try:
    ...     talus.check(talus.lib.tl_model_init(talus.ffi.new("tl_model *"), 99))
    ... except talus.TalusError as error:
    ...     print(error.status == talus.lib.TL_ERR_ARGUMENT, error)
    True invalid argument
    """

    def __init__(self, status: int) -> None:
        super().__init__(ffi.string(lib.tl_status_text(status)).decode())
        self.status = status


def check(status: int) -> None:
    """Raises TalusError unless `status` is TL_OK.

    >>> arm = talus.ffi.new("tl_model *")
    >>> talus.check(talus.lib.tl_model_init(arm, talus.lib.TL_PLANT_PENDULUM))
    """
    if status != lib.TL_OK:
        raise TalusError(status)


class InputError(ValueError):
    """A model or a recording cannot be read; the text names file, line and what was expected, as the programs do.

    >>> try:
    ...     talus.Model.from_text("plant: pendulum\\nmass: 1")
    ... except talus.InputError as error:
    ...     print(error)
    model:2: ...
    """


@functools.cache
def files() -> Any:
    """The programs' own readers and writers of models and recordings (apps/model, apps/recording)."""
    if not _FILES.exists():
        raise ImportError(f"{_FILES} is not there; `make deps` installs what it needs, `make` builds it")
    library = ffi.dlopen(str(_FILES.resolve()), ffi.RTLD_LAZY)
    library.app_tell_notes(0)
    return library



def check_file(result: int, error: Any) -> None:
    """Raises InputError, or OSError where it is no fault of the file, unless `result` is 0; `error` is an app_error."""
    if result == 0:
        return
    text = ffi.string(error.text).decode(errors="replace")
    raise (InputError if error.status == lib.APP_BAD_INPUT else OSError)(text)
