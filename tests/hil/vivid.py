"""The kernel's test camera in the guest: what is written to its output node comes back from its capture node."""

CAPTURE, OUTPUT = "/dev/video0", "/dev/video1"
PIXELS = "width=640,height=480"
TIMINGS = 0  # 640x480p59.94
RATE_HZ = 59.94
MODULE_OPTIONS = "n_devs=1 node_types=0x101 num_inputs=1 input_types=3 num_outputs=1 output_types=1"


class Vivid:
    """One camera whose input is wired to its own output."""

    def __init__(self, guest):
        self.guest = guest
        self.pixel_format = "GREY"
        guest.check(f"modprobe vivid {MODULE_OPTIONS}")
        self.set_up()

    def set_up(self, pixel_format="GREY"):
        """Everything that the driver forgets when it is unbound. Nobody may be streaming."""
        self.pixel_format = pixel_format
        fourcc = f"{pixel_format:<4}"  # "Y10 "
        self.guest.check(
            f"""
            for node in {CAPTURE} {OUTPUT}; do v4l2-ctl -d $node --set-dv-bt-timings index={TIMINGS} > /dev/null || exit 1; done
            v4l2-ctl -d {OUTPUT} -x "{PIXELS},pixelformat={fourcc}" && v4l2-ctl -d {CAPTURE} -v "{PIXELS},pixelformat={fourcc}" || exit 1
            v4l2-ctl -d {CAPTURE} -c osd_text_mode=2
            # Kernels up to 6.9 have one switch, later ones a menu of which output an input hangs on: its choice 2 is the first output.
            if v4l2-ctl -d {CAPTURE} -L | grep -q loop_video; then v4l2-ctl -d {CAPTURE} -c loop_video=1
            else v4l2-ctl -d {CAPTURE} -c hdmi_000_0_is_connected_to=2; fi"""
        )

    def control(self, name, value):
        # v4l2-ctl's exit status says nothing about what the driver thought of it.
        text = self.guest.check(f"v4l2-ctl -d {CAPTURE} -c {name}={value} 2>&1")
        if text:
            raise AssertionError(f"vivid refused {name}={value}: {text}")

    def play(self, file):
        """Over and over, until the next `play` or `stop`; on air when this returns. A player whose node vanishes is started again."""
        self.stop()
        self.guest.check(
            f"""cat > /tmp/player.sh << 'end'
while :; do
  v4l2-ctl -d {OUTPUT} --stream-out-mmap 3 --stream-from={file} --stream-loop > /tmp/player.log 2>&1 < /dev/null &
  echo $! > /tmp/player.child
  wait
  sleep 0.1
done
end
rm -f /tmp/player.log
sh /tmp/player.sh > /dev/null 2>&1 & echo $! > /tmp/player.pid
# v4l2-ctl writes a '>' for each frame that the driver has taken.
for _ in $(seq 200); do grep -q '>' /tmp/player.log 2> /dev/null && exit 0; sleep 0.05; done
cat /tmp/player.log; exit 1"""
        )

    def stop(self):
        self.guest.check(
            """if [ -e /tmp/player.pid ]; then
            kill $(cat /tmp/player.pid); kill $(cat /tmp/player.child)
            while kill -0 $(cat /tmp/player.child); do sleep 0.02; done; rm -f /tmp/player.pid; fi 2> /dev/null; true"""
        )
