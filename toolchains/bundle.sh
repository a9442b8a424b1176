#!/bin/bash
# Makes an update of an image: root, kernel and initrd of its system A, signed, as `rauc install` takes it on a board. docs/board.md says how.
#
#   toolchains/bundle.sh KEY CERTIFICATE [IMAGE [BUNDLE]]     after toolchains/image.sh; default build/image/ninedot-arm64.img and .raucb
#
# KEY and CERTIFICATE: PEM files of the owner's, or PKCS#11 addresses; boards have the certificate, or the one that it was signed with, as
# update-keyring.pem. The key is read by RAUC alone.
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."
fail() { echo "bundle.sh: $*" >&2; exit 2; }
[[ $# -ge 2 && $# -le 4 ]] || fail "say with what to sign: toolchains/bundle.sh KEY CERTIFICATE [IMAGE [BUNDLE]]"
key=$1 certificate=$2 image=${3:-build/image/ninedot-arm64.img}
bundle=${4:-${image%.img}.raucb}
for tool in rauc mksquashfs unsquashfs sfdisk python3; do command -v "$tool" > /dev/null || fail "needs $tool: ./dev packages image"; done
for file in "$key" "$certificate"; do [[ $file == pkcs11:* || -r $file ]] || fail "cannot read $file"; done
[[ -s $image ]] || fail "no $image: ./dev image"

table=$(sfdisk --json "$image" 2> /dev/null) && [[ $(grep -c '"node"' <<< "$table") -ge 7 ]] || fail "$image is no image of a board: ./dev image"
# partition NUMBER: where it begins and how long it is, in MiB, which all of them are whole multiples of.
partition() {
  python3 -c '
import json, sys
entry = json.load(sys.stdin)["partitiontable"]["partitions"][int(sys.argv[1]) - 1]
print(entry["start"] // 2048, entry["size"] // 2048)' "$1" <<< "$table"
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/content"
read -r first count < <(partition 2)
dd if="$image" of="$work/content/root.img" bs=1M skip="$first" count="$count" conv=sparse status=none
# A squashfs says how long it is, in bytes 40 to 47; what comes behind is the place that is left.
[[ $(head -c 4 "$work/content/root.img") == hsqs ]] || fail "$image has no root where system A's should be"
used=$(od -A n -t u8 -j 40 -N 8 "$work/content/root.img" | tr -d ' ')
truncate -s $(((used + 4095) / 4096 * 4096)) "$work/content/root.img"
read -r first count < <(partition 6)
dd if="$image" of="$work/content/boot.img" bs=1M skip="$first" count="$count" conv=sparse status=none
version=$(unsquashfs -cat "$work/content/root.img" usr/lib/os-release | sed -n 's/^IMAGE_VERSION=//p')
[[ -n $version ]] || fail "the root of $image does not say its version"
# Boards take what is made for them: the image's own setting says for which.
compatible=$(unsquashfs -cat "$work/content/root.img" etc/rauc/system.conf | sed -n 's/^compatible=//p')
[[ -n $compatible ]] || fail "the root of $image does not say for which boards it is"
cat > "$work/content/manifest.raucm" << END
[update]
compatible=$compatible
version=$version

[bundle]
format=verity

[image.rootfs]
filename=root.img

[image.boot]
filename=boot.img
END
rm -f "$bundle"
# The root is packed already.
rauc bundle --cert="$certificate" --key="$key" --mksquashfs-args="-comp zstd -Xcompression-level 9 -no-progress -quiet" "$work/content" "$bundle" > "$work/log" 2>&1 ||
  { cat "$work/log" >&2; fail "RAUC could not make the bundle"; }
echo "== $bundle: for $compatible, version $version, $(($(stat -c %s "$bundle") / 1048576)) MiB"
