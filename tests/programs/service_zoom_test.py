"""A zoom camera's service: the lens is that of the position that its head tells, over a serial line. No landmark is there to be had
at two focal lengths: the same pictures are looked at through two made-up lenses, whose distances differ as their focal lengths do."""

import os
import pathlib
import re
import shutil
import sys
import tempfile
import termios
import tty
import unittest

from service_harness import APPROACH, SOURCE, Client, Service, config_text, free_port, replay_rows, run

sys.path.append(str(SOURCE / "tests" / "hil"))
import visca_stage  # noqa: E402

VALID, ZOOM = 1, 16


class Line:
    """One end of a pseudo-terminal, as a socket is used."""

    def __init__(self, _):
        self.fd, other = os.openpty()
        tty.setraw(other, termios.TCSANOW)
        self.device = os.ttyname(other)
        self.other = other  # held open, so that a reader that goes is no hang-up

    def fileno(self):
        return self.fd

    def recv(self, count):
        return os.read(self.fd, count)

    def sendall(self, data):
        os.write(self.fd, data)

    def close(self):
        os.close(self.fd)
        os.close(self.other)


visca_stage.connect_to = Line


def numbers_of(text, key):
    return [float(number) for number in re.search(key + r":[^\[]*\[([^\]]*)\]", text).group(1).split(",")]


def zoom_file(folder, *positions):
    """The recording's own lens at `position`, and at others with a focal length that many times as long."""
    text = (APPROACH / "camera.yaml").read_text()
    fx, _, cx, _, fy, cy = numbers_of(text, "camera_matrix")[:6]
    coefficients = numbers_of(text, "distortion_coefficients")
    text += "zoom:\n  positions:\n"
    for position, factor in positions:
        parameters = [factor * fx, factor * fy, cx, cy, *coefficients]
        covariance = [1e-6 * (row == column) for row in range(9) for column in range(9)]
        text += f"    - {{position: {position}, parameters: {parameters}, covariance: {covariance}}}\n"
    path = pathlib.Path(folder) / "zoom.yaml"
    path.write_text(text)
    return path


def recording_with_zooms(folder, zooms):
    """The first pictures of the approach, and where the zoom stood."""
    recording = pathlib.Path(folder) / "recording"
    (recording / "frames").mkdir(parents=True)
    rows = (APPROACH / "frames.csv").read_text().splitlines()[1:1 + len(zooms)]
    for row in rows:
        name = f"{int(row.split(',')[0]):06}.png"
        shutil.copy(APPROACH / "frames" / name, recording / "frames" / name)
    lines = [f"{','.join(row.split(',')[:2])},{zoom}" for row, zoom in zip(rows, zooms)]
    (recording / "frames.csv").write_text("frame,timestamp_ns,zoom\n" + "\n".join(lines) + "\n")
    return recording


class ServiceZoom(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="ninedot-test-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.calibration = zoom_file(self.folder, (0, 1), (500, 2))

    def config(self, port, head):
        text = config_text(port=port, extra=head)
        return text.replace("[camera]", f'[camera]\ncalibration = "{self.calibration}"', 1)

    def test_it_follows_the_zoom_that_the_head_tells(self):
        port = free_port()
        with visca_stage.ViscaCamera("") as camera:
            head = f'[pan_tilt]\ndriver = "visca"\ndevice = "{camera.line.device}"\nfollow = false\nsearch = false'
            with Service(self.config(port, head)) as service, Client(port=port) as client:
                near = client.wait_for(lambda registers: registers[4] & VALID)
                self.assertEqual(near[5], 0)
                service.wait_for_log("zoom 0: f = ")
                camera.zoom = 300
                client.wait_for(lambda registers: registers[5] == ZOOM)
                service.wait_for_log("zoom 300: out of the calibration's reach, 0 and 500 alone")
                self.assertFalse(client.read()[4] & VALID)
                camera.zoom = 500
                far = client.wait_for(lambda registers: registers[4] & VALID)
                service.wait_for_log("zoom 500: f = ")
                camera.answers = False
                client.wait_for(lambda registers: registers[5] == ZOOM)
                camera.answers = True
                client.wait_for(lambda registers: registers[4] & VALID)
                self.assertEqual(service.end()[0], 0)
                self.assertEqual(camera.unknown, [])
        distances = {}
        for zoom in (0, 500):
            fixed = pathlib.Path(self.folder) / "fixed.toml"
            fixed.write_text(f"[pose]\ntracking = false\n[pan_tilt]\nzoom = {zoom}\n")
            rows = replay_rows(APPROACH, "--config", fixed, "--camera", self.calibration)
            distances[zoom] = [float(row["y_mm"]) for row in rows if row["valid"] == "1"]
        self.assertTrue(min(distances[0]) - 1 <= self.y_mm(near) <= max(distances[0]) + 1, (self.y_mm(near), distances[0]))
        self.assertTrue(min(distances[500]) - 1 <= self.y_mm(far) <= max(distances[500]) + 1, (self.y_mm(far), distances[500]))
        self.assertGreater(min(distances[500]), 1.5 * min(distances[0]))

    @staticmethod
    def y_mm(registers):
        value = registers[18] << 16 | registers[19]
        return (value - (1 << 32) if value & 1 << 31 else value) / 1000

    def test_a_recording_tells_its_zoom_frame_by_frame(self):
        zooms = [0, 0, 500, 500, "", 300, 0, 0]
        recording = recording_with_zooms(self.folder, zooms)
        plain = pathlib.Path(self.folder) / "plain.toml"
        plain.write_text("[pose]\ntracking = false\n")
        followed = {int(row["frame"]): row for row in replay_rows(recording, "--config", plain, "--camera", self.calibration)}
        self.assertEqual(list(followed), [3 * i for i in (0, 1, 2, 3, 6, 7)])
        for zoom in (0, 500):
            fixed = pathlib.Path(self.folder) / "fixed.toml"
            fixed.write_text(f"[pose]\ntracking = false\n[pan_tilt]\nzoom = {zoom}\n")
            untold = recording / "frames.csv"
            text = untold.read_text()
            untold.write_text("\n".join(",".join(line.split(",")[:2]) for line in text.splitlines()) + "\n")
            rows = {int(row["frame"]): row for row in replay_rows(recording, "--config", fixed, "--camera", self.calibration)}
            untold.write_text(text)
            for frame, told in zip(range(0, 24, 3), zooms):
                if told == zoom:
                    for column in ("x_mm", "y_mm", "z_mm", "qw", "sigma_y_mm"):
                        self.assertEqual(followed[frame][column], rows[frame][column], (frame, column))

    def test_what_can_not_be_known_is_refused(self):
        def checked(head):
            path = pathlib.Path(self.folder) / "checked.toml"
            path.write_text(self.config(free_port(), head))
            return run("ninedot", "check", "--config", path)

        nobody = checked("")
        self.assertEqual(nobody.returncode, 2)
        self.assertIn("nothing tells where its zoom stands: set zoom of [pan_tilt]", nobody.stderr)
        self.assertEqual(nobody.stderr.count("\n"), 1)
        beyond = checked("[pan_tilt]\nzoom = 300")
        self.assertEqual(beyond.returncode, 2)
        self.assertRegex(beyond.stderr, r"toml:\d+: zoom 300 of \[pan_tilt\] is out of the calibration's reach, 0 and 500 alone")
        fixed = checked("[pan_tilt]\nzoom = 500")
        self.assertEqual(fixed.returncode, 0, fixed.stderr)
        own = numbers_of((APPROACH / "camera.yaml").read_text(), "camera_matrix")[0]
        self.assertIn(f"f = {2 * own:.1f} px", fixed.stdout)
        self.assertEqual(checked('[pan_tilt]\ndriver = "visca"\ndevice = "/dev/x"').returncode, 0)
        replayed = run("ninedot", "replay", APPROACH, "--camera", self.calibration)
        self.assertEqual(replayed.returncode, 2)
        self.assertIn("nothing tells where its zoom stands", replayed.stderr)


if __name__ == "__main__":
    unittest.main()
