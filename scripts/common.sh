# Sourced by the other scripts: goes to the root of the clone and says how packages are installed.
# shellcheck shell=bash
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
[ -t 1 ] || say() { printf '\n%s\n' "$*"; }

fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# What every build needs.
# shellcheck disable=SC2034
build_packages=(g++ cmake ninja-build libembree-dev libtbb-dev libpng-dev libjpeg-dev libwebp-dev
                libopenexr-dev libmeshoptimizer-dev libdraco-dev nlohmann-json3-dev
                libnanoflann-dev python3-dev python3-venv)

# Compute capabilities of cards that kernels are compiled for where no card is.
# shellcheck disable=SC2034
capabilities=(75 80 86 89 90 100 120)

# The second build of the same source is quick where there is a compiler cache.
if command -v ccache > /dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER="${CMAKE_CXX_COMPILER_LAUNCHER:-ccache}"
fi

# Installs those of the named Debian packages that are missing.
need_packages() {
  local missing=() package
  if ! command -v apt-get > /dev/null; then
    if [ "${OMMA_NO_APT:-}" = 1 ]; then return; fi
    fail "there is no apt-get here. Install what these Debian packages contain by other means:
  $*
and run this again with OMMA_NO_APT=1."
  fi
  for package in "$@"; do
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null)" != installed ]; then
      missing+=("$package")
    fi
  done
  if [ ${#missing[@]} = 0 ]; then return; fi

  say "Installing system packages: ${missing[*]}"
  local as_root=(env DEBIAN_FRONTEND=noninteractive)
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo > /dev/null; then
      fail "packages are missing, and there is no sudo. As root, run
  apt-get update && apt-get install ${missing[*]}"
    fi
    as_root=(sudo env DEBIAN_FRONTEND=noninteractive)
  fi
  "${as_root[@]}" apt-get update -qq \
    || printf 'apt-get update failed; trying with the package lists that are here.\n' >&2
  "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" \
    || fail "apt-get could not install: ${missing[*]}
What it says is above. Omma is built and tested on Debian 12."
}

# requirements PYTHON [EXTRA]: what pyproject.toml says the build needs, and the extra, one a line.
requirements() {
  "$1" - "${2:-}" <<'PY'
import sys
try:
    import tomllib
except ImportError:  # Python 3.10
    from pip._vendor import tomli as tomllib
# Not load(): what Python 3.10's pip brings wants a text file there, tomllib a binary one.
with open("pyproject.toml", encoding="utf-8") as file:
    project = tomllib.loads(file.read())
print(*project["build-system"]["requires"], sep="\n")
if sys.argv[1]:
    print(*project["project"]["optional-dependencies"][sys.argv[1]], sep="\n")
PY
}

# install_requirements FOLDER [EXTRA]: these, into a virtual environment.
install_requirements() {
  local lines required
  lines=$(requirements "$1/bin/python" "${2:-}")
  mapfile -t required <<< "$lines"
  "$1/bin/python" -m pip install --quiet --disable-pip-version-check "${required[@]}"
}

# Makes the Python environment build/wheel/tools, with what wheels and releases are made with.
make_tools() {
  [ -x build/wheel/tools/bin/python ] || python3 -m venv build/wheel/tools
  install_requirements build/wheel/tools release
}
