"""What a board in a cabinet must do, on the image in QEMU. Started by boot_test.sh, which puts the configuration on it."""

import argparse
import hashlib
import random
import re
import sys
import time

import field_checks
from qemu_board import Board, Failure
from reporting import note, require, table

MAGIC, STATUS_VALID = 0x9D09, 1
BOOT_LIMIT_S = 300  # a busy machine emulates slowly
TOKEN = "0123456789abcdef0123456789abcdef"  # as boot_test.sh has it
CONFIG = "/etc/ninedot/ninedot.toml"
DRIVERS = {"bcm2835-unicam", "imx219", "imx296", "ov5647", "ov9282", "pwm-pca9685", "sc16is7xx", "sc16is7xx_i2c", "sc16is7xx_spi", "v4l2-cci"}
PI5_DRIVERS = ("sdhci_brcmstb", "rp1_pci", "clk-rp1", "pinctrl-rp1", "i2c-designware-platform", "macb", "dwc3", "rp1-cfe", "pisp-be")


def wait_for_pose(board, limit_s=BOOT_LIMIT_S):
    """Returns seconds until Modbus reports a valid pose that is followed by another one"""
    started, seen, last = time.monotonic(), None, None
    while time.monotonic() - started < limit_s:
        found = board.registers(0, 10)
        if found:
            require(found[0] == MAGIC, f"register 0 is {found[0]:#06x}")
            last = found
            if found[4] & STATUS_VALID:
                if seen is not None and seen != found[3]:
                    return time.monotonic() - started
                seen = found[3] if seen is None else seen
        board.listen(0.2)  # a console that nobody reads stops whoever writes to it
    raise Failure(f"no valid pose within {limit_s} s; registers 0..9: {last}")


def wait_for_restart(board, restarts, limit_s=120):
    """Returns seconds until systemd has started the service again"""
    started = time.monotonic()
    while time.monotonic() - started < limit_s:
        if (board.run("systemctl show -P NRestarts ninedotd") == str(restarts)
                and board.run("systemctl show -P ActiveState ninedotd") == "active"):
            return time.monotonic() - started
        board.listen(0.5)
    raise Failure(f"not started again within {limit_s} s: " + board.run("journalctl -u ninedotd -n 20 --no-pager"))


def main_pid(board):
    pid = board.run("systemctl show -P MainPID ninedotd")
    require(pid.isdigit() and pid != "0", f"the service does not run: {pid}")
    return pid


def config_sum(board):
    return board.run(f"sha256sum < {CONFIG}").split()[0]


def config_on_fat(work):
    """Returns the sum of what boot_test.sh put there, with the line ends that the board gives it"""
    with open(f"{work}/ninedot.toml", "rb") as file:
        return hashlib.sha256(file.read().replace(b"\r", b"")).hexdigest()


def check_first_boot(board, work):
    started = time.monotonic()
    board.power_on()
    wait_for_pose(board)
    note("first boot, power to a valid pose over Modbus TCP", f"{time.monotonic() - started:.0f} s")
    board.wait_for_shell(120)
    board.run("systemctl is-system-running --wait || true", limit_s=240)
    failed = board.run("systemctl list-units --failed --plain --no-legend")
    require(failed == "", f"failed units: {failed}")
    note("systemd", f"{board.run('systemctl is-system-running')}, no failed unit")

    require(config_sum(board) == config_on_fat(work), f"{CONFIG} is not what the FAT partition holds")
    require(board.run("cat /proc/sys/kernel/hostname") == "cabinet-7", "the hostname was not taken over")
    require("10.0.2.77" in board.run("ip -4 -brief address"), "the network file was not taken over")
    status, said = board.log_in("systemctl is-active ninedotd")
    require((status, said) == (0, "active"), f"login by key: {status}, {said}; " + board.run("journalctl -u ninedotd -n 12 -o short-monotonic --no-pager"))
    note("configuration from the FAT partition", "ninedot.toml, hostname, network, authorized_keys taken over; login by key")


def check_system(board):
    kind = board.run("findmnt -n -o FSTYPE,OPTIONS /")
    status, said = board.try_run("touch /usr/written /etc/written")
    require(kind.startswith("squashfs") and " ro" in kind and status != 0 and "Read-only" in said, f"the root can be written to: {kind}, {said}")
    note("root", f"{kind.split()[0]}, read-only")
    kind = board.run("findmnt -n -o FSTYPE,OPTIONS /data")
    require(kind.startswith("ext4") and " rw" in kind, f"the data partition: {kind}")
    note("data partition", kind.replace("  ", " "))
    pid = main_pid(board)
    status = dict(line.split(":\t", 1) for line in board.run(f"cat /proc/{pid}/status").splitlines() if ":\t" in line)
    user = board.run(f"stat -c %U /proc/{pid}")
    require(user == "ninedot", f"the service runs as {user}")
    require(int(status["CapEff"], 16) == 0 and status["NoNewPrivs"] == "1" and status["Seccomp"] == "2", f"its sandbox: {status}")
    note("service", f"user {user}, no capability, NoNewPrivs, system calls filtered")
    note("memory", f"service {int(status['VmRSS'].split()[0]) // 1024} MiB, board {board.run('sed -n s/^MemAvailable:.//p /proc/meminfo').strip()} free")
    exposure = board.run("systemd-analyze security ninedotd --no-pager | tail -n 1", limit_s=120)
    level = re.search(r"ninedotd.service: ([0-9.]+)", exposure)
    require(level and float(level[1]) <= 2.0, f"systemd's exposure level: {exposure}")
    note("systemd-analyze security", f"exposure {level[1]}")


def check_drivers(board):
    """What Debian's kernel leaves out and the package brings: each driver is the kernel's and finds all that it calls."""
    kernel = board.run("uname -r")
    names = board.run(f"dpkg -L ninedot-modules-{kernel} | sed -n 's/.*extra[/]\\(.*\\)[.]ko$/\\1/p'").split()
    for name in sorted(DRIVERS - set(names)):
        require(f"/{kernel}/kernel/" in board.try_run(f"modinfo -F filename {name}")[1], f"neither the kernel nor ninedot-modules-{kernel} has {name}")
    magic = board.run("modinfo -F vermagic squashfs")
    for name in names:
        status, said = board.try_run(f"modprobe {name}")
        require(status == 0, f"modprobe {name}: {said}; {board.run('dmesg | tail -n 5')}")
        theirs, vermagic = board.run(f"modinfo -F filename {name}; modinfo -F vermagic {name}").splitlines()
        require(f"/{kernel}/extra/" in theirs, f"{name} is not the package's: {theirs}")
        require(vermagic.strip() == magic, f"{name} is another kernel's: {vermagic}")
        require(board.try_run(f"test -d /sys/module/{name.replace('-', '_')}")[0] == 0, f"{name} is not loaded")
    complaints = board.run("dmesg | grep -i -E 'unknown symbol|disagrees about version|invalid module format' || true")
    require(complaints == "", complaints)
    note("drivers that Debian's kernel leaves out", f"loaded, of this very kernel {kernel}: {', '.join(names)}")
    if board.run("sed -n s/^IMAGE_ID=//p /etc/os-release") == "ninedot-arm64-pi5":
        for name in PI5_DRIVERS:
            status, said = board.try_run(f"modprobe {name}")
            require(status == 0, f"modprobe {name}: {said}")
        note("drivers of a Raspberry Pi 5, without the hardware", f"loaded: {', '.join(PI5_DRIVERS)}")


def check_told_overlay(board):
    """boot_test.sh asks for an overlay that there is not: the board says so and starts all the same."""
    for where in ("journalctl -u ninedot-configure -o cat --no-pager", "dmesg"):
        said = board.run(f"{where} | grep \"no overlay 'camera-ov9821'\" || true")
        require(re.search("can have:.* (camera-ov9281|i2c-gpio2-3)", said), f"{where} does not tell of the wrong overlay and of the right ones: {said}")
    note("a wrong dtoverlay line in config.txt", "told in journal and kernel log with the names there are; the board starts")


def check_page(board):
    """With web-token on the FAT partition: served, to who has the token."""
    end = time.monotonic() + 120
    while board.page("/") is None and time.monotonic() < end:
        board.listen(1)
    answer = board.page("/")
    require(answer and answer[0] == 200 and b"ninedot" in answer[1], f"the page: {answer and answer[0]}; " + board.run("journalctl -u ninedot-web -n 20 --no-pager -o cat"))
    answer = board.page("/api/registers")
    require(answer and answer[0] == 401, f"without the token: {answer}")
    answer = board.page("/api/registers", TOKEN)
    require(answer and answer[0] == 200, f"with the token: {answer}")
    mode = board.run("stat -c '%a %U' /etc/ninedot/web-token")
    require(mode == "600 ninedot-web", f"the token's file: {mode}")
    memory = int(board.run("systemctl show -P MemoryCurrent ninedot-web")) >> 20
    note("the page, with web-token on the FAT partition", f"served, to who has the token; {memory} MiB of memory")


def check_restarts(board):
    before = int(board.run("systemctl show -P NRestarts ninedotd"))
    for what, signal, because in (("crash (kill -9)", "KILL", "signal"), ("hang (kill -STOP), ended by the watchdog", "STOP", "watchdog")):
        pid = main_pid(board)
        started = time.monotonic()
        board.run(f"kill -{signal} {pid}")
        before += 1
        wait_for_restart(board, before)
        wait_for_pose(board, limit_s=120)
        took = time.monotonic() - started
        require(main_pid(board) != pid, f"{what}: the same process still runs")
        journal = board.run("journalctl -u ninedotd -n 30 --no-pager -o cat")
        require(f"Failed with result '{because}'" in journal, f"{what}: the journal does not say '{because}': {journal}")
        note(f"after a {what}", f"serves poses again after {took:.0f} s")


# Rewrites the configuration and a counter for as long as there is power, and says which count is on the disk for certain.
WRITER = (r"""(n=%d; while :; do n=$((n + 1)); sed "s/^# cut.*/# cut $n/" """ + CONFIG + r""" > """ + CONFIG + r""".new;"""
          r""" sync """ + CONFIG + r""".new; mv """ + CONFIG + r""".new """ + CONFIG + r"""; sync /etc/ninedot;"""
          r""" echo "durable=$n="; done) &""")


def newest_count(board):
    counts = re.findall(rb"durable=(\d+)=", board.heard)  # whole lines only, and not the echo of the command
    return int(counts[-1]) if counts else 0


def check_power_cuts(board, cuts, rng):
    if not cuts:
        return
    board.run(f"grep -q '^# cut' {CONFIG} || echo '# cut 0' >> {CONFIG}; sync -f {CONFIG}")
    identity = board.run("cat /etc/machine-id")
    rest = board.run(f"grep -v '^# cut' {CONFIG} | sha256sum")
    written = 0
    times = []
    for cut in range(1, cuts + 1):
        board.heard = b""
        board.type(WRITER % written)
        end = time.monotonic() + rng.uniform(1.0, 6.0)
        while time.monotonic() < end or newest_count(board) == 0:
            board.listen(0.2)
            require(time.monotonic() < end + 60, "the writer writes nothing")
        board.cut_power()
        durable = max(newest_count(board), written)

        started = time.monotonic()
        board.power_on()
        wait_for_pose(board)
        times.append(time.monotonic() - started)
        board.wait_for_shell(120)
        require(board.run(f"grep -v '^# cut' {CONFIG} | sha256sum") == rest, f"cut {cut}: the configuration is damaged")
        written = int(board.run(f"sed -n 's/^# cut //p' {CONFIG}"))
        require(written >= durable, f"cut {cut}: {durable} was on the disk, {written} is")
        require(board.run("cat /etc/machine-id") == identity, f"cut {cut}: the board has lost its identity")
        require(board.run("findmnt -n -o FSTYPE /data") == "ext4", f"cut {cut}: the data partition was not mounted")
        require(board.try_run("dmesg | grep -i -E 'EXT4-fs error|damaged'")[0] == 1, f"cut {cut}: " + board.run("dmesg | grep -i -E 'EXT4|damaged'"))
        print(f"   cut {cut}: {written} rewrites of the configuration so far, back after {times[-1]:.0f} s", flush=True)
    note(f"{cuts} power cuts while the configuration was being rewritten",
         f"intact each time, {written} rewrites, none lost; back after {min(times):.0f} to {max(times):.0f} s")


def start_again(board):
    """Returns seconds from power to a valid pose"""
    board.cut_power()
    started = time.monotonic()
    board.power_on()
    wait_for_pose(board)
    took = time.monotonic() - started
    board.wait_for_shell(120)
    return took


def check_new_configuration(board, work):
    """What is on the FAT partition is taken over when it changes there, and only then."""
    board.run(f"echo '# edited on the board' >> {CONFIG}; echo kept > /var/lib/ninedot/kept; sync -f {CONFIG}")
    edited = config_sum(board)
    start_again(board)
    require(config_sum(board) == edited, "what was edited on the board is gone after a restart")
    board.cut_power()
    with open(f"{work}/ninedot.toml", encoding="ascii") as file:
        text = file.read()
    board.put_on_fat(text + "# edited on the card\n", "ninedot.toml")
    board.put_on_fat("cabinet-8\n", "hostname")
    board.take_from_fat("web-token")
    start_again(board)
    require(config_sum(board) == config_on_fat(work), "the new configuration was not taken over")
    require(board.run("cat /proc/sys/kernel/hostname") == "cabinet-8", "the new hostname was not taken over")
    require(board.run("cat /var/lib/ninedot/kept") == "kept", "/var/lib/ninedot was not kept")
    require(board.run("systemctl show -P ActiveState ninedot-web") == "inactive" and board.page("/") is None, "the page is served without its token")
    require(board.try_run("test -e /etc/ninedot/web-token")[0] != 0, "the token is still there")
    note("web-token taken from the FAT partition", "the page is off")
    note("configuration changed on the board, then on the FAT partition", "kept over a restart, then replaced")


def check_lost_storage(board, work):
    """Flash that forgets: the board goes on with the configuration of the FAT partition."""
    board.cut_power()
    board.overwrite(3, 1 << 20)
    start_again(board)
    require(board.run("findmnt -n -o FSTYPE /data") == "ext4", "the data partition was not repaired")
    require(config_sum(board) == config_on_fat(work), "the configuration did not come back from the FAT partition")
    note("the data partition's first MiB overwritten", "repaired at the start, configuration back from the FAT partition")
    board.cut_power()
    board.overwrite(3, 1 << 40)
    start_again(board)
    require(board.run("findmnt -n -o FSTYPE /data") == "tmpfs", "/data is not in memory")
    require(config_sum(board) == config_on_fat(work), "the configuration did not come from the FAT partition")
    require("memory only" in board.run("dmesg"), "the kernel's log does not say that changes are kept in memory")
    note("the data partition overwritten as a whole", "serves poses; changes are kept in memory only, and the kernel's log says so")


def main():
    parser = argparse.ArgumentParser()
    for name in ("work", "kernel", "initrd"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--power-cuts", type=int, required=True)
    arguments = parser.parse_args()
    started = time.monotonic()
    board = Board(arguments.work, arguments.kernel, arguments.initrd)
    try:
        check_first_boot(board, arguments.work)
        check_system(board)
        check_drivers(board)
        field_checks.check_kernel(board)
        field_checks.check_identity(board)
        field_checks.check_diagnosis(board)
        field_checks.check_latency(board)
        field_checks.check_clock(board)
        field_checks.check_wifi(board)
        check_told_overlay(board)
        check_page(board)
        check_restarts(board)
        field_checks.check_kept_journal(board, start_again)
        check_power_cuts(board, arguments.power_cuts, random.Random("power cuts"))
        check_new_configuration(board, arguments.work)
        check_lost_storage(board, arguments.work)
    except Failure as failure:
        print(f"FAILED: {failure}", file=sys.stderr)
        return 1
    finally:
        board.cut_power()
    width = max(len(what) for what, _ in table)
    print("\n" + "\n".join(f"{what:<{width}}  {seen}" for what, seen in table) + f"\n\nboot test passed in {time.monotonic() - started:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
