#!/bin/bash
# Tries the project on a fresh Debian: a minimal root with nothing but apt in it, a clean clone of the last commit, one command.
#
#   tests/fresh_debian.sh SUITE [COMMAND...]      as root; SUITE: bookworm (12) or trixie (13); default command: ./dev test
#
# The minimal root is made once by mmdebstrap and unpacked anew each time; downloaded packages are kept between runs.
# NINEDOT_ROOTS: where (default /var/tmp/roots). NINEDOT_MIRROR: the archive (default: the one that this machine's apt uses).
# NINEDOT_BACKPORTS: packages that come from SUITE-backports, for example libcamera-dev (0.7 in place of 0.4 on Debian 13).
set -euo pipefail

fail() { echo "fresh_debian.sh: $*" >&2; exit 2; }

[[ $# -ge 1 ]] || fail "say which release: tests/fresh_debian.sh bookworm|trixie [COMMAND...]"
[[ $EUID -eq 0 ]] || fail "needs root for chroot and mounts: run it with sudo"
command -v mmdebstrap > /dev/null || fail "needs mmdebstrap: apt-get install mmdebstrap"

suite=$1; shift
command=("${@:-./dev}"); [[ $# -gt 0 ]] || command+=(test)
source_dir=$(cd "$(dirname "$0")/.." && pwd)
roots=${NINEDOT_ROOTS:-/var/tmp/roots}
base=$roots/$suite.tar root=$roots/$suite packages=$roots/$suite.packages
mirror=${NINEDOT_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' | sort -u | head -n 1)}
[[ -n $mirror ]] || fail "no Debian archive in this machine's apt sources: set NINEDOT_MIRROR"

mkdir -p "$roots" "$packages"
if [[ ! -s $base ]]; then
  echo "== making a minimal $suite root"
  mmdebstrap --quiet --variant=minbase "$suite" "$roots/part-$suite.tar" "$mirror"
  mv "$roots/part-$suite.tar" "$base"
fi

# Mounts live in a mount namespace of their own: they are gone when the command ends, and nothing of them is ever inside `rm`.
if mountpoint -q "$root/proc" || mountpoint -q "$root/dev"; then fail "$root is in use"; fi
rm -rf --one-file-system "$root"
mkdir -p "$root"
tar -C "$root" -xf "$base" --exclude='./dev/*'
git -c safe.directory='*' clone --quiet --no-hardlinks "$source_dir" "$root/root/ninedot"
cp /etc/resolv.conf "$root/etc/resolv.conf"
if [[ -n ${NINEDOT_BACKPORTS:-} ]]; then
  echo "deb $mirror $suite-backports main" > "$root/etc/apt/sources.list.d/backports.list"
fi
echo "== $suite: $(git -C "$root/root/ninedot" log -1 --format='%h %s'): ${command[*]}"

# A /dev of its own, so that nothing in the root can reach this machine's devices.
inside='
set -euo pipefail
root=$1 packages=$2 suite=$3 backports=$4; shift 4
# A mount of its own, so that tests may make namespaces of mounts in it.
mount --bind "$root" "$root"
mount -t proc proc "$root/proc"
mount -t tmpfs -o mode=755,nosuid tmpfs "$root/dev"
node() { mknod -m 666 "$root/dev/$1" c "$2" "$3"; }
node null 1 3; node zero 1 5; node full 1 7; node random 1 8; node urandom 1 9; node tty 5 0
mkdir "$root/dev/pts" "$root/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666,mode=620,gid=5 devpts "$root/dev/pts"
ln -s pts/ptmx "$root/dev/ptmx"
ln -s /proc/self/fd "$root/dev/fd"
ln -s /proc/self/fd/0 "$root/dev/stdin"
ln -s /proc/self/fd/1 "$root/dev/stdout"
ln -s /proc/self/fd/2 "$root/dev/stderr"
mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"
mount -t sysfs -o ro sysfs "$root/sys"
mount --bind "$packages" "$root/var/cache/apt/archives"
if [[ -n $backports ]]; then
  chroot "$root" apt-get update -qq
  # Of them and what they ask for alone: all else stays that of the release.
  chroot "$root" /usr/bin/env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(printf "%s/$suite-backports " $backports) > /dev/null
  # What else of the same sources is asked for later has to be of the same version: libelf-dev beside a libelf1 that came along.
  chroot "$root" dpkg-query -W -f "\${Version} \${source:Package}\n" | sed -n "s/^[^ ]*~bpo[^ ]* //p" | sort -u |
    while read -r source; do printf "Package: src:%s\nPin: release n=%s-backports\nPin-Priority: 990\n\n" "$source" "$suite"; done > "$root/etc/apt/preferences.d/backports"
fi
exec chroot "$root" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb CI=true \
  /bin/bash -c "cd /root/ninedot && \"\$@\"" ninedot "$@"
'
status=0
started=$SECONDS
unshare --mount --propagation private --pid --fork --kill-child \
  /bin/bash -c "$inside" inside "$root" "$packages" "$suite" "${NINEDOT_BACKPORTS:-}" "${command[@]}" < /dev/null || status=$?
echo "== $suite: exit status $status after $((SECONDS - started)) s"
exit "$status"
