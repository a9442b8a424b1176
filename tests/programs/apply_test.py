"""`ninedot apply` with real services: what comes up is kept, what does not is taken back, and what is cut short leaves a whole file."""

import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from service_harness import APPROACH, BIN, PATIENCE_S, Client, Service, config_text, free_port, run

# As systemctl with Type=notify: it returns when the service answers, or fails with its last words.
RESTART = """#!/bin/bash
cd "$(dirname "$0")"
exec 9> lock; flock 9  # one after the other, as the jobs of systemd
if [[ -e pid ]]; then kill "$(cat pid)" 2> /dev/null; while kill -0 "$(cat pid)" 2> /dev/null; do sleep 0.02; done; fi
echo restart >> restarts
setsid "{bin}/ninedotd" --config ninedot.toml < /dev/null > /dev/null 2> log 9>&- & pid=$!
echo "$pid" > pid
for _ in $(seq 1000); do
  grep -q "read the position with" log && exit 0
  kill -0 "$pid" 2> /dev/null || {{ tail -n 1 log >&2; exit 1; }}
  sleep 0.02
done
echo "no listening service" >&2; exit 1
"""


class Apply(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.config, self.new = self.folder / "ninedot.toml", self.folder / "new.toml"
        self.port = free_port()
        self.old = config_text(port=self.port)
        self.config.write_text(self.old)
        self.script = self.folder / "restart.sh"
        self.script.write_text(RESTART.format(bin=BIN))
        self.script.chmod(0o755)
        self.addCleanup(self.stop)
        subprocess.run([self.script], check=True)

    def stop(self):
        try:
            os.kill(int((self.folder / "pid").read_text()), signal.SIGKILL)
        except (OSError, ValueError):
            pass

    def restarts(self):
        return (self.folder / "restarts").read_text().count("restart")

    def command(self, *options, restart=None):
        return ["apply", "--config", self.config, *options, "--restart", restart or self.script]

    def apply(self, *options, restart=None, **more):
        return run("ninedot", *self.command(*(options or (self.new,)), restart=restart), **more)

    def runs(self, port=None):
        with Client(port=port or self.port) as client:
            client.wait_for(lambda registers: registers[4] & 1)

    def files(self):
        return sorted(path.name for path in self.folder.iterdir() if path.name.startswith("ninedot.toml"))

    def assert_as_it_was(self, restarts=1):
        self.assertEqual(self.config.read_text(), self.old)
        self.assertEqual(self.files(), ["ninedot.toml"])
        self.assertEqual(self.restarts(), restarts)
        self.runs()

    def test_a_good_change_is_in_force_and_the_one_before_is_kept(self):
        port = free_port()
        self.new.write_text(config_text(port=port))
        done = self.apply()
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertNotRegex(done.stdout, "note:.*note:")
        phases = [line.split(":")[0] for line in done.stdout.splitlines()]
        self.assertEqual([phase for phase in phases if phase != "note"], ["checking", "replacing", "restarting", "watching", "up"])
        self.runs(port)
        self.assertEqual(self.config.read_text(), self.new.read_text())
        self.assertEqual((self.folder / "ninedot.toml.before").read_text(), self.old)
        self.assertEqual(self.files(), ["ninedot.toml", "ninedot.toml.before"])

    def test_what_the_check_refuses_changes_nothing(self):
        self.new.write_text(self.old + "bauds = 9600\nport = 0\n")
        done = self.apply()
        self.assertEqual(done.returncode, 2)
        checked = run("ninedot", "check", "--config", self.new)
        self.assertEqual(done.stderr, checked.stderr, "all its messages, as `ninedot check` has them")
        self.assertRegex(done.stderr, r"new\.toml:\d+: ")
        self.assert_as_it_was()

    def test_the_same_again_is_nothing_to_do(self):
        done = self.apply(self.config)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("holds this already", done.stdout)
        self.assert_as_it_was()

    def test_a_change_that_cannot_come_up_is_taken_back(self):
        other = free_port()
        with Service(config_text(port=other)):
            self.runs(other)
            time.sleep(3)  # older than a service that was just restarted
            # The check takes a ninedotd that holds the port for the very one that is to be restarted.
            self.new.write_text(config_text(port=other))
            started = time.monotonic()
            done = self.apply()
            self.assertLess(time.monotonic() - started, 30)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertRegex(done.stderr, r"as it was before, and the service runs with it; with the new one: .*exit status 1: .*Address already in use")
        self.assert_as_it_was(restarts=3)

    def test_an_older_service_that_answers_in_its_place_deceives_nobody(self):
        other = free_port()
        careless = self.folder / "careless.sh"
        careless.write_text(f"#!/bin/bash\n{self.script} || true\n")
        careless.chmod(0o755)
        with Service(config_text(port=other)):
            self.runs(other)
            time.sleep(6)
            self.new.write_text(config_text(port=other))
            done = self.apply(self.new, "--within", "5", restart=careless)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("older than the restart", done.stderr)
        self.assertEqual(self.config.read_text(), self.old)

    def test_a_service_that_comes_and_goes_is_not_up(self):
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        fickle = self.folder / "fickle.sh"
        fickle.write_text(f"#!/bin/bash\n{self.script}\ncd {self.folder}\nif grep -q common_share ninedot.toml; then (sleep 1.5; kill $(cat pid)) > /dev/null 2>&1 & fi\n")
        fickle.chmod(0o755)
        done = self.apply(self.new, "--within", "6", restart=fickle)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, r"the service runs with it; with the new one: not up within 6 s: nothing answers")
        self.assert_as_it_was(restarts=3)

    def test_a_restart_that_hangs_ends_with_its_time(self):
        hangs = self.folder / "hangs.sh"
        hangs.write_text(f"#!/bin/bash\nif grep -q common_share {self.config}; then sleep 600; fi\n{self.script}\n")
        hangs.chmod(0o755)
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        started = time.monotonic()
        done = self.apply(self.new, "--within", "5", restart=hangs)
        self.assertLess(time.monotonic() - started, 30)
        self.assertRegex(done.stderr, "with the new one: .*still running")
        self.assert_as_it_was(restarts=2)

    def test_a_signal_in_the_middle_brings_the_old_one_back(self):
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        for number in (signal.SIGINT, signal.SIGTERM):
            restarts = self.restarts()
            process = self.start_and_wait_for("watching: ")
            process.send_signal(number)
            _, stderr = process.communicate(timeout=PATIENCE_S)
            self.assertEqual(process.returncode, 1)
            self.assertIn("interrupted", stderr)
            self.assert_as_it_was(restarts + 2)

    def start_and_wait_for(self, line, *options, **more):
        process = subprocess.Popen([BIN / "ninedot", *self.command(*(options or (self.new,)))], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)
        self.addCleanup(lambda: (process.kill(), process.communicate()))
        while not process.stdout.readline().startswith(line):
            self.assertIsNone(process.poll())
        return process

    def test_killed_in_the_middle_leaves_a_whole_file_and_the_next_run_tells(self):
        new = self.old + "\n[track]\ncommon_share = 0.4\n"
        self.new.write_text(new)
        process = self.start_and_wait_for("restarting: ")
        process.kill()
        process.communicate()
        self.assertIn(self.config.read_text(), (self.old, new))
        self.assertEqual((self.folder / "ninedot.toml.last-good").read_text(), self.old)
        done = self.apply()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("an earlier apply was cut short", done.stdout)
        self.assertEqual((self.folder / "ninedot.toml.before").read_text(), self.old)
        self.assertEqual(self.files(), ["ninedot.toml", "ninedot.toml.before"])
        self.runs()

    def test_only_one_at_a_time(self):
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        first = self.start_and_wait_for("watching: ")
        second = self.apply()
        self.assertEqual(second.returncode, 1)
        self.assertIn("another apply is under way", second.stderr)
        self.assertEqual(first.wait(timeout=PATIENCE_S), 0)

    def test_a_listener_that_goes_away_stops_nothing_half_way(self):
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        process = self.start_and_wait_for("replacing: ")
        process.stdout.close()
        self.assertEqual(process.wait(timeout=PATIENCE_S), 0)
        self.assertEqual(self.config.read_text(), self.new.read_text())

    def test_a_folder_that_cannot_be_written(self):
        self.new.write_text(self.old + "\n[track]\ncommon_share = 0.4\n")
        if os.geteuid() == 0:
            done = subprocess.run(["unshare", "-m", "sh", "-c", 'mount --bind "$0" "$0" && mount -o remount,bind,ro "$0" && exec "$@"', self.folder, BIN / "ninedot",
                                   *self.command(self.new)], capture_output=True, text=True)
            if done.stderr.startswith(("mount:", "unshare:")):
                self.skipTest("nothing can be mounted here")
        else:
            self.folder.chmod(0o555)
            self.addCleanup(self.folder.chmod, 0o755)
            done = self.apply()
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, r"cannot be created: (Read-only file system|Permission denied)")
        self.assert_as_it_was()

    def test_standard_input_is_a_candidate_too(self):
        new = self.old + "\n[track]\ncommon_share = 0.4\n"
        done = subprocess.run([BIN / "ninedot", *self.command("-")], input=new, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.config.read_text(), new)

    def test_hostile_candidates(self):
        fifo = self.folder / "fifo"
        os.mkfifo(fifo)
        (self.folder / "huge").write_bytes(b"#" * (256 * 1024 + 1))
        (self.folder / "empty").write_bytes(b"")
        (self.folder / "link").symlink_to("/etc/shadow")
        for what in ("/dev/zero", self.folder / "huge", self.folder / "empty", self.folder, self.folder / "link", "/nowhere"):
            done = self.apply(what)
            self.assertEqual(done.returncode, 2, f"{what}: {done.stderr}")
            self.assertNotIn("root:", done.stdout + done.stderr)
        writer = subprocess.Popen(["sh", "-c", f"yes > {fifo}"], stderr=subprocess.DEVNULL)
        self.assertEqual(self.apply(fifo).returncode, 2)
        writer.wait(timeout=PATIENCE_S)
        self.assert_as_it_was()

    def page(self, request, *options, close=True):
        """What ninedot-web gets back for `request` over a socket, as systemd hands it over."""
        ours, theirs = socket.socketpair()
        with ours, theirs:
            process = subprocess.Popen([BIN / "ninedot", *self.command("--page", *options)], stdin=theirs, stdout=theirs, stderr=subprocess.DEVNULL)
            theirs.close()
            ours.settimeout(PATIENCE_S)
            try:
                ours.sendall(request)
            except OSError:
                pass  # it has seen enough
            if close:
                ours.shutdown(socket.SHUT_WR)
            answer = b""
            try:
                while part := ours.recv(65536):
                    answer += part
            except ConnectionResetError:
                pass
            return process.wait(timeout=PATIENCE_S), answer.decode()

    def test_the_page_is_told_how_it_ends(self):
        new = (self.old + "\n[track]\ncommon_share = 0.4\n").encode()
        status, answer = self.page(b"apply %d\n%s" % (len(new), new), close=False)
        self.assertEqual(status, 0, answer)
        self.assertRegex(answer.splitlines()[-1], "^up: ")
        wrong = new + b"bauds = 1\n"
        status, answer = self.page(b"apply %d\n%s" % (len(wrong), wrong))
        self.assertEqual(status, 2)
        self.assertRegex(answer.splitlines()[-1], r"^refused: .*ninedot\.toml:\d+: ")
        for request in (b"", b"apply 10\nx", b"apply 99999999\n", b"\0" * 300000, b"apply 3\nxxxx"):
            status, answer = self.page(request)
            self.assertEqual(status, 2, answer)
            self.assertRegex(answer, "^refused: ")
        self.assertEqual(self.config.read_bytes(), new)

    def test_a_slow_request_ends_after_ten_seconds(self):
        started = time.monotonic()
        status, answer = self.page(b"apply 1000\nx", close=False)
        self.assertEqual(status, 2)
        self.assertIn("within 10 s", answer)
        self.assertLess(time.monotonic() - started, 20)

    LENS = (APPROACH / "camera.yaml").read_text()
    BETTER = LENS.replace("720", "721")

    def with_calibration(self):
        """The service runs with a calibration that its configuration names."""
        self.lens = self.folder / "lens.yaml"
        self.lens.write_text(self.LENS)
        self.old = self.old.replace("[camera]\n", '[camera]\ncalibration = "lens.yaml"\n', 1)
        self.config.write_text(self.old)
        subprocess.run([self.script], check=True)

    def test_a_calibration_takes_the_place_of_the_one_that_is_named(self):
        self.with_calibration()
        self.new.write_text(self.BETTER)
        done = self.apply(self.new, "--calibration")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertEqual(self.lens.read_text(), self.BETTER)
        self.assertEqual((self.folder / "lens.yaml.before").read_text(), self.LENS)
        self.assertFalse((self.folder / "lens.yaml.new").exists())
        self.assert_as_it_was(restarts=3)
        self.assertIn("holds this already", self.apply(self.new, "--calibration").stdout)

    def test_a_calibration_that_is_none_or_of_another_camera_is_refused(self):
        self.with_calibration()
        own = self.folder / "lens.yaml.new"
        own.write_text("somebody's own")
        for text in ("no calibration\n", self.LENS.replace("640", "320").replace("480", "240"), "%YAML:1.0\n---\n"):
            self.new.write_text(text)
            done = self.apply(self.new, "--calibration")
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn("lens.yaml.new2", done.stderr)
            self.assertEqual(self.lens.read_text(), self.LENS)
            self.assertEqual(own.read_text(), "somebody's own")
            self.assertFalse((self.folder / "lens.yaml.new2").exists())
            self.assert_as_it_was(restarts=2)

    def test_a_first_calibration_is_named_as_well(self):
        self.new.write_text(self.LENS)
        done = self.apply(self.new, "--calibration")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertEqual((self.folder / "camera.yaml").read_text(), self.LENS)
        self.assertEqual(self.config.read_text(), self.old.replace("[camera]\n", '[camera]\ncalibration = "camera.yaml"\n', 1))
        self.assertEqual((self.folder / "ninedot.toml.before").read_text(), self.old)
        self.runs()

    def test_a_first_calibration_that_does_not_come_up_leaves_nothing(self):
        fails = self.folder / "fails.sh"
        fails.write_text(f"#!/bin/bash\n{self.script}\nif grep -q calibration {self.config}; then kill $(cat {self.folder}/pid); echo the lens >&2; exit 1; fi\n")
        fails.chmod(0o755)
        self.new.write_text(self.LENS)
        done = self.apply(self.new, "--calibration", restart=fails)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, "ninedot.toml: as it was before, and the service runs with it; .*the lens")
        self.assertFalse((self.folder / "camera.yaml").exists())
        self.assert_as_it_was(restarts=3)

    # The recording's landmark alone: it is black and white, and so is the picture.
    MAP = """# Made by `ninedot map`: uncertainties are 1-sigma, relative to landmark 0.

[[landmarks]]  # given
id = 0
position_mm = [0.000, 0.000, 1200.000]
orientation_wxyz = [1.000000000, 0.000000000, 0.000000000, 0.000000000]  # heading 0.00 deg
"""
    OTHER_MAP = MAP.replace("1200.000", "1210.000")

    def test_a_first_map_takes_the_place_of_the_landmarks(self):
        landmarks = "[[landmarks]]\nid = 0 # by the door\n"
        rest = self.old
        self.old += landmarks
        self.config.write_text(self.old)
        self.new.write_text(self.MAP)
        done = self.apply(self.new, "--map")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertEqual(self.config.read_text(), 'map = "map.toml"\n' + rest)
        self.assertEqual((self.folder / "map.toml").read_text(), self.MAP)
        self.assertEqual((self.folder / "ninedot.toml.before").read_text(), self.old)
        self.runs()
        # The next one takes its place, and nothing else changes.
        self.new.write_text(self.OTHER_MAP)
        done = self.apply(self.new, "--map")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertEqual((self.folder / "map.toml").read_text(), self.OTHER_MAP)
        self.assertEqual((self.folder / "map.toml.before").read_text(), self.MAP)
        self.assertFalse((self.folder / "map.toml.new").exists())
        self.assertEqual(self.config.read_text(), 'map = "map.toml"\n' + rest)
        self.assertIn("holds this already", self.apply(self.new, "--map").stdout)
        self.assertEqual(self.restarts(), 3)

    def with_map(self):
        """The service runs with a map that its configuration names."""
        self.map = self.folder / "hall.toml"
        self.map.write_text(self.MAP)
        self.old = 'map = "hall.toml"\n' + self.old
        self.config.write_text(self.old)
        subprocess.run([self.script], check=True)

    def test_what_is_no_map_is_refused(self):
        self.with_map()
        for text, reason in (("no map\n", r"hall\.toml\.new:1: "), ("[camera]\nwidth_px = 640\n", "a map holds"), (self.MAP + "[[landmarks]]\nid = 0\n", "two landmarks have the id 0"),
                             ("# nothing\n", "a map needs")):
            self.new.write_text(text)
            done = self.apply(self.new, "--map")
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertRegex(done.stderr, reason)
            self.assertEqual(self.map.read_text(), self.MAP)
            self.assertFalse((self.folder / "hall.toml.new").exists())
            self.assert_as_it_was(restarts=2)
        self.assertEqual(self.apply(self.new, "--map", "--head").returncode, 2)

    def test_a_map_that_does_not_come_up_is_taken_back(self):
        self.with_map()
        fails = self.folder / "fails.sh"
        fails.write_text(f"#!/bin/bash\n{self.script}\nif grep -q 1210.000 {self.map}; then kill $(cat {self.folder}/pid); echo the map >&2; exit 1; fi\n")
        fails.chmod(0o755)
        self.new.write_text(self.OTHER_MAP)
        done = self.apply(self.new, "--map", restart=fails)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertRegex(done.stderr, "hall.toml: as it was before, and the service runs with it; .*the map")
        self.assertEqual(self.map.read_text(), self.MAP)
        self.assert_as_it_was(restarts=4)

    def test_the_page_hands_over_a_map(self):
        self.with_map()
        status, answer = self.page(b"map 5\nwrong")
        self.assertEqual(status, 2, answer)
        self.assertRegex(answer.splitlines()[-1], r"^refused: .*hall\.toml\.new")
        other = self.OTHER_MAP.encode()
        status, answer = self.page(b"map %d\n%s" % (len(other), other), close=False)
        self.assertEqual(status, 0, answer)
        self.assertRegex(answer.splitlines()[-1], r"^up: .*hall\.toml\.before")
        self.assertEqual(self.map.read_bytes(), other)

    HEAD = """# Made by `ninedot calibrate pan-tilt`.
[body]
camera_mm = [33.6, -8, 20.9]  # 1-sigma 0.7 mm
[pan_tilt.pan]
calibration = [  # [deg, us]
  [-25.4, 1739],  # +- 0.017 deg
  [16.9, 1341],
]
"""

    def test_a_calibration_of_the_head_takes_the_place_of_its_keys_alone(self):
        self.old += "[body]\ncamera_mm = [0, 0, 0] # to be measured\n"
        self.config.write_text(self.old)
        self.new.write_text(self.HEAD)
        done = self.apply(self.new, "--head")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        table = self.HEAD[self.HEAD.index("calibration = "):]
        self.assertEqual(self.config.read_text(), self.old.replace("[0, 0, 0]", "[33.6, -8, 20.9]") + "\n[pan_tilt.pan]\n" + table)
        self.assertEqual((self.folder / "ninedot.toml.before").read_text(), self.old)
        self.runs()
        self.assertIn("holds this already", self.apply(self.new, "--head").stdout)

    def test_what_is_no_calibration_of_a_head_is_refused(self):
        for text, reason in (("[web]\nlisten = '0.0.0.0'\n", "new.toml: 'listen' of \\[web\\] is nothing of a head"), ("# nothing\n", "has nothing of a head"),
                             ("[body]\ncamera_mm = 3\n", "'camera_mm'"), ("[body\n", "new.toml:1:")):
            self.new.write_text(text)
            done = self.apply(self.new, "--head")
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertRegex(done.stderr, reason)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assert_as_it_was()
        self.assertEqual(self.apply(self.new, "--head", "--calibration").returncode, 2)

    def test_the_page_hands_over_a_calibration_of_the_head(self):
        head = self.HEAD.encode()
        status, answer = self.page(b"head %d\n%s" % (len(head), head), close=False)
        self.assertEqual(status, 0, answer)
        self.assertRegex(answer.splitlines()[-1], r"^up: .*ninedot\.toml\.before")
        self.assertIn("camera_mm = [33.6, -8, 20.9]", self.config.read_text())
        status, answer = self.page(b"head 13\n[web]\nport=1\n")
        self.assertEqual(status, 2, answer)
        self.assertRegex(answer, "refused: .*'port' of \\[web\\] is nothing of a head")

    def test_the_page_hands_over_a_calibration(self):
        self.with_calibration()
        status, answer = self.page(b"calibration 5\nwrong")
        self.assertEqual(status, 2, answer)
        self.assertRegex(answer.splitlines()[-1], r"^refused: .*lens\.yaml\.new")
        better = self.BETTER.encode()
        status, answer = self.page(b"calibration %d\n%s" % (len(better), better), close=False)
        self.assertEqual(status, 0, answer)
        self.assertRegex(answer.splitlines()[-1], r"^up: .*lens\.yaml\.before")
        self.assertEqual(self.lens.read_bytes(), better)

    @unittest.skipIf(os.geteuid() != 0, "needs root, who alone can take other rights")
    def test_is_checked_with_the_rights_of_another(self):
        secret = self.folder / "secret"
        secret.write_text("hidden = 1\n")
        secret.chmod(0o600)
        self.folder.chmod(0o755)
        self.new.write_text(f'map = "{secret}"\n{self.old}')
        self.assertIn("hidden", self.apply().stderr, "root itself reads it")
        done = self.apply(self.new, "--check-as", "nobody")
        self.assertEqual(done.returncode, 2)
        self.assertIn("Permission denied", done.stderr)
        self.assertNotIn("hidden", done.stderr)
        self.assertIn("no such user", self.apply(self.new, "--check-as", "nobody-at-all").stderr)
        self.assert_as_it_was()


if __name__ == "__main__":
    unittest.main(verbosity=2)
