#!/bin/bash
# Would the tests notice? Breaks the product on purpose, one line at a time, and asks the check that should turn red.
#
#   tests/mutation.sh [--hil] [--again] [PATTERN]     PATTERN: a part of a file's name, of a line or of a check; all without it
#
# All of it takes about forty minutes on two busy cores, one mutation 2 to 60 s. The list is tests/mutation/mutations.txt. Nothing is
# changed here: everything happens in a copy, build/mutation. What was seen red is remembered there until the broken file or the tests
# of its room change; --again forgets it. --hil: also those that a guest under QEMU has to judge, some minutes each.
# Exit status 1: a mutation survived without a reason given, applies no more, or does not build; or its check is not green without it,
# was not reached (a guest that does not boot), or did not end in time.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
copy=$PWD/build/mutation
python3 tests/mutation/run.py copy "$copy"
# The copy takes the repository's own place for as long as this runs, so that paths are the same and the compiler's cache knows them.
mount='mount --bind "$0" "$PWD" && cd "$PWD" && exec python3 tests/mutation/run.py judge "$@"'
if [[ $EUID -eq 0 ]]; then exec unshare -m bash -c "$mount" "$copy" "$@"; fi
if unshare -rm true 2> /dev/null; then exec unshare -rm bash -c "$mount" "$copy" "$@"; fi
cd "$copy"
exec python3 tests/mutation/run.py judge "$@"
