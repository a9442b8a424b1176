#!/bin/bash
# The Debian package, from building it to purging it: installs, starts, upgrades keeping the configuration, removes, purges.
#
# It changes the machine that it runs on, so it insists on being told that the machine is for throwing away:
#   tests/fresh_debian.sh trixie env NINEDOT_THROWAWAY=1 tests/package/install_test.sh
set -euo pipefail
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.."

[[ ${NINEDOT_THROWAWAY:-} == 1 && $EUID -eq 0 ]] || { echo "install_test.sh: needs root on a machine for throwing away: set NINEDOT_THROWAWAY=1" >&2; exit 2; }

config=/etc/ninedot/ninedot.toml
checks=0
expect() {  # WHAT COMMAND...
  local what=$1; shift
  if ! "$@" > /tmp/ninedot-expect.log 2>&1; then
    echo "FAILED: $what: $*" >&2; cat /tmp/ninedot-expect.log >&2
    exit 1
  fi
  checks=$((checks + 1)); echo "ok: $what"
}
not() { ! "$@"; }
install_package() { DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Dpkg::Use-Pty=0 install --no-install-recommends "$@" < /dev/null; }
newest() { ls -t build/release/package/ninedot_*.deb | head -n 1; }

./dev packages package test
./dev package
first=$(newest)
expect "installs" install_package "./$first"
expect "has its programs" test -x /usr/bin/ninedotd -a -x /usr/bin/ninedot
expect "made its user" id ninedot
for group in video dialout gpio i2c; do expect "the user is in group $group" bash -c "id -nG ninedot | grep -qw $group"; done
expect "the configuration as installed is accepted" ninedot check --config "$config"
expect "systemd accepts the unit" systemd-analyze verify /lib/systemd/system/ninedotd.service
exposure=$(systemd-analyze security --offline=true /lib/systemd/system/ninedotd.service | sed -n 's/.*exposure level for [^:]*: \([0-9.]*\).*/\1/p')
expect "systemd's exposure level is at most 2.0 ($exposure)" awk -v e="$exposure" 'BEGIN { exit !(e != "" && e <= 2.0) }'
expect "is enabled" test -L /etc/systemd/system/multi-user.target.wants/ninedotd.service

setpriv --reuid ninedot --regid ninedot --init-groups ninedotd --config "$config" > /tmp/ninedotd.log 2>&1 &
service=$!
expect "serves poses as its own user, out of the box" bash -c 'for _ in $(seq 50); do
  mbpoll -m tcp -p 1502 -a 1 -0 -r 0 -c 6 -1 127.0.0.1 | grep -q "^\[0\]:.*40201" && exit 0; sleep 0.1; done; cat /tmp/ninedotd.log; exit 1'
kill "$service"; wait "$service" || true

expect "the page is another package" install_package "./$(ls -t build/release/package/ninedot-web_*.deb | head -n 1)"
expect "made the page's user, who may read the tap" bash -c "id -nG ninedot-web | grep -qw ninedot-tap"
expect "who is in no group of the service's" bash -c "! id -nG ninedot-web | grep -qwE 'ninedot|video|dialout|gpio|i2c'"
expect "systemd accepts its unit" systemd-analyze verify /lib/systemd/system/ninedot-web.service
expect "is not enabled" not test -e /etc/systemd/system/multi-user.target.wants/ninedot-web.service
expect "systemd accepts the units that let it change the configuration" systemd-analyze verify /lib/systemd/system/ninedot-apply.socket /lib/systemd/system/ninedot-apply@.service
expect "which are not enabled" not test -e /etc/systemd/system/sockets.target.wants/ninedot-apply.socket
sed -i 's/^# \[tap\]/[tap]/; s/^# enabled = false/enabled = true/' "$config"
setpriv --reuid ninedot --regid ninedot --init-groups ninedotd --config "$config" > /tmp/ninedotd.log 2>&1 & service=$!
setpriv --reuid ninedot-web --regid ninedot-web --init-groups ninedot-web --config "$config" > /tmp/ninedot-web.log 2>&1 & page=$!
expect "the page shows frames, as its own user" bash -c 'for _ in $(seq 50); do
  python3 -c "import urllib.request as u; print(u.urlopen(\"http://127.0.0.1:8090/api/live?viewer=installtest\").read())" 2> /dev/null |
    grep -q "\"valid\":true" && exit 0; sleep 0.1; done; cat /tmp/ninedotd.log /tmp/ninedot-web.log; exit 1'
expect "others may not read the tap" not setpriv --reuid nobody --regid nogroup --clear-groups ninedot tap
kill "$page" "$service"; wait "$page" "$service" || true
expect "the page is removed alone" env DEBIAN_FRONTEND=noninteractive apt-get -q -y purge ninedot-web
expect "and the service is still there" test -x /usr/bin/ninedotd

sed -i 's/^port = 1502/port = 1503/' "$config"
./dev package -DNINEDOT_PACKAGE_REVISION=2
second=$(newest)
expect "the second package is another one" test "$first" != "$second"
expect "upgrades" install_package "./$second"
expect "the new revision is installed" bash -c "dpkg-query -W -f '\${Version}' ninedot | grep -q -- '-2$'"
expect "keeps the edited configuration" grep -q '^port = 1503' "$config"

expect "is removed" env DEBIAN_FRONTEND=noninteractive apt-get -q -y remove ninedot
expect "its programs are gone" not test -e /usr/bin/ninedotd
expect "its unit is gone" not test -e /lib/systemd/system/ninedotd.service
expect "the configuration is still there" grep -q '^port = 1503' "$config"
expect "is installed again" install_package "./$second"
expect "with the configuration that was there" grep -q '^port = 1503' "$config"
expect "is purged" env DEBIAN_FRONTEND=noninteractive apt-get -q -y purge ninedot
expect "nothing of it is left" bash -c '! find /etc /usr/bin /usr/lib /usr/share /var/lib -path /var/lib/dpkg -prune -o -iname "*ninedot*" -print | grep .'
echo "$checks checks passed"
