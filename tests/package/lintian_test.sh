#!/bin/bash
# Debian's own check of packages finds no error in ours. Warnings are shown and fail nothing: ours have no manual pages, and their change log is in
# another form than Debian's.
#
#   tests/package/lintian_test.sh [PACKAGE...]     default: what ./dev package, ./dev cross (with and without --backports) and
#                                                  toolchains/modules.sh have made last
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."
source toolchains/roots.sh

command -v lintian > /dev/null || roots_fail "needs lintian: ./dev packages package-test"
packages=("$@")
if [[ $# -eq 0 ]]; then
  # Quoted: of each pattern, and not of each file, the newest.
  for pattern in build/{release,package-{arm64,armhf}{,-backports}}/package/{ninedot,ninedot-web}"_*.deb" "$ninedot_cache/modules-*/*.deb"; do
    # shellcheck disable=SC2086
    if compgen -G "$pattern" > /dev/null; then packages+=("$(ls -t $pattern | head -n 1)"); fi
  done
fi
[[ ${#packages[@]} -gt 0 ]] || roots_fail "no packages: ./dev package"
found=$(mktemp)
trap 'rm -f "$found"' EXIT
status=0
lintian --allow-root --profile debian --fail-on error --tag-display-limit 0 "${packages[@]}" > "$found" 2>&1 || status=$?
cat "$found"
# A check that could not be made is none.
[[ $status -eq 0 ]] || { echo "FAILED: lintian, status $status, $(grep -c '^E:' "$found" || true) errors" >&2; exit 1; }
echo "ok: lintian: no error, $(grep -c '^W:' "$found" || true) warnings in ${#packages[@]} packages: $(basename -a "${packages[@]}" | tr '\n' ' ')"
