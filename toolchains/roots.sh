# shellcheck shell=bash disable=SC2034
# Sourced by the scripts that make Debian roots: where caches are, which archive, which release, a private /dev, other machines' programs.

# One place for everything that is costly to make and can be made again. NINEDOT_CACHE: where.
ninedot_cache=${NINEDOT_CACHE:-${XDG_CACHE_HOME:-/var/tmp}/ninedot-cache}
ninedot_suite=trixie

roots_fail() { echo "$(basename "$0"): $*" >&2; exit 2; }

# The archive: NINEDOT_MIRROR, or the one that this machine's apt uses.
debian_mirror() {
  local mirror=${NINEDOT_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' | sort -u | head -n 1)}
  [[ -n $mirror ]] || roots_fail "no Debian archive in this machine's apt sources: set NINEDOT_MIRROR"
  echo "$mirror"
}

# The board's sources with security fixes and stable updates. NINEDOT_SECURITY_MIRROR: default beside the archive, as deb.debian.org has it.
board_sources() {
  local mirror security
  mirror=$(debian_mirror)
  security=${NINEDOT_SECURITY_MIRROR:-${mirror%/}-security}
  printf 'deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] %s %s main non-free-firmware\n' "$mirror" "$ninedot_suite" "$mirror" "$ninedot_suite-updates" "$security" "$ninedot_suite-security"
}

# The release's backports, for libcamera and a kernel that know the Raspberry Pi 5: these source packages come from there, all else stays the release's own.
ninedot_backports=$ninedot_suite-backports
backports_pin="Package: src:libcamera:any src:linux:any src:linux-signed-arm64:any
Pin: release n=$ninedot_backports
Pin-Priority: 500"
backports_source() {
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $(debian_mirror) $ninedot_backports main"
}
# For new_root, with backports_pin in the environment.
# shellcheck disable=SC2016
backports_hook='--setup-hook=mkdir -p "$1/etc/apt/preferences.d" && echo "$backports_pin" > "$1/etc/apt/preferences.d/backports"'

# root_failed WHAT LOG SUITE: in one line where the archive is the reason, else with the end of what was said.
root_failed() {
  if grep -q '^E: apt-get update' "$2"; then
    roots_fail "$1 failed: $(debian_mirror) can't be reached or has no $3; set NINEDOT_MIRROR to an archive that has it"
  fi
  tail -n 20 "$2" >&2
  roots_fail "$1 failed; its whole output: $2"
}

require_root() { [[ $EUID -eq 0 ]] || roots_fail "needs root for chroot and mounts: run it with sudo"; }

# The time that everything made here bears: that of the last commit.
source_date_epoch() {
  echo "${SOURCE_DATE_EPOCH:-$(git -c safe.directory='*' log -1 --format=%ct 2> /dev/null || echo 0)}"
}

# Lets the kernel start programs of ARCH by QEMU's emulator, in roots as well. It stays so until the machine restarts.
require_emulation() {
  local arch=$1 name=qemu-aarch64 table=/proc/sys/fs/binfmt_misc line
  [[ $arch == armhf ]] && name=qemu-arm
  [[ $(dpkg --print-architecture) != "$arch" ]] || return 0
  [[ -e $table/register ]] || mount -t binfmt_misc binfmt_misc "$table" 2> /dev/null ||
    roots_fail "this kernel has no binfmt_misc to run $arch programs with: use one that has, or a machine of that architecture"
  [[ ! -e $table/$name ]] || return 0
  line=$(cat "/usr/lib/binfmt.d/$name.conf" 2> /dev/null) || roots_fail "needs qemu-user-static: ./dev packages image"
  echo "$line" > "$table/register" 2> /dev/null || roots_fail "cannot register $name with the kernel (binfmt_misc)"
}

# new_root MMDEBSTRAP-ARGUMENT... < SOURCES: mmdebstrap with its mounts in a namespace of their own, so that a run that is killed leaves none.
new_root() {
  unshare --mount --propagation private --pid --fork --kill-child --mount-proc /bin/bash -c '
    mount -t binfmt_misc binfmt_misc /proc/sys/fs/binfmt_misc 2> /dev/null || true
    exec mmdebstrap --quiet --mode=root --aptopt="APT::Install-Recommends \"0\"" "$@"' new_root "$@"
}

# in_root ROOT SOURCE COMMAND...: runs the command in the root, in the folder SOURCE seen as /ninedot. Mounts live in a
# namespace of their own, gone when the command ends; a /dev of its own keeps this machine's devices out of reach.
in_root() {
  local root=$1 source=$2; shift 2
  # shellcheck disable=SC2016
  unshare --mount --propagation private --pid --fork --kill-child /bin/bash -c '
    set -euo pipefail
    root=$1 source=$2; shift 2
    mkdir -p "$root/ninedot" "$root/dev" "$root/proc"
    mount -t proc proc "$root/proc"
    mount -t tmpfs -o mode=755,nosuid tmpfs "$root/dev"
    node() { mknod -m 666 "$root/dev/$1" c "$2" "$3"; }
    node null 1 3; node zero 1 5; node full 1 7; node random 1 8; node urandom 1 9
    ln -s /proc/self/fd "$root/dev/fd"
    mount --bind "$source" "$root/ninedot"
    exec chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
      ${SOURCE_DATE_EPOCH:+SOURCE_DATE_EPOCH=$SOURCE_DATE_EPOCH} /bin/bash -c "cd /ninedot && \"\$@\"" in_root "$@"
  ' in_root "$root" "$source" "$@" < /dev/null
}
