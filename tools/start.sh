#!/bin/sh
# Runs @NAME@, which is Python, with the project's own interpreter, or any that has what it needs.
root='@ROOT@' build='@BUILD@'
for python in "$root/.venv/bin/python" python3; do
  # found, not imported: importing all of it would take as long again as the program's own start
  if "$python" -c 'from importlib.util import find_spec; import sys; sys.exit(None in map(find_spec, "@NEEDS@".split(", ")))' \
    2>/dev/null; then
    # arrays above 4 MB go back to the system when they are freed; left to itself malloc learns to keep them, and each
    # thread keeps its own.
    # Huge pages make a search no faster, and a tenth larger where the machine has any to give
    PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" TALUS_BUILD="$build" PYTHONDONTWRITEBYTECODE=1 \
      OPENBLAS_NUM_THREADS=1 MALLOC_ARENA_MAX=1 MALLOC_MMAP_THRESHOLD_=4194304 \
      MALLOC_TRIM_THRESHOLD_=33554432 NUMPY_MADVISE_HUGEPAGE=0 exec "$python" -m @MODULE@ "$@"
  fi
done
echo '@NAME@: no Python with @NEEDS@ was found; `make deps` installs it' >&2
exit 1
