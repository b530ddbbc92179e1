# guest.sh: runs a command in a guest kernel whose root is this machine's file system. Sourced by run.
#
# What goes in: the command and the environment, in a file beside the guest's init. What comes out: what
# the command prints, and its exit status in a file, so that a guest that dies is no success.

# what the tests are told about where things are; the same in every rig
rig_environment() {
  env PATH="$(dirname "$python"):$cache/can-utils/usr/bin:$PATH" PYTHONPATH="$root/tools" PYTHONDONTWRITEBYTECODE=1 \
    TALUS_BUILD="${TALUS_BUILD:-$root/build}" TALUS_RIG="$cache" OPENBLAS_NUM_THREADS=1 "$@"
}

# the file that the guest's init runs: environment, folder, command
write_command() { # write_command FILE COMMAND...
  local file=$1 name
  shift
  {
    rig_environment env | grep -E '^(PATH|PYTHONPATH|PYTHONDONTWRITEBYTECODE|TALUS_[A-Z_]*|OPENBLAS_NUM_THREADS|HOME|LANG)=' |
      while IFS= read -r name; do printf 'export %q\n' "$name"; done
    printf 'cd %q\n' "$root"
    printf '%q ' "$@"
    echo
  } >"$file"
}

# the guest's words from when it is up, without its boot's
guest_words() { # guest_words FOLDER
  sed -u 's/\r$//' | tee "$1/log" | sed -u -e '0,/^rig: up$/d' -e '/^rig: down$/,$d'
}

# The guest's status becomes the caller's.
finish_guest() { # finish_guest FOLDER
  local status
  status=$(cat "$1/status" 2>/dev/null || true)
  if [ -z "$status" ]; then
    tail -n 20 "$1/log" >&2
    say "the guest ended without a result; its last words are above"
    status=1
  fi
  rm -rf "$1"
  return "$status"
}

# ---- user mode linux: CAN at near native speed ------------------------------------

# UML keeps the guest's memory in a file, by itself in /dev/shm, which containers make too small
memory_folder() {
  local free
  free=$(df -m --output=avail /dev/shm 2>/dev/null | tail -n 1)
  [ "${free:-0}" -gt 1400 ] && echo /dev/shm || echo "${TMPDIR:-/tmp}"
}

# The guest's kernel stops and resumes each of its processes at every call. On one processor that is a switch; between two it
# wakes an idle one each time, which under a hypervisor takes five times as long.
last_processor() { taskset -cp $$ | sed 's/.*[^0-9]//'; }

in_uml() {
  local folder
  [ "$(uname -m)" = x86_64 ] || die "the UML guest exists for x86_64 only"
  folder=$(mktemp -d)
  write_command "$folder/command" "$@"
  sed -e "s|@FOLDER@|$folder|" -e "s|@BUSYBOX@|$cache/busybox/bin/busybox|" \
    -e "s|@MODULES@|$(echo "$cache"/uml/usr/lib/uml/modules/*)|" \
    "$here/uml_init" >"$folder/init"
  chmod +x "$folder/init"
  if [ "$here/uml_xstate.c" -nt "$cache/uml_xstate.so" ]; then
    "${CC:-cc}" -O2 -shared -fPIC -o "$cache/uml_xstate.so" "$here/uml_xstate.c"
  fi
  TMPDIR=$(memory_folder) LD_PRELOAD=$cache/uml_xstate.so taskset -c "$(last_processor)" "$cache/uml/usr/bin/linux.uml" mem="${TALUS_RIG_MEMORY:-1280M}" rootfstype=hostfs rootflags=/ rw init="$folder/init" \
    con=null con0=fd:0,fd:1 quiet loglevel=1 </dev/null 2>&1 | guest_words "$folder" || true
  finish_guest "$folder"
}
