#!/bin/bash
# The page in headless Chromium, and hostile requests, against a running service: fourteen minutes.
#   tests/web/run.sh [smoke|pictures|ar]      pictures: build/release/web/
# smoke: the part that ctest runs; pictures: those of docs/page.md, made anew; ar: the view AR alone. NINEDOT_BIN_DIR: where the programs are; default build/release/bin
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")"
case ${1:-} in
  '' | smoke | pictures | ar) ;;
  *) echo "tests/web: unknown part '$1': smoke, pictures or ar" >&2; exit 2 ;;
esac

# Left out, with the reason; status 77.
leave_out() {
  echo "tests/web: LEFT OUT: $*" >&2
  exit 77
}
for needed in chromium node npm; do
  command -v "$needed" > /dev/null || leave_out "$needed is not installed: ./dev packages web node"
done
if [[ ! -d node_modules/playwright-core ]]; then
  PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-audit --no-fund --ignore-scripts > /dev/null 2>&1 ||
    leave_out "npm can't get playwright-core: is the network there?"
fi
if [[ ${1:-} == smoke ]]; then
  [[ -z ${CI:-} ]] || leave_out "in CI all of it is run by itself"
  exec node --test --test-name-pattern "light, on a desktop|both word orders|nothing found|each disc" page_test.mjs
fi
if [[ ${1:-} == pictures ]]; then
  node --test --test-name-pattern "is shown|nothing found" page_test.mjs
  node --test --test-name-pattern "is shown" aim_test.mjs
  node --test --test-name-pattern "is shown" recordings_test.mjs
  node --test --test-name-pattern "is shown" ar_test.mjs
  node --test --test-name-pattern "is shown" configuration_test.mjs
  node --test --test-name-pattern "is shown" calibrate_test.mjs
  node --test --test-name-pattern "is shown" calibrate_head_test.mjs
  node --test --test-name-pattern "is shown" map_test.mjs
  made=${NINEDOT_WEB_PICTURES:-${NINEDOT_BIN_DIR:-../../build/release/bin}/../web}
  cp "$made/live-light-desktop.png" ../../docs/page-live.png
  cp "$made/live-nothing.png" ../../docs/page-live-nothing.png
  cp "$made/focus-light-desktop.png" ../../docs/page-focus.png
  cp "$made/calibrate-light-desktop.png" ../../docs/page-calibrate.png
  cp "$made/calibrate-head-light-desktop.png" ../../docs/page-calibrate-head.png
  cp "$made/health-light-desktop.png" ../../docs/page-health.png
  cp "$made/registers-dark-desktop.png" ../../docs/page-registers.png
  cp "$made/map-light-desktop.png" ../../docs/page-map.png
  cp "$made/map-build-light-desktop.png" ../../docs/page-map-build.png
  cp "$made/aim-light-desktop.png" ../../docs/page-aim.png
  cp "$made/recordings-light-desktop.png" ../../docs/page-recordings.png
  cp "$made/ar-dark-desktop.png" ../../docs/page-ar.png
  cp "$made/configuration-light-desktop.png" ../../docs/page-configuration.png
  cp "$made/live-dark-phone.png" ../../docs/page-phone.png
  exit
fi
# A file that takes so long hangs: the longest of them needs four minutes.
run() {
  local status=0
  timeout --kill-after=10 900 node --test "$@" || status=$?
  ((status != 124)) || echo "tests/web: $1 was not finished after 900 s" >&2
  return "$status"
}
if [[ ${1:-} == ar ]]; then
  [[ -d ../../programs/web/ar/node_modules ]] || leave_out "three.js is not there: ./dev ar, then ./dev build"
  run ar_test.mjs
  exit
fi
run page_test.mjs
run aim_test.mjs
run recordings_test.mjs
run configuration_test.mjs
run calibrate_test.mjs
run calibrate_head_test.mjs
run map_test.mjs
if [[ -d ../../programs/web/ar/node_modules ]]; then
  run ar_test.mjs
else
  echo "tests/web: the view AR: LEFT OUT: ./dev ar fetches what it draws with; then build ninedot-web again" >&2
fi
run hostile_test.mjs
