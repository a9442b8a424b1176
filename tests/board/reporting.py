"""What the boot test's checks have in common: the table of what was seen, and what must hold."""

from qemu_board import Failure

table = []


def note(what, seen):
    """One row of the table that is printed at the end, and at once for whoever watches."""
    table.append((what, seen))
    print(f"ok: {what}: {seen}", flush=True)


def require(condition, what):
    if not condition:
        raise Failure(what)
