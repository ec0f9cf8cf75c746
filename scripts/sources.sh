# Sourced after common.sh by scripts that build Omma for systems of which Debian has no libraries:
# fetches the libraries' sources, as Debian keeps them; and by those that make what wheels need.
# shellcheck shell=bash
sources="$PWD/build/sources"

# fetch_source PACKAGE: Debian 12's source package with its patches, unpacked as
# build/sources/PACKAGE. The system's own lists are not touched; signatures are checked.
fetch_source() {
  local package="$1" lists="$sources/lists" apt
  [ ! -e "$sources/$package" ] || return 0
  mkdir -p "$lists/partial" "$sources/$package.new"
  echo "deb-src http://deb.debian.org/debian bookworm main" > "$sources/sources.list"
  apt=(apt-get -q -o "Dir::Etc::sourcelist=$sources/sources.list" -o Dir::Etc::sourceparts=-
       -o "Dir::State::lists=$lists" -o APT::Sandbox::User=root)
  [ -n "$(find "$lists" -name '*Sources*' -print -quit)" ] \
    || "${apt[@]}" update > "$lists.log" 2>&1 \
    || fail "the list of Debian's sources could not be fetched; see $lists.log"
  (cd "$sources/$package.new" && "${apt[@]}" source "$package") > "$sources/$package.log" 2>&1 \
    || fail "$package's source could not be fetched; see $sources/$package.log"
  mv "$sources/$package.new"/*/ "$sources/$package"
  rm -r "$sources/$package.new"
}

# fetch_file URL SHA256 PATH
fetch_file() {
  curl --silent --show-error --fail --location --output "$3" "$1" || fail "$1 could not be fetched"
  echo "$2  $3" | sha256sum --check --quiet || fail "$1 is not the file that was expected"
}

# The oneTBB of Debian 13, the first that WebAssembly and MinGW can use, as build/sources/onetbb.
fetch_onetbb() {
  local archive="$sources/onetbb.tar.xz"
  [ ! -e "$sources/onetbb" ] || return 0
  mkdir -p "$sources/onetbb.new"
  fetch_file http://deb.debian.org/debian/pool/main/o/onetbb/onetbb_2022.1.0.orig.tar.xz \
    c220a5e4fe452f3a24f562212377dc796d90e8d4e9bfb3392524f18c8f48cd7f "$archive"
  tar -xf "$archive" -C "$sources/onetbb.new" --strip-components=1
  mv "$sources/onetbb.new" "$sources/onetbb"
}
