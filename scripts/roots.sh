# Sourced after common.sh by scripts that try Omma in roots of other systems, made with debootstrap.
# shellcheck shell=bash
[ "$(id -u)" = 0 ] || fail "a root is made and entered as root"

# One at a time: a root that is being made is no root yet.
mkdir -p build
exec {roots_lock}> build/roots.lock
flock "$roots_lock"

suites_known=(jammy noble trixie bookworm)  # Ubuntu 22.04, 24.04, Debian 13, 12
is_suite() { [[ " ${suites_known[*]} " == *" $1 "* ]]; }

# Where a run was killed the system's own folders may still be mounted in it.
remove_root() {
  local folder
  while read -r folder; do umount --lazy "$folder"; done \
    < <(awk -v root="$1/" 'index($2, root) == 1 { print $2 }' /proc/mounts | sort -r)
  rm -rf --one-file-system "$1"
}

# make_root SUITE FOLDER [PACKAGES]: a root of the smallest kind and these packages, comma-separated.
make_root() {
  local suite="$1" root="$2" script="" options=(--variant=minbase)
  if [ -e "$root/made" ]; then return; fi
  say "Making a root of $suite"
  remove_root "$root"
  mkdir -p "$root"
  [ -z "${3:-}" ] || options+=("--include=$3")
  case "$suite" in
    jammy | noble)
      options+=("--components=main,universe")
      # Where the system has no keys of Ubuntu's there is nothing to check against.
      [ -e /usr/share/keyrings/ubuntu-archive-keyring.gpg ] || options+=(--no-check-gpg)
      # The recipe of all newer Ubuntus is one; an older debootstrap does not know their names.
      [ -e "/usr/share/debootstrap/scripts/$suite" ] || script=/usr/share/debootstrap/scripts/gutsy
      ;;
  esac
  # No mirror is named, so that debootstrap takes the suite's own; the word for that is "".
  debootstrap "${options[@]}" "$suite" "$root" "" ${script:+"$script"} > "$root.log" 2>&1 \
    || fail "debootstrap could not make $suite; see $root.log"
  touch "$root/made"
}

# What is mounted in a root is taken out again however this ends, or removing the root would reach
# into the system's own folders.
mounted=()
unmount() {
  local folder
  for folder in "${mounted[@]}"; do umount --lazy "$folder"; done
  mounted=()
}
trap unmount EXIT

variables=()  # of the environment in a root
mount_root() {
  local root="$1" folder
  for folder in proc dev; do
    mount --bind "/$folder" "$root/$folder"
    mounted+=("$root/$folder")
  done
  # Names and certificates as here, so that what installs here installs there.
  cp --remove-destination /etc/resolv.conf "$root/etc/resolv.conf"
  variables=(HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 PIP_ROOT_USER_ACTION=ignore)
  if [ -e /etc/ssl/certs/ca-certificates.crt ]; then
    cp /etc/ssl/certs/ca-certificates.crt "$root/etc/host-certificates.crt"
    variables+=(PIP_CERT=/etc/host-certificates.crt)
  fi
}

# in_root ROOT COMMAND...
in_root() {
  local root="$1"
  shift
  chroot "$root" /usr/bin/env -i "${variables[@]}" "$@"
}
