"""What the image has for its life in the field: the real-time kernel and what a frame takes on it, who the board is, the time, the log that is kept, Wi-Fi."""

import re
import socket
import struct
import threading
import time

from latencies import read_histogram, side_by_side
from qemu_board import BOARD_SERIAL
from reporting import note, require

RATE_HZ = 5  # boot_test.sh writes it into the configuration
NTP_EPOCH_S = 2208988800  # from 1900 to 1970
ANOTHER_DAY_S = 1924952400  # 2031-01-01 01:00 UTC
JOURNAL_MIB = 8  # as boot_test.sh has it
DIAGNOSIS = {"v4l2-ctl": "--version", "media-ctl": "--help", "gpioinfo": "--version", "i2cdetect": "-V", "mbpoll": "-V", "wpa_cli": "-v", "ip": "-V"}


def check_kernel(board):
    """PREEMPT_RT, and all that the image needs of a kernel: looked for where programs would use it."""
    version = board.run("uname -rv")
    # The file came with the patches that Debian's 6.12 still has.
    says_so = not version.startswith("6.12.") or board.run("cat /sys/kernel/realtime") == "1"
    require("PREEMPT_RT" in version and says_so, f"not the real-time kernel: {version}")
    for what, command in (("sysfs PWM", "test -d /sys/class/pwm"), ("GPIO", "test -c /dev/gpiochip0"),
                          ("I2C for programs", "test -d /sys/class/i2c-dev"), ("SPI for programs", "test -d /sys/bus/spi/drivers/spidev"),
                          ("FAT", "grep -q vfat /proc/filesystems"), ("squashfs", "grep -q squashfs /proc/filesystems"),
                          ("virtio", "test -d /sys/bus/virtio/drivers/virtio_blk"), ("a watchdog's driver", "modprobe bcm2835_wdt")):
        status, said = board.try_run(command)
        require(status == 0, f"the kernel has no {what}: {said}")
    note("kernel", f"{version.split()[0]}, PREEMPT_RT; sysfs PWM, GPIO, i2c-dev, spidev, FAT, squashfs, virtio")


def check_real_time(board, pid):
    """The frame loop's thread, by the kernel's own word: SCHED_FIFO (1) at the configuration's priority."""
    classes = {}
    for line in board.run(f"for t in /proc/{pid}/task/*; do echo \"$(cat $t/comm) $(sed 's/.*) //' $t/stat | cut -d ' ' -f 38,39)\"; done").splitlines():
        name, priority, policy = line.rsplit(" ", 2)
        classes[name] = (int(policy), int(priority))
    require(classes.get("frames") == (1, 50), f"the frame loop's thread is not SCHED_FIFO 50: {classes}")


def start_unit(board, name, command):
    """A unit that lasts until the next start, with its processor time counted."""
    board.run(f"printf '[Service]\\nExecStart={command}\\nCPUAccounting=yes\\n' > /run/systemd/system/{name}.service; systemctl daemon-reload; systemctl start {name}", limit_s=120)


def frames_of(board):
    """Returns processed, dropped, failed and the guest's time of it in seconds"""
    end, found = time.monotonic() + 60, None
    while found is None and time.monotonic() < end:
        found = board.registers(61, 6)
    uptime_s = float(board.run("cut -d ' ' -f 1 /proc/uptime"))
    require(found, "no registers")
    return tuple(found[i] << 16 | found[i + 1] for i in (0, 2, 4)) + (uptime_s,)


def measure_latency(board, seconds):
    """Returns the processed frames' share of all that came, the latencies in words, and their bins, over so many seconds of a service that has just started"""
    board.run("systemctl restart ninedotd", limit_s=120)
    check_real_time(board, board.run("systemctl show -P MainPID ninedotd"))
    before = frames_of(board)
    board.listen(0.1)
    board.run(f"sleep {seconds}", limit_s=seconds * 4 + 60)
    after = frames_of(board)
    processed, dropped, failed, took_s = (b - a for a, b in zip(before, after))
    came = processed + dropped + failed
    require(processed > 0 and failed == 0, f"{processed} frames processed, {failed} failed in {took_s:.0f} s")
    # Each frame that the recording gives is there or counted: none vanishes.
    require(abs(came - RATE_HZ * took_s) <= 0.1 * RATE_HZ * took_s + RATE_HZ, f"{processed} processed and {dropped} dropped of {RATE_HZ * took_s:.0f} frames in {took_s:.1f} s")
    said = board.run("ninedot tap --latencies")
    require(read_histogram(said), f"no histogram: {said}")
    count, at_once, bins = read_histogram(said)
    require(count == at_once == sum(bins.values()), f"the histogram holds {count} frames, {sum(bins.values())} by its bins, of {at_once} processed")
    require(count >= after[0], f"the histogram holds {count} frames, before it {after[0]} were processed")
    median, p99, _, largest = (value / 10 for value in board.registers(68, 4))
    require(0 < median <= p99 <= largest, f"latencies: median {median}, p99 {p99}, largest {largest} ms")
    return processed / came, f"{processed} of {came} frames, median {median:.1f}, p99 {p99:.1f}, largest {largest:.1f} ms", bins


# Everything that competes for processors and memory, at ordinary priority, as all else on the board is.
LOAD = r"""
for i in 1 2 3 4; do (while :; do :; done) & done
while :; do dd if=/dev/zero of=/tmp/load bs=64k count=64 2> /dev/null; rm -f /tmp/load; done
"""


def check_latency(board, seconds=60):
    """From exposure to report, idle and under load. QEMU emulates the processor: what is shown is that it is counted and that load takes nothing from it."""
    idle_share, idle, idle_bins = measure_latency(board, seconds)
    board.run(f"cat > /tmp/load.sh << 'END'{LOAD}END")
    start_unit(board, "ninedot-load", "/bin/sh /tmp/load.sh")
    try:
        busy_share, busy, busy_bins = measure_latency(board, seconds)
        used = board.run("systemctl show -P CPUUsageNSec ninedot-load")
        require(int(used) > seconds * 1e9 / 10, f"the load used {used} ns: there was none")
    finally:
        board.try_run("systemctl stop ninedot-load")
    # The frame loop goes first; the thread that unpacks the recording's pictures, which a camera has not, is an ordinary one and competes with the load.
    require(busy_share >= 0.8 * idle_share, f"load takes frames from the service: {busy_share:.2f} of them processed, {idle_share:.2f} without; idle {idle}; under load {busy}")
    note("frame to report, idle (emulated: function, not speed)", idle)
    note("the same under load, five busy processes", f"{busy}; the frame loop is SCHED_FIFO 50, the histogram holds every frame")
    print("".join(f"   {line}\n" for line in side_by_side({"idle": idle_bins, "under load": busy_bins})), end="", flush=True)


def check_identity(board):
    """The serial number of the device tree that the guest was started with, wherever it is told."""
    found = board.registers(148, 11)
    version = ".".join(str(number) for number in found[:3])
    serial = b"".join(struct.pack(">H", word) for word in found[3:]).decode("ascii").rstrip("\0")
    require(serial == BOARD_SERIAL, f"registers 151-158 say '{serial}'")
    told = board.run("ninedot status", limit_s=30)
    require(f"ninedot {version}, serial number of the board {BOARD_SERIAL}" in told, told)
    require(version in board.run("ninedot --version"), f"registers 148-150 say {version}")
    for unit in ("ninedotd", "ninedot-configure"):
        said = board.run(f"journalctl -u {unit} -o cat --no-pager | grep 'serial number' | tail -n 1")
        require(BOARD_SERIAL in said, f"the journal of {unit} does not tell the serial number: {said}")
    image = board.run("journalctl -u ninedot-configure -o cat --no-pager | grep '^image ' | tail -n 1")
    require(re.search(rf"ninedot-arm64(-pi5)? {re.escape(version)}\+", image), f"the journal does not tell the image's version: {image}")
    note("version and serial number", f"{version}, {serial}: in registers, status and journal; {image}")


def check_diagnosis(board):
    for tool, option in DIAGNOSIS.items():
        status, said = board.try_run(f"{tool} {option}")
        require(status in (0, 1, 255) and "not found" not in said, f"{tool}: {status}, {said}")
    lines = board.run("gpioinfo")
    require("line" in lines, f"gpioinfo: {lines}")
    seen = board.run("mbpoll -m tcp -p 1502 -0 -1 -r 0 -c 1 -t 4:hex 127.0.0.1")
    require("0x9D09" in seen, f"mbpoll: {seen}")
    note("tools for diagnosis", ", ".join(DIAGNOSIS))


class TimeServer:
    """Answers NTP (RFC 5905) on this machine's loopback, where the emulated network's gateway leads, with a day of its own."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 123))
        self.asked, self.over = 0, False
        threading.Thread(target=self.serve, daemon=True).start()

    def end(self):
        """Later starts of the board keep their own time."""
        self.over = True
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as last:
            last.sendto(bytes(48), ("127.0.0.1", 123))

    def serve(self):
        started = time.monotonic()
        while True:
            request, peer = self.socket.recvfrom(512)
            if self.over:
                self.socket.close()
                return
            self.asked += 1
            now = ANOTHER_DAY_S + NTP_EPOCH_S + time.monotonic() - started
            stamp = struct.pack(">II", int(now), int(now % 1 * 2**32))
            # Version 4, server; stratum 1, a microsecond's precision, no way to the reference clock.
            self.socket.sendto(struct.pack(">BBbbII4s", 0x24, 1, 6, -20, 0, 0, b"TEST") + stamp + request[40:48] + stamp + stamp, peer)


def check_clock(board):
    """NTP= of the file `network` names the server; the service goes on over a clock that jumps by years."""
    try:
        server = TimeServer()
    except OSError as error:
        print(f"   the clock was not tried: port 123 of the loopback: {error}", flush=True)
        return
    before = frames_of(board)
    board.run("systemctl restart systemd-timesyncd")
    end = time.monotonic() + 90
    while int(board.run("date +%s")) < ANOTHER_DAY_S and time.monotonic() < end:
        board.listen(1)
    require(int(board.run("date +%s")) >= ANOTHER_DAY_S, f"asked {server.asked} times; " + board.run("journalctl -u systemd-timesyncd -n 5 -o cat --no-pager; date"))
    server.end()
    after = frames_of(board)
    took_s = after[3] - before[3]
    require(sum(after[:3]) - sum(before[:3]) >= 0.8 * RATE_HZ * took_s - RATE_HZ and board.run("systemctl show -P NRestarts ninedotd") == "0", f"the jump of the clock stopped the service: {before}, {after}")
    note("time from the network (systemd-timesyncd)", f"taken over from the server that `network` names: {board.run('date -u +%F')}; the service went on")


def check_kept_journal(board, start_again):
    """With the file `journal`: the log outlives a power cut, and takes no more than it may."""
    board.run("echo before-the-power-cut | systemd-cat -t field; sync; journalctl --sync", limit_s=60)
    start_again(board)
    require("before-the-power-cut" in board.run("journalctl -t field -o cat --no-pager", limit_s=120), "what was in the log is gone after a power cut")
    boots = len(board.run("journalctl --list-boots --no-pager -q", limit_s=120).splitlines())
    require(boots >= 2, f"the log has {boots} starts")
    # In long lines: of more than 10,000 in half a minute the journal drops the rest. They can hardly be packed.
    board.run(f"head -c {JOURNAL_MIB * 3 // 2 << 20} /dev/urandom | base64 -w 2000 | systemd-cat -t filler", limit_s=600)
    board.run("journalctl --sync", limit_s=120)
    taken = int(board.run("du -sm /data/journal").split()[0])
    require(JOURNAL_MIB // 2 <= taken <= JOURNAL_MIB + 1, f"the log takes {taken} MiB on the data partition")
    note("log kept on the data partition", f"with `journal` = {JOURNAL_MIB}: over a power cut, {boots} starts; after being flooded it takes {taken} MiB")


ACCESS_POINT = r"""
cat > /tmp/ap.conf << 'END'
country=DE
network={
  mode=2
  ssid="Hall 7"
  frequency=2412
  key_mgmt=WPA-PSK
  proto=RSN
  pairwise=CCMP
  psk="boot test password"
}
END
mkdir -p /run/systemd/network
printf '[Match]\nName=wlan1\n[Network]\nAddress=192.168.77.1/24\nDHCPServer=yes\n' > /run/systemd/network/05-ap.network
modprobe mac80211_hwsim radios=2
for i in $(seq 50); do systemctl is-active -q ninedot-wifi@wlan1 && break; sleep 0.5; done
systemctl stop ninedot-wifi@wlan1
systemctl restart systemd-networkd
"""


def check_wifi(board):
    """The kernel's simulated radios: the second is an access point, the first has to join it by itself, as the file `wifi` says."""
    mode = board.run("stat -c '%a %U' /data/board/wifi /run/ninedot/wifi.conf").splitlines()
    require(mode == ["600 root"] * 2, f"the password can be read by others: {mode}")
    board.run(ACCESS_POINT, limit_s=180)
    start_unit(board, "access-point", "/usr/sbin/wpa_supplicant -D nl80211 -i wlan1 -c /tmp/ap.conf")
    end, state, address = time.monotonic() + 120, "", ""
    while time.monotonic() < end and not ("wpa_state=COMPLETED" in state and "192.168.77." in address):
        state = board.try_run("wpa_cli -i wlan0 status")[1]
        address = board.try_run("ip -4 -brief address show dev wlan0")[1]
        board.listen(1)
    require("wpa_state=COMPLETED" in state and "ssid=Hall 7" in state, f"not joined: {state}; " + board.run("journalctl -u ninedot-wifi@wlan0 -u access-point -n 12 -o cat --no-pager"))
    require("192.168.77." in address, f"joined, but no address: {address}; " + board.run("journalctl -u systemd-networkd -n 12 -o cat --no-pager"))
    require(board.run("wpa_cli -i wlan0 get country") == "DE", "the country was not set")
    trouble = board.run("dmesg | grep -i -E 'failed to load regulatory|regulatory.db.*(malformed|unsigned)' || true")
    require(trouble == "", trouble)
    for name in ("brcmfmac43430-sdio.bin", "brcmfmac43455-sdio.bin", "brcmfmac43455-sdio.raspberrypi,4-model-b.txt", "brcmfmac43430-sdio.raspberrypi,3-model-b.txt"):
        require(board.try_run(f"test -s '/usr/lib/firmware/brcm/{name}'")[0] == 0, f"no firmware {name}")
    status, said = board.try_run("modprobe brcmfmac")
    require(status == 0, f"brcmfmac: {said}")
    board.run("systemctl stop access-point; rmmod mac80211_hwsim; rm /run/systemd/network/05-ap.network", limit_s=180)
    note("Wi-Fi, simulated radios", "joined the network of `wifi` (WPA2), address by DHCP; the driver for a Raspberry Pi's radio loads, its firmware is there")
