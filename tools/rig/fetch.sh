# fetch.sh: packages into the cache folder, unpacked and never installed. Sourced by run.
#
# The mirror is whatever the machine's own apt uses; nothing here needs root. Each package is
# fetched once: the folder .rig/NAME is the stamp.

cache=${TALUS_RIG:-$root/.rig}

say() { echo "rig: $*" >&2; }
die() {
  say "$*"
  exit 1
}

# options that keep apt's lists of another suite beside the machine's own
apt_folder() { # apt_folder FOLDER
  echo "-oDir::Etc::sourcelist=/dev/null -oDir::Etc::sourceparts=$1/sources -oDir::State::lists=$1/lists" \
    "-oDir::Cache=$1/cache"
}

# unpack NAME PATTERN...: downloads the packages whose names apt resolves from PATTERN, and unpacks
# all of them into .rig/NAME. $apt_options may point apt elsewhere.
unpack() {
  local name=$1 folder
  shift
  [ ! -d "$cache/$name" ] || return 0
  command -v apt-get >/dev/null || die "$name: needs Debian's apt-get to fetch $*"
  say "fetching $*"
  folder=$cache/tmp-$name
  rm -rf "$folder"
  mkdir -p "$folder/debs" "$folder/tree"
  # shellcheck disable=SC2086
  (cd "$folder/debs" && apt-get ${apt_options:-} -qq download "$@" 2>"$folder/log") ||
    die "$name: apt-get cannot download $*: $(grep -m 1 '^E:' "$folder/log"); try apt-get update"
  for deb in "$folder"/debs/*.deb; do dpkg -x "$deb" "$folder/tree"; done
  mv "$folder/tree" "$cache/$name"
  rm -rf "$folder"
}

# unpack_backports NAME PACKAGE...: the same from this release's backports, on the same mirror
unpack_backports() {
  local folder=$cache/backports site release keys=/usr/share/keyrings/debian-archive-keyring.gpg
  [ ! -d "$cache/$1" ] || return 0
  read -r site release <<<"$(apt-get indextargets --format '$(SITE) $(CODENAME)' \
    'Created-By: Packages' 'Component: main' 'Origin: Debian' | grep -v -e '-security$' -e '-updates$' -e '-backports$' |
    head -n 1)"
  [ -n "$release" ] || die "$1: no Debian release among apt's sources"
  mkdir -p "$folder/sources" "$folder/lists/partial" "$folder/cache/archives/partial"
  printf 'Types: deb\nURIs: %s\nSuites: %s-backports\nComponents: main\n' "$site" "$release" \
    >"$folder/sources/backports.sources"
  [ ! -e $keys ] || echo "Signed-By: $keys" >>"$folder/sources/backports.sources"
  # shellcheck disable=SC2046
  apt-get $(apt_folder "$folder") -qq update 2>"$folder/log" ||
    die "$1: $release-backports cannot be read: $(tail -n 1 "$folder/log")"
  apt_options=$(apt_folder "$folder") unpack "$@"
}
