#!/usr/bin/python3
"""From the file `wifi` of the FAT partition to wpa_supplicant's configuration, and what is said of mistakes."""

import pathlib
import subprocess
import unittest

PROGRAM = pathlib.Path(__file__).resolve().parents[2] / "systemd/image/root/usr/lib/ninedot/wifi-settings"


def convert(text):
    """Returns status, configuration and complaint"""
    done = subprocess.run(["/bin/sh", str(PROGRAM)], input=text.encode(), capture_output=True, timeout=30, check=False)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


class Settings(unittest.TestCase):
    def network(self, text):
        status, made, said = convert(text)
        self.assertEqual((status, said), (0, ""), text)
        return made

    def test_name_password_and_country_become_wpa_supplicants(self):
        self.assertEqual(self.network("country = DE\nname = Hall 7\npassword = open sesame\n"),
                         'ctrl_interface=/run/wpa_supplicant\ncountry=DE\nnetwork={\n  ssid=48616c6c2037\n  scan_ssid=1\n  psk="open sesame"\n}\n')

    def test_line_ends_of_any_editor_comments_and_a_missing_last_one_are_fine(self):
        wanted = self.network("country = DE\nname = Hall 7\npassword = open sesame\n")
        self.assertEqual(self.network("# ours\r\ncountry=DE\r\n\r\nname =  Hall 7 \r\npassword\t= open sesame"), wanted)

    def test_signs_in_a_name_can_end_neither_line_nor_quotation(self):
        name = 'a"}=ü'
        self.assertIn(f"  ssid={name.encode().hex()}\n", self.network(f"country = DE\nname = {name}\n"))
        self.assertIn('  psk="pass#word="1"\n', self.network('country = DE\nname = a\npassword = pass#word="1\n'))

    def test_without_a_password_the_network_is_an_open_one(self):
        self.assertIn("  key_mgmt=NONE\n", self.network("country = CH\nname = a\n"))

    def test_a_key_is_taken_as_it_is(self):
        self.assertIn(f"  psk={'0aF9' * 16}\n", self.network(f"country = CH\nname = a\npassword = {'0aF9' * 16}\n"))

    def test_mistakes_are_told_in_one_line(self):
        for text, word in {
                "name = a\n": "country", "country = de\nname = a\n": "country", "country = DEU\nname = a\n": "country",
                "country = DE\n": "name", f"country = DE\nname = {'a' * 33}\n": "name",
                "country = DE\nname = a\npassword = short\n": "8 to 63", f"country = DE\nname = a\npassword = {'g' * 64}\n": "hexadecimal",
                f"country = DE\nname = a\npassword = {'g' * 65}\n": "8 to 63", "country = DE\nname = a\npassword = pass\"word#1\n": "wpa_passphrase", "country = DE\nssid = a\n": "unknown key 'ssid'", "Hall 7\n": "KEY = VALUE"}.items():
            status, made, said = convert(text)
            self.assertEqual((status, made, said.count("\n")), (1, "", 1), text)
            self.assertIn(word, said, text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
