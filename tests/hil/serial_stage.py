"""Modbus RTU over emulated serial ports, one of them a USB adapter that is pulled, and TCP over the emulated network; the masters are
pymodbus and mbpoll on the host."""

import inspect
import logging
import re
import select
import subprocess
import threading
import time

from cable import Cable
from registers import DifferenceFromRow, Registers, register_count
from service import GuestService, nearest_row, replay
from service_harness import Client

SMOKE_CHECKS = ("rtu-pymodbus", "rtu-write", "rtu-refusal", "rtu-other-unit", "rtu-noise", "ends")
CHECKS = SMOKE_CHECKS + (
    "rtu-input-registers",
    "rtu-mbpoll",
    "rtu-torn",
    "rtu-and-tcp",
    "tcp-clients",
    "tcp-mbpoll",
    "tcp-unplugged",
    "usb-pymodbus",
    "usb-unplugged",
    "usb-absent",
)

UNIT = 7
POLLING_S = 6.0
UNPLUGGED_TIMES = 5
TCP_CLIENTS = 8


def config(device):
    return f"""[camera]
source = "recording"
device = "/media/scenes"
rate_hz = 10.0
[pose]
tracking = false
[modbus]
allow_writes = true
[modbus.tcp]
listen = "0.0.0.0"
port = 1502
[modbus.rtu]
device = "{device}"
baud = 115200
parity = "E"
unit = {UNIT}
"""


class Master(Client):
    """pymodbus on a terminal, with a patience that suits a line that is pulled."""

    def __init__(self, device, unit=UNIT, timeout_s=2.0):
        import pymodbus.client

        options = {"retries": 0} if "retries" in inspect.signature(pymodbus.client.ModbusSerialClient).parameters else {}
        self.client = pymodbus.client.ModbusSerialClient(
            device, baudrate=115200, parity="N", stopbits=1, timeout=timeout_s, **options
        )
        names = inspect.signature(self.client.read_holding_registers).parameters
        self.unit = {next((name for name in ("device_id", "slave", "unit") if name in names), "slave"): unit}


class SerialStage:
    def __init__(self, stage, guest):
        self.stage, self.guest = stage, guest
        guest.check("modprobe ftdi_sio; modprobe xhci_pci")
        self.rows = replay(guest, "/media/scenes")
        self.port = self.find_port()

    def find_port(self):
        """The PCI card's port; the console is the first one."""
        lines = self.guest.check("cat /proc/tty/driver/serial").splitlines()
        ports = [line.split(":")[0] for line in lines if re.match(r"\d+: uart:16", line) and not line.startswith("0:")]
        if len(ports) != 1:
            raise AssertionError(f"one serial port was expected beside the console: {lines}")
        return f"/dev/ttyS{ports[0]}"

    def differences(self, words):
        registers = Registers(words)
        if not registers.valid_when_taken:
            return []
        return DifferenceFromRow(registers, nearest_row(self.rows, registers)).differences

    def poll(self, client, seconds, holding=True):
        """\\return  (reads, failures, differences, longest answer in seconds)"""
        reads, failures, wrong, longest = 0, 0, [], 0.0
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            started = time.monotonic()
            try:
                words = client.read(0, 86, holding)
            except Exception:
                failures += 1
                continue
            longest = max(longest, time.monotonic() - started)
            reads += 1
            wrong += self.differences(words)[:1]
        return reads, failures, wrong, longest

    def polled(self, check, client, seconds=POLLING_S, holding=True):
        reads, failures, wrong, longest = self.poll(client, seconds, holding)
        self.stage.ok(
            check,
            reads > 10 and not failures and not wrong,
            "; ".join(wrong[:2])
            or f"{reads} reads of 86 registers in {seconds:.0f} s, {failures} failed, poses equal the replay's, "
            f"longest {1000 * longest:.0f} ms",
        )

    def mbpoll(self, check, *arguments):
        good = 0
        for _ in range(10):
            result = subprocess.run(
                ["mbpoll", "-0", "-r", "0", "-c", "2", "-t", "4:hex", "-1", "-q", *arguments],
                capture_output=True,
                text=True,
                timeout=30,
            )
            good += bool(re.search(r"\[0\]:\s+0x9D09", result.stdout)) and result.returncode == 0
        self.stage.ok(
            check,
            good == 10,
            f"{good} of 10 calls read the magic number" + ("" if good == 10 else f"; {result.stdout} {result.stderr}"),
        )

    def writes(self, client):
        keyword = client.unit
        single = client.client.write_register(105, 123, **keyword)
        several = client.client.write_registers(105, [321, 0xFFFF], **keyword)
        back = client.read(105, 2)
        self.stage.ok(
            "rtu-write",
            not single.isError() and not several.isError() and back == [321, 0xFFFF],
            f"function codes 06 and 16, read back {back}",
        )
        refused = client.client.write_register(16, 1, **keyword)
        last = register_count() - 1
        beyond = client.client.read_holding_registers(last, count=2, **keyword)
        self.stage.ok(
            "rtu-refusal",
            refused.isError() and getattr(refused, "exception_code", 0) == 2 and getattr(beyond, "exception_code", 0) == 2 and len(client.read(last, 1)) == 1,
            f"exception 02 for a register that can't be written, and for the one after {last}, the map's last",
        )

    def other_units(self, client):
        ((keyword, unit),) = client.unit.items()
        try:
            answered = not client.client.read_holding_registers(0, count=2, **{keyword: unit + 1}).isError()
        except Exception:
            answered = False
        client.read(0, 2)
        self.stage.ok(
            "rtu-other-unit",
            not answered,
            "a request for another unit stays without an answer, the next one for ours is answered",
        )

    def noise(self, cable, client):
        before = Registers(client.read(0, 86)).bus_errors
        cable.send(bytes(range(1, 60)))
        time.sleep(0.3)
        after = Registers(client.read(0, 86)).bus_errors
        self.stage.ok(
            "rtu-noise", after > before, f"noise on the line: {after - before} bus errors counted, the next request answered"
        )

    def torn(self, cable, client):
        """USB adapters deliver a request in pieces."""
        client.client.close()
        request = bytes([UNIT, 3, 0, 0, 0, 1])
        crc = 0xFFFF
        for byte in request:
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
        request += bytes([crc & 0xFF, crc >> 8])
        reply = b""
        with open(cable.device, "r+b", buffering=0) as terminal:
            cable.send(request[:5])
            time.sleep(0.008)
            cable.send(request[5:])
            until = time.monotonic() + 2
            while len(reply) < 7 and select.select([terminal], [], [], max(0, until - time.monotonic()))[0]:
                reply += terminal.read(64)
        self.stage.ok(
            "rtu-torn",
            reply[:5] == bytes([UNIT, 3, 2, 0x9D, 0x09]),
            f"a request in two pieces 8 ms apart is answered: {reply.hex(' ')}",
        )

    def serial_card(self, folder):
        with Cable(folder / "card") as cable:
            service = GuestService(self.guest, config(self.port))
            with service:
                service.wait_for(lambda registers: registers.valid, "a valid pose")
                with Master(cable.device) as client:
                    self.polled("rtu-pymodbus", client)
                    self.writes(client)
                    self.other_units(client)
                    self.noise(cable, client)
                    if self.stage.smoke:
                        return service
                    self.polled("rtu-input-registers", client, 2, holding=False)
                self.mbpoll("rtu-mbpoll", "-m", "rtu", "-a", str(UNIT), "-b", "115200", "-P", "none", cable.device)
                with Master(cable.device) as client:
                    self.torn(cable, client)
                with Master(cable.device) as client:
                    self.both(service, client)
                self.network(service)
        return service

    def both(self, service, client):
        results = {}
        thread = threading.Thread(target=lambda: results.update(tcp=self.poll(service.client, 4)))
        thread.start()
        results["rtu"] = self.poll(client, 4)
        thread.join()
        failures = sum(result[1] for result in results.values())
        wrong = sum((result[2] for result in results.values()), [])
        self.stage.ok(
            "rtu-and-tcp",
            not failures and not wrong and all(result[0] > 10 for result in results.values()),
            f"both masters at once: {results['rtu'][0]} reads by RTU, {results['tcp'][0]} by TCP in 4 s, {failures} failed, "
            f"{len(wrong)} differ from the replay's",
        )

    def network(self, service):
        clients = [Client(port=self.guest.modbus_port).__enter__() for _ in range(TCP_CLIENTS)]
        results = []
        threads = [threading.Thread(target=lambda c=c: results.append(self.poll(c, 3))) for c in clients]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        connected = service.read().word(77)
        for client in clients:
            client.__exit__()
        left, _ = service.wait_for(lambda registers: registers.word(77) <= 2, "closed connections vanish from register 77", 10)
        failures, wrong = sum(r[1] for r in results), sum((r[2] for r in results), [])
        self.stage.ok(
            "tcp-clients",
            not failures and not wrong and connected >= TCP_CLIENTS,
            f"{TCP_CLIENTS} clients at once: {sum(r[0] for r in results)} reads in 3 s, {failures} failed; "
            f"connected clients {connected}, afterwards {left.word(77)}",
        )
        self.mbpoll("tcp-mbpoll", "-m", "tcp", "-a", "1", "-p", str(self.guest.modbus_port), "127.0.0.1")
        self.guest.qmp("set_link", name="net", up=False)
        time.sleep(2)
        self.guest.qmp("set_link", name="net", up=True)
        plugged = time.monotonic()
        service.client.__exit__()
        service.client = Client(port=self.guest.modbus_port).__enter__()
        service.client.read(0, 2)
        again_s = time.monotonic() - plugged
        self.stage.ok(
            "tcp-unplugged",
            again_s < 10,
            f"network cable pulled for 2 s: a new connection is answered {again_s:.1f} s after it is back",
        )

    def usb_adapter(self, folder):
        node = "/dev/ttyUSB0"
        with Cable(folder / "usb") as cable:
            self.guest.check(f"for _ in $(seq 100); do [ -e {node} ] && break; sleep 0.1; done; ls {node}")
            service = GuestService(self.guest, config(node))
            with service, Master(cable.device, timeout_s=1.0) as client:
                service.wait_for(lambda registers: registers.valid, "a valid pose")
                self.polled("usb-pymodbus", client, 4)
                losses_before = service.read().bus_errors
                rows, wrong = [], []
                self.stage.begin("usb-unplugged")
                for turn in range(1, UNPLUGGED_TIMES + 1):
                    wrong += [f"time {turn}: {what}" for what in self.pull(service, cable, client, node, turn, rows)]
                counted = service.read().bus_errors - losses_before
                worst = max((row[3] for row in rows), default=0)
                self.stage.ok(
                    "usb-unplugged",
                    not wrong and counted >= UNPLUGGED_TIMES,
                    f"{UNPLUGGED_TIMES} times while polling: {'; '.join(wrong) or 'TCP and the frames went on'}, {counted} bus errors counted, "
                    f"answers again after {worst:.1f} s at most",
                )
                self.stage.table(
                    "USB adapter pulled while polling",
                    ("time", "pulled for", "node gone", "answers again after"),
                    [(turn, f"{pulled:.1f} s", gone, f"{again:.1f} s") for turn, pulled, gone, again in rows],
                )
        self.absent(node)
        return service

    def pull(self, service, cable, client, node, turn, rows):
        """\\return  what is not as it has to be"""
        frames = service.read().processed
        pulled_at = time.monotonic()
        cable.unplug()
        lost = False
        while time.monotonic() - pulled_at < 0.4 * turn:
            try:
                client.read(0, 2)
            except Exception:
                lost = True
        gone = self.guest.run(f"test -e {node}")[0] != 0
        goes_on = service.read().processed > frames
        cable.plug()
        plugged_at = time.monotonic()
        while True:
            try:
                client.read(0, 2)
                break
            except Exception:
                if time.monotonic() - plugged_at > 30:
                    raise AssertionError(
                        f"the serial line is not served again; log:\n{service.log()}\n{self.guest.check('ls /dev/ttyUSB*; dmesg | tail')}"
                    )
                client.client.close()
                client.client.connect()
        rows.append((turn, plugged_at - pulled_at, "yes" if gone else "no", time.monotonic() - plugged_at))
        return [what for what, is_so in (("the line is still served", not lost), ("the node is still there", not gone), ("no frame since", not goes_on)) if is_so]

    def absent(self, node):
        self.guest.run(f"for _ in $(seq 50); do [ -e {node} ] || break; sleep 0.1; done")
        self.guest.write("/tmp/ninedotd.toml", config(node))
        status, text = self.guest.run("timeout -s INT 5 ninedotd --config /tmp/ninedotd.toml")
        waits = [line for line in text.splitlines() if "Modbus RTU: not there, waits for it: " in line]
        self.stage.ok(
            "usb-absent",
            status not in (1, 2) and len(waits) == 1 and node in waits[0] and "connect the adapter" in waits[0],
            f'at its start without the adapter: status {status} of timeout, "{waits[0] if waits else text}"',
        )


def run(stage):
    logging.disable(logging.CRITICAL)
    extra = [
        "-chardev",
        "socket,id=card,path={folder}/card,server=on,wait=off",
        "-device",
        "pci-serial,chardev=card",
        "-chardev",
        "socket,id=usb,path={folder}/usb,server=on,wait=off",
        "-device",
        "qemu-xhci",
        "-device",
        "usb-serial,chardev=usb",
    ]
    with stage.guest(*extra) as guest:
        test = SerialStage(stage, guest)
        service = test.serial_card(guest.folder)
        if not stage.smoke:
            service = test.usb_adapter(guest.folder)
        stage.ok("ends", service.exit_status == "0", f"exit status {service.exit_status} on SIGINT")
