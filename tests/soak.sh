#!/bin/bash
# The service over simulated hours, each with its faults: clients that hang, send rubbish or are too many, maps, a serial line that is cut. 720 are thirty
# days. One takes ten seconds and more.
#
#   tests/soak.sh [HOURS]      after ./dev build; default 1; what was seen: build/soak.jsonl, a line for each hour
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.."

hours=${1:-1} programs=build/release/bin
fail() { echo "soak.sh: $*" >&2; exit 2; }
[[ $hours =~ ^[1-9][0-9]*$ ]] || fail "how many simulated hours? tests/soak.sh [HOURS]"
[[ -x $programs/ninedotd ]] || fail "no $programs/ninedotd: ./dev build"
command -v socat > /dev/null || fail "needs socat: ./dev packages test"
exec python3 tests/soak/soak.py "$programs" "$hours" --out build/soak.jsonl
