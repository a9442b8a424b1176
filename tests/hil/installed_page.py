"""The page of the installed packages: its process in its sandbox, and the units that let it record and change what the service reads."""

import http.client
import json
import time

CHECKS = (
    "page",
    "page-records",
    "page-calibrates",
    "apply-off",
    "apply-up",
    "apply-refused",
    "apply-back",
    "apply-stopped",
    "apply-rights",
    "apply-calibration",
)

CONFIG = "/etc/ninedot/ninedot.toml"
# Under emulation; the pauses before a device is tried again begin at 0.1 s and double up to 5 s.
BACK_WITHIN_S = 60
TOKEN = "0123456789abcdef0123456789abcdef"
KEPT = "/var/lib/ninedot-web/calibrations/20261123-121415"

PAGE = """[camera]
source = "recording"
device = "/usr/share/ninedot/recordings/approach"
rate_hz = 10.0
[modbus.tcp]
listen = "0.0.0.0"
[tap]
enabled = true
[web]
listen = "0.0.0.0"
token_file = "/etc/ninedot/token"
recordings = "/var/lib/ninedot-web"
"""


class PageOfInstalled:
    def __init__(self, stage, guest, service):
        self.stage, self.guest, self.service = stage, guest, service

    def request(self, method, path, body=None, headers=()):
        connection = http.client.HTTPConnection("127.0.0.1", self.guest.page_port, timeout=60)
        host = f"127.0.0.1:{self.guest.page_port}"
        own = {"Authorization": f"Bearer {TOKEN}", "Host": host}
        if method == "POST":
            own["Origin"] = f"http://{host}"
        connection.request(method, path, body, {**own, **dict(headers)})
        reply = connection.getresponse()
        return reply.status, reply.read()

    def is_there(self):
        self.guest.check(f"(umask 077; echo {TOKEN} > /etc/ninedot/token); chown ninedot-web /etc/ninedot/token; systemctl start --no-block ninedot-web")
        deadline = time.monotonic() + BACK_WITHIN_S
        while True:
            try:
                status, body = self.request("GET", "/api/live?viewer=installedtest")
                if status == 200 and b'"valid":true' in body:
                    break
            except OSError:
                status, body = 0, b""
            if time.monotonic() > deadline:
                raise AssertionError(f"the page shows no frame: {status} {body[:200]}; {self.service.journal('ninedot-web')}")
            time.sleep(0.3)
        owner = self.guest.check("stat -c %U /proc/$(systemctl show -P MainPID ninedot-web)")
        self.stage.ok("page", owner == "ninedot-web", f"frames with their poses, as user {owner}")
        status, body = self.request("POST", "/api/recordings", "start")
        time.sleep(5)
        stopped, _ = self.request("POST", "/api/recordings", "stop")
        time.sleep(3)
        files = self.guest.check("find /var/lib/ninedot-web/ -name '*.png' | wc -l; stat -L -c '%U %a' /var/lib/ninedot-web").split("\n")
        self.stage.ok(
            "page-records",
            status == stopped == 200 and int(files[0]) > 0 and files[1] == "ninedot-web 700",
            f"{files[0]} pictures in its own folder ({files[1]}); {status} {body.decode()[:120]}",
        )

    def calibrates(self):
        """The wizard is a child of the page's, and has its sandbox."""
        started, body = self.request("POST", "/api/calibrate", "start camera")
        deadline = time.monotonic() + BACK_WITHIN_S
        state = {}
        while started == 200 and time.monotonic() < deadline:
            state = json.loads(self.request("GET", "/api/calibrate")[1])
            # The recording's landmark never stands still, so that none of it is taken; that it is seen is enough.
            if state["phase"] != "running" or (state["news"] or {}).get("sheet"):
                break
            time.sleep(0.5)
        news = state.get("news") or {}
        folder = self.guest.run("stat -c '%U %a' /var/lib/ninedot-web/calibrations/*")[1]
        cancelled, _ = self.request("POST", "/api/calibrate", "cancel")
        time.sleep(2)
        left = self.guest.run("ls /var/lib/ninedot-web/calibrations; grep -l 'calibrat[e]' /proc/[0-9]*/cmdline 2> /dev/null")[1]
        self.stage.ok(
            "page-calibrates",
            started == cancelled == 200 and bool(news.get("sheet")) and folder.startswith("ninedot-web ") and not left,
            f"{started}, {state.get('phase')}, the sheet seen at {str((news.get('sheet') or ['nowhere'])[0])}, its folder {folder}; cancelled: {left or 'nothing is left of it'}; "
            f"{body.decode()[:200] if started != 200 else state.get('why', '')}",
        )

    def file(self):
        """The page is away for a moment where it goes by a new file."""
        for _ in range(20):
            try:
                return json.loads(self.request("GET", "/api/configuration")[1])
            except OSError:
                time.sleep(0.5)
        raise AssertionError(f"the page does not come back; {self.service.journal('ninedot-web')}")

    def apply(self, text):
        """\\return  (HTTP status, how it ended, its lines)"""
        return self.ended(*self.request("POST", "/api/configuration/apply", text, {"If-Match": self.file()["tag"]}))

    def ended(self, status, body, within_s=200):
        """What came of an answer, as `apply` has it."""
        if status != 202:
            return status, "", body.decode()
        deadline = time.monotonic() + within_s
        while time.monotonic() < deadline:
            try:
                state = json.loads(self.request("GET", "/api/configuration/apply")[1])
            except OSError:  # the page goes by the new file
                time.sleep(0.3)
                continue
            if state["state"] != "running":
                return status, state["state"], " | ".join(state["lines"])
            time.sleep(0.5)
        raise AssertionError(f"no end of it: {state}; {self.guest.check('journalctl -q -o cat -u ninedot-apply@* --no-pager | tail -n 20')}")

    def applies(self):
        changed = PAGE.replace("rate_hz = 10.0", "rate_hz = 12.0")
        status, _, text = self.apply(changed)
        self.stage.ok("apply-off", status == 403 and self.guest.check(f"cat {CONFIG}").strip() == PAGE.strip(), f"{status}: {text.strip()}")
        self.guest.check("systemctl enable --now ninedot-apply.socket 2>&1")
        rights = self.guest.check(f"stat -c '%U:%G %a' {CONFIG}")
        process = self.service.show("MainPID")
        status, end, text = self.apply(changed)
        now = self.guest.check(f"cat {CONFIG}")
        self.stage.ok(
            "apply-up",
            end == "up" and now.strip() == changed.strip() and process != self.service.show("MainPID") and self.guest.check(f"cat {CONFIG}.before").strip() == PAGE.strip(),
            f"{status} {end}: {text}",
        )
        self.stage.ok(
            "apply-rights",
            self.guest.check(f"stat -c '%U:%G %a' {CONFIG}") == rights
            and self.guest.run("setpriv --reuid ninedot --regid ninedot --init-groups busybox nc local:/run/ninedot-apply.socket < /dev/null")[0] != 0
            and self.guest.check("stat -c '%U:%G %a' /run/ninedot-apply.socket") == "root:ninedot-web 660",
            f"the file is {rights} as before; the socket is the page's alone",
        )
        process = self.service.show("MainPID")
        status, end, text = self.apply(changed.replace("recordings/approach", "recordings/nowhere"))
        self.stage.ok(
            "apply-refused",
            end == "refused" and self.guest.check(f"cat {CONFIG}") == now and self.service.show("MainPID") == process and "/usr/share/ninedot/recordings/nowhere" in text,
            f"{status} {end}: {text}",
        )
        # A right file, with which the service still does not come up.
        self.fault("ExecStartPre=/bin/sh -c '! grep -q \"rate_hz = 13\" /etc/ninedot/ninedot.toml'")
        status, end, text = self.apply(changed.replace("12.0", "13.0"))
        self.service.wait_for(lambda registers: registers.valid, "poses by the old file")
        self.stage.ok("apply-back", self.is_as_before(now) and end == "back", f"{status} {end}: {text}")
        self.fault("ExecStartPre=/bin/sleep 15")
        before = self.file()["tag"]
        self.request("POST", "/api/configuration/apply", changed.replace("12.0", "14.0"), {"If-Match": before})
        self.guest.check(f"for _ in $(seq 200); do grep -q 'rate_hz = 14' {CONFIG} && break; sleep 0.1; done; grep -q 'rate_hz = 14' {CONFIG}", 60)
        self.guest.check("systemctl stop 'ninedot-apply@*'", 120)
        self.service.wait_for(lambda registers: registers.valid, "poses by the old file")
        self.stage.ok("apply-stopped", self.is_as_before(now), f"stopped while the service was starting: {self.apply_state()}")
        self.guest.check("rm /run/systemd/system/ninedotd.service.d/fault.conf; systemctl daemon-reload")
        self.uses_calibration(now)

    def uses_calibration(self, config):
        """One that the wizard made, of a service whose configuration names none."""
        self.guest.check(f"mkdir -p {KEPT} && cp /usr/share/ninedot/recordings/approach/camera.yaml {KEPT} && chown -R ninedot-web {KEPT} && chmod 600 {KEPT}/camera.yaml")
        status, end, text = self.ended(*self.request("POST", "/api/calibrate", f"use {KEPT.rpartition('/')[2]}"))
        rights = self.guest.run(f"stat -c '%U:%G %a' {CONFIG} /etc/ninedot/camera.yaml; cmp {KEPT}/camera.yaml /etc/ninedot/camera.yaml")[1].split("\n")
        named = config.replace("[camera]\n", '[camera]\ncalibration = "camera.yaml"\n')
        self.stage.ok(
            "apply-calibration",
            end == "up" and self.guest.check(f"cat {CONFIG}") == named and len(rights) == 2 and rights[0] == rights[1],
            f"{status} {end}: {text}; configuration and calibration: {' and '.join(rights)}",
        )

    def fault(self, line):
        self.guest.write("/run/systemd/system/ninedotd.service.d/fault.conf", f"[Service]\n{line}")
        self.guest.check("systemctl daemon-reload")

    def is_as_before(self, text):
        return self.guest.check(f"cat {CONFIG}") == text and self.guest.run(f"ls {CONFIG}.last-good")[0] != 0

    def apply_state(self):
        state = json.loads(self.request("GET", "/api/configuration/apply")[1])
        return f"{state['state']}: {' | '.join(state['lines'])}"
