#!/usr/bin/python3
"""When a board keeps a new system and when it leaves it: the board's own scripts with programs that only tell what a test lets them, on a clock of the test's."""

import pathlib
import subprocess
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "systemd/image/root/usr/lib/ninedot"
TCP = "[camera]\nrate_hz = 35.0\n[modbus.tcp]   # served\nlisten = \"0.0.0.0\"\nport = 1502\n[outputs]\nport = 9\n"
# Each is a shell script; $now is the clock, in seconds since the start. It goes on when somebody sleeps, and nobody waits for that.
PROGRAMS = {
    "sleep": '[ $1 -lt 20 ] || exit 0; echo $((now + $1)) > $work/proc/uptime; [ $now -lt 300 ] || kill $PPID',
    "timeout": 'shift; exec "$@"',
    "sync": "true",
    "rauc": 'echo "$now $*" >> $work/rauc; true',
}
HEALTHY = {
    "systemctl": 'case $1 in show) case $3 in ActiveState) [ $now -ge 20 ] && echo active || echo activating ;; MainPID) echo 77 ;; SubState) echo dead ;; esac ;;'
                 ' *) echo "$now $*" >> $work/restarted; kill -9 $(cat $work/script) ;; esac',
    "ninedot": '[ $now -ge 20 ] && echo "{\\"frames_processed\\":$((now * 35)),\\"x\\":1}"; echo "$*" >> $work/asked',
    "ss": "true",
}


class Board:
    """What the scripts find on it: `programs` beside or in place of a healthy one's."""

    def __init__(self, work, arguments="rauc.slot=B ninedot.trial", config=TCP, expects=None, **programs):
        self.work = pathlib.Path(work)
        for folder in ("bin", "proc", "data", "lib"):
            (self.work / folder).mkdir()
        (self.work / "proc/cmdline").write_text(f"ro quiet {arguments}\n")
        (self.work / "proc/uptime").write_text("5.0 9.0\n")
        (self.work / "ninedot.toml").write_text(config)
        if expects is not None:
            (self.work / "data/update-expects").write_text(expects)
        for name, text in {**PROGRAMS, **HEALTHY, **programs}.items():
            program = self.work / "bin" / name
            program.write_text(f"#!/bin/sh\nwork={work}; read -r now _ < {work}/proc/uptime; now=${{now%.*}}\n{text}\n")
            program.chmod(0o755)
        for script in SCRIPTS.iterdir():
            text = script.read_text()
            for old, new in (("/proc/sysrq-trigger", f"{work}/sysrq"), ("/proc/", f"{work}/proc/"), ("/data/board", f"{work}/data"), ("/usr/lib/ninedot/", f"{work}/lib/"),
                             ("/etc/ninedot/", f"{work}/"), ("/dev/kmsg", f"{work}/kmsg")):
                text = text.replace(old, new)
            (self.work / "lib" / script.name).write_text(text.replace("set -u\n", f"set -u; echo $$ > {work}/script\n", 1) if script.name == "confirm-slot" else text)
            (self.work / "lib" / script.name).chmod(0o755)

    def run(self, script, *arguments):
        """Returns exit status and what was said"""
        done = subprocess.run(["/bin/sh", str(self.work / "lib" / script), *arguments], capture_output=True, text=True, timeout=300, check=False,
                              env={"PATH": f"{self.work}/bin:/usr/sbin:/usr/bin:/sbin:/bin"})
        return done.returncode, done.stdout + done.stderr

    def told(self, name):
        path = self.work / name
        return path.read_text().splitlines() if path.exists() else []


class ConfirmSlot(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.count = folder.name, 0

    def board(self, **what):
        self.count += 1
        work = f"{self.folder}/{self.count}"
        pathlib.Path(work).mkdir()
        return Board(work, **what)

    def assert_kept(self, board, earliest_s, latest_s):
        status, said = board.run("confirm-slot")
        self.assertEqual(status, 0, said)
        marked = board.told("rauc")
        self.assertEqual([line.split(" ", 1)[1] for line in marked], ["status mark-good"], said)
        self.assertTrue(earliest_s <= int(marked[0].split()[0]) <= latest_s, f"{marked}; {said}")
        self.assertEqual(board.told("restarted"), [], said)

    def assert_left(self, board, at_s=120, because=""):
        _, said = board.run("confirm-slot")
        restarted = board.told("restarted")
        self.assertEqual([line.split(" ", 1)[1] for line in restarted], ["--force reboot"], said)
        self.assertTrue(at_s <= int(restarted[0].split()[0]) <= at_s + 10, f"{restarted}; {said}")
        self.assertIn(because, said)

    def test_a_system_whose_service_has_answered_for_15_s_is_kept(self):
        self.assert_kept(self.board(), 35, 50)

    def test_a_service_that_never_starts_is_left_after_two_minutes(self):
        board = self.board(systemctl=HEALTHY["systemctl"].replace("echo active ||", "echo activating ||"))
        self.assert_left(board, because="the service is activating")
        self.assertEqual(board.told("rauc"), [])
        self.assertIn("did not prove itself", board.told("kmsg")[0])

    def test_one_that_is_started_again_every_ten_seconds_is_left(self):
        self.assert_left(self.board(systemctl=HEALTHY["systemctl"].replace("echo 77", "echo $((now / 10))")), because="the service has run for")

    def test_one_that_does_not_answer_is_left(self):
        self.assert_left(self.board(ninedot="echo no connection; exit 1"), because="no answer over Modbus TCP: no connection")

    def test_one_that_lets_this_board_not_in_is_kept_for_its_listener(self):
        self.assert_kept(self.board(ninedot="echo closed at once; exit 1", ss='case "$*" in *:1502*) echo LISTEN ;; esac'), 35, 50)

    def test_where_frames_came_before_the_update_they_have_to_come_after_it(self):
        self.assert_kept(self.board(expects="camera\n"), 35, 55)
        self.assert_left(self.board(expects="camera\n", ninedot='echo "{\\"frames_processed\\":0,}"'), because="no frames come")

    def test_where_none_came_before_none_are_asked_for(self):
        self.assert_kept(self.board(expects="\n", ninedot='echo "{\\"frames_processed\\":0,}"'), 35, 50)

    def test_one_that_can_not_be_marked_is_left(self):
        self.assert_left(self.board(rauc="echo no bus; exit 1"), because="no bus")

    def test_a_confirmed_system_is_never_left(self):
        board = self.board(arguments="rauc.slot=B", systemctl=HEALTHY["systemctl"].replace("echo active ||", "echo activating ||"))
        board.run("confirm-slot")
        self.assertEqual((board.told("restarted"), board.told("rauc")), ([], []))
        self.assert_kept(self.board(arguments="rauc.slot=B", expects="camera\n", ninedot='echo "{\\"frames_processed\\":0,}"'), 35, 50)

    def test_an_emulated_board_may_take_longer(self):
        late = HEALTHY["systemctl"].replace("-ge 20", "-ge 150")
        self.assert_kept(self.board(arguments="rauc.slot=B ninedot.trial ninedot.trial_s=200", systemctl=late), 165, 185)
        self.assert_left(self.board(systemctl=late))

    def test_the_service_is_asked_where_its_configuration_says(self):
        for config, wanted in (
                (TCP, ["status --json --host 127.0.0.1 --port 1502"]),
                ("[modbus.tcp]\n", ["status --json --host 127.0.0.1 --port 1502"]),
                ("[ modbus . tcp ]\r\nlisten = \"::\" # all\r\nport=1600\r\n", ["status --json --host ::1 --port 1600"]),
                ("[modbus.tcp]\nlisten = \"192.168.0.20\"\n# port = 1\n", ["status --json --host 192.168.0.20 --port 1502"]),
                ("[modbus.rtu]\nport = 7\n", [])):
            board = self.board(config=config)
            (board.work / "proc/uptime").write_text("30.0 9.0\n")
            status, said = board.run("service-answers")
            self.assertEqual((status, said, board.told("asked")), (0, "", wanted), config)

    def test_what_a_new_system_has_to_do_is_what_the_old_one_does(self):
        for what, wanted in (({}, "camera"), ({"ninedot": 'echo "{\\"frames_processed\\":0,}"'}, ""), ({"config": "[modbus.rtu]\n"}, "")):
            board = self.board(**what)
            (board.work / "proc/uptime").write_text("30.0 9.0\n")
            status, said = board.run("before-update")
            self.assertEqual((status, board.told("data/update-expects")), (0, [wanted]), said)

    def test_no_update_is_written_over_the_system_before_while_the_new_one_is_on_trial(self):
        for arguments, state, wanted in (("rauc.slot=B ninedot.trial", "running", 1), ("rauc.slot=B ninedot.trial", "dead", 0),
                                         ("rauc.slot=B ninedot.trial_s=9", "running", 0)):
            board = self.board(arguments=arguments, systemctl=HEALTHY["systemctl"].replace("echo dead", f"echo {state}"))
            (board.work / "proc/uptime").write_text("30.0 9.0\n")
            status, said = board.run("before-update")
            self.assertEqual((status, board.told("data/update-expects")), (wanted, [] if wanted else ["camera"]), f"{arguments}, {state}: {said}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
