"""`./dev COMMAND --help` tells of that command and does nothing else."""

import pathlib
import re
import subprocess
import unittest

DEV = pathlib.Path(__file__).resolve().parent.parent / "dev"


def dev(*words):
    return subprocess.run(["/bin/bash", DEV, *words], capture_output=True, text=True, check=False, timeout=20)


class Help(unittest.TestCase):
    def test_each_command_tells_of_itself_alone(self):
        whole = dev("help").stdout
        commands = re.findall(r"^  ([a-z]+) ", whole, re.MULTILINE)
        self.assertGreater(len(commands), 10)
        for command in commands:
            for words in (["--help"], ["-h"], ["something", "--help"]):
                done = dev(command, *words)
                self.assertEqual((done.returncode, done.stderr), (0, ""), command)
                self.assertTrue(done.stdout.startswith(f"  {command} "), done.stdout)
                self.assertIn(done.stdout, whole)
                self.assertEqual(len(re.findall(r"^  [a-z]", done.stdout, re.MULTILINE)), 1, done.stdout)

    def test_what_is_no_command_has_no_help(self):
        done = dev("hill", "--help")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", "dev: unknown command 'hill': see ./dev help\n"))


if __name__ == "__main__":
    unittest.main()
