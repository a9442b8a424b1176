"""What `ninedot tap --latencies` prints, and two of it beside each other."""

import re


def read_histogram(said):
    """Returns frames in it, frames processed by the same report, and {upper edge as printed: frames}; nothing where it is no histogram"""
    head = re.match(r"latency of (\d+) frames since the start \((\d+) processed\)", said)
    if not head:
        return None
    bins = {edge: int(count) for edge, count in re.findall(r"(?m)^((?:up to|above) +[\d.]+ ms) +(\d+) ", said)}
    return int(head[1]), int(head[2]), bins


def in_order(edge):
    """The last bin takes all that is longer: it is called by the edge of the one before."""
    return float(edge.split()[-2]), edge.startswith("above")


def side_by_side(columns):
    """\\param columns  {name: bins}. Returns a table's lines: frames of each bin that one of them has, and their share of all of that column"""
    sums = {name: sum(bins.values()) for name, bins in columns.items()}
    edges = sorted(set().union(*columns.values()), key=in_order)
    lines = [f"{'exposure to report':18}" + "".join(f"{name:>24}" for name in columns)]
    for edge in edges:
        cells = ((bins.get(edge, 0), sums[name]) for name, bins in columns.items())
        lines.append(f"{edge:18}" + "".join(f"{count:>14} {100 * count / max(of, 1):>7.2f} %" for count, of in cells))
    return lines + [f"{'all':18}" + "".join(f"{of:>14}{'':10}" for of in sums.values()).rstrip()]
