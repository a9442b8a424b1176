"""Which output makes a mutation red, and which says nothing; without a build, a program or a guest."""

import contextlib
import importlib.util
import io
import pathlib
import sys
import tempfile
import types
import unittest
from unittest import mock

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))
import run
import verdict

BEGUN = "[==========] Running 2 tests from 1 test suite.\n[ RUN      ] Servo.Turns\n"
PASSED = BEGUN + "[       OK ] Servo.Turns (0 ms)\n[ RUN      ] Servo.Stops\n[       OK ] Servo.Stops (0 ms)\n[  PASSED  ] 2 tests.\n"
FAILED = BEGUN + "servo_test.cpp:12: Failure\n[  FAILED  ] Servo.Turns (0 ms)\n"
SEGMENTATION_FAULT = -11


class Tests(unittest.TestCase):
    def outcome(self, status, output):
        return verdict.of_tests(status, output)[0]

    def test_a_test_that_failed_is_red(self):
        self.assertEqual(self.outcome(1, FAILED), "red")

    def test_a_test_that_takes_the_program_with_it_is_red(self):
        self.assertEqual(self.outcome(SEGMENTATION_FAULT, BEGUN), "red")
        self.assertEqual(self.outcome(SEGMENTATION_FAULT, PASSED + "[ RUN      ] Servo.Rests\n"), "red")

    def test_all_passed_is_green(self):
        self.assertEqual(self.outcome(0, PASSED), "green")

    def test_a_program_that_runs_no_test_says_nothing(self):
        self.assertEqual(self.outcome(0, "[==========] Running 0 tests from 0 test suites.\n[  PASSED  ] 0 tests.\n"), "NO TEST")
        self.assertEqual(self.outcome(0, BEGUN + "[  SKIPPED ] Servo.Turns (0 ms)\n[  PASSED  ] 0 tests.\n"), "NO TEST")

    def test_a_program_that_ends_before_or_behind_its_tests_says_nothing(self):
        self.assertEqual(self.outcome(127, ""), "NOT REACHED")
        self.assertEqual(self.outcome(SEGMENTATION_FAULT, "Running main() from gtest_main.cc\n"), "NOT REACHED")
        self.assertEqual(self.outcome(SEGMENTATION_FAULT, PASSED), "NOT REACHED")

    def test_no_time_left_is_no_failure(self):
        self.assertEqual(self.outcome(verdict.NO_TIME_LEFT, BEGUN), "TIME OUT")
        self.assertEqual(self.outcome(verdict.NO_TIME_LEFT, FAILED), "TIME OUT")


class Checks(unittest.TestCase):
    def test_a_check_that_failed_is_red_and_says_what_was_seen(self):
        said = "ok servo.power-on  on\nnot ok servo.pwm-limit  not cut\n   servo: 60 s\n2 checks, 1 failed; report.md\n"
        self.assertEqual(verdict.of_check("servo.pwm-limit", said), ("red", "not cut"))
        self.assertEqual(verdict.of_check("servo.power-on", said), ("green", "on"))

    def test_one_whose_name_begins_alike_is_another(self):
        said = "not ok servo.pwm-limit-low  not cut\nnot ok servo.pwm  off\nok servo.pwm-limit  cut\n"
        self.assertEqual(verdict.of_check("servo.pwm-limit", said)[0], "green")

    def test_what_a_log_says_is_no_result(self):
        said = "not ok servo.pwm-limit  not cut; log:\nthat is ok servo.pwm-limit  cut\n"
        self.assertEqual(verdict.of_check("servo.pwm-limit", said), ("red", "not cut; log:"))

    def test_a_stage_that_did_not_run_says_nothing(self):
        self.assertEqual(verdict.of_check("servo.power-on", "E: no kernel\n"), ("NOT REACHED", "the stage did not run"))
        self.assertEqual(verdict.of_check("servo.power-on", ""), ("NOT REACHED", "the stage did not run"))

    def of_stage(self, runs):
        """What hil itself says of a stage with the checks `first` and `last`"""
        with mock.patch.object(sys, "path", list(sys.path)), mock.patch.dict(sys.modules):
            del sys.modules["run"]
            specification = importlib.util.spec_from_file_location("run", FOLDER.parent / "hil" / "run.py")
            hil = importlib.util.module_from_spec(specification)
            specification.loader.exec_module(hil)
        module = types.SimpleNamespace(CHECKS=("first", "last"), SMOKE_CHECKS=("first",), run=runs)
        said = io.StringIO()
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            hil.Stage("made-up", module, pathlib.Path(folder), smoke=False, is_asked_for=True).run()
        return said.getvalue()

    def test_a_guest_that_does_not_boot_catches_nothing(self):
        def boots(_):
            raise RuntimeError("the guest did not start within 120 s")

        self.assertEqual(verdict.of_check("made-up.last", self.of_stage(boots)), ("NOT REACHED", "the guest did not start within 120 s"))

    def test_a_check_behind_the_one_that_ended_the_stage_was_not_reached(self):
        def ends_early(stage):
            stage.begin("first")
            raise AssertionError("not within 30 s: frames again")

        said = self.of_stage(ends_early)
        self.assertEqual(verdict.of_check("made-up.first", said), ("red", "not within 30 s: frames again"))
        self.assertEqual(verdict.of_check("made-up.last", said)[0], "NOT REACHED")

    def test_a_stage_that_is_left_out_says_nothing(self):
        said = self.of_stage(lambda stage: stage.leave_out("nothing to run it on"))
        self.assertEqual(verdict.of_check("made-up.last", said), ("NOT REACHED", "nothing to run it on"))


class Mutations(unittest.TestCase):
    def result(self, outcome, may_survive=None, may_not_end=None):
        return verdict.of_mutation(outcome, "seen", may_survive, may_not_end)

    def test_a_survivor_is_wrong_without_a_reason(self):
        self.assertEqual(self.result("green"), ("SURVIVED", "seen"))
        self.assertEqual(self.result("green", may_survive="harmless"), ("survived", "harmless"))

    def test_an_endless_wait_is_red_only_where_the_list_says_so(self):
        self.assertEqual(self.result("TIME OUT")[0], "TIME OUT")
        self.assertEqual(self.result("TIME OUT", may_survive="harmless")[0], "TIME OUT")
        self.assertEqual(self.result("TIME OUT", may_not_end="waits for ever"), ("red", "waits for ever"))
        self.assertEqual(self.result("NOT REACHED", may_not_end="waits for ever")[0], "NOT REACHED")

    def test_what_says_nothing_makes_the_run_fail(self):
        for outcome in (verdict.NO_TEST, verdict.TIME_OUT, verdict.NOT_REACHED):
            self.assertTrue(self.result(outcome, may_survive="harmless")[0].isupper())
        self.assertFalse(self.result("red")[0].isupper())

    def test_a_block_says_which_check_may_never_end(self):
        mutation = run.Mutation(["a.cpp", "- x", "+ y", "! a_test A.*", "% it waits for x"])
        self.assertEqual((mutation.may_not_end, mutation.may_survive), ("it waits for x", None))

    def judged(self, outcome_without, outcome):
        """\\return  (exit status, what is said) of a run over one mutation whose check has these outcomes without it and with it"""
        mutation = run.Mutation(["a.cpp", "- x", "+ y", "! hil servo.power-on"])
        outcomes = [outcome_without, outcome]
        said = io.StringIO()
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.redirect_stdout(said):
            pathlib.Path("a.cpp").write_text("x\n")
            for path in (run.BUILD / "CMakeCache.txt", run.VERDICT):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
            with (
                mock.patch.object(run, "read_list", lambda: [mutation]),
                mock.patch.object(run, "built", lambda *_: types.SimpleNamespace(returncode=0)),
                mock.patch.object(run, "run_checks", lambda checks: {check: (outcomes.pop(0), "seen") for check in checks}),
            ):
                status = run.main(["judge", "--hil"])
            self.assertEqual(pathlib.Path("a.cpp").read_text(), "x\n")
        return status, said.getvalue()

    def test_a_check_that_is_red_anyway_catches_nothing(self):
        for without in (verdict.RED, verdict.NOT_REACHED):
            status, said = self.judged(without, verdict.RED)
            self.assertEqual(status, 1)
            self.assertIn(f"NOT GREEN servo.power-on without any mutation: {without}", said)
            self.assertIn("1 mutations: 1 NOT GREEN", said)

    def test_a_check_that_turns_red_catches_it(self):
        status, said = self.judged(verdict.GREEN, verdict.RED)
        self.assertEqual(status, 0)
        self.assertIn("1 mutations: 1 red", said)

    def test_one_that_was_not_reached_makes_the_run_fail(self):
        status, said = self.judged(verdict.GREEN, verdict.NOT_REACHED)
        self.assertEqual(status, 1)
        self.assertIn("1 mutations: 1 NOT REACHED", said)


if __name__ == "__main__":
    unittest.main()
