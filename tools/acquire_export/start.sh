#!/bin/sh
# Runs the export with the project's own Python, or any that has what it needs.
root='@ROOT@' build='@BUILD@'
for python in "$root/.venv/bin/python" python3; do
  if "$python" -c 'import cantools, cffi, numpy, yaml' 2>/dev/null; then
    PYTHONPATH="$root/tools${PYTHONPATH:+:$PYTHONPATH}" TALUS_BUILD="$build" PYTHONDONTWRITEBYTECODE=1 \
      OPENBLAS_NUM_THREADS=1 exec "$python" -m acquire_export "$@"
  fi
done
echo 'talus-acquire-export: no Python with NumPy, cantools, cffi and PyYAML was found; `make deps` installs it' >&2
exit 1
