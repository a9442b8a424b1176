#!/usr/bin/python3
"""Draws the rooms of the product and who includes whom, as SVG: docs/rooms.svg.

    tests/draw_rooms.py [ROOT] > docs/rooms.svg

A room is a folder of sources; its area grows with its lines. It stands above all that it includes, so that every arrow points down; one that
runs back up would be red. Read from the includes themselves, as tests/layers_test.py reads them.
"""
import os
import sys

import layers_test as layers

COLOURS = {"programs": "#f3d9b1", "drivers": "#c9dcf0", "firmware": "#d3ead0", "proto": "#ead3e8"}
WIDTH, ROW_PX, TOP_PX = 1180, 118, 74


def rooms_and_arrows(root):
    lines, arrows = {}, set()
    for path in layers.sources(root):
        room = os.path.dirname(path)
        with open(os.path.join(root, path), encoding="utf-8") as file:
            text = file.read().splitlines()
        lines[room] = lines.get(room, 0) + len(text)
        for line in text:
            match = layers.INCLUDE.match(line)
            target = layers.resolve(root, path, match.group(2)) if match else None
            if target and os.path.dirname(target) != room:
                arrows.add((room, os.path.dirname(target)))
    return lines, arrows


def levels(rooms, arrows):
    """How far each room is above the bottom: one more than the highest that it includes. Arrows in a circle are left out one by one."""
    upward = set()
    while True:
        level = {room: 0 for room in rooms}
        for _ in rooms:
            for above, below in arrows - upward:
                level[above] = max(level[above], level[below] + 1)
        if max(level.values()) < len(rooms):
            return level, upward
        high = max(level, key=level.get)
        upward.add(next((a, b) for a, b in sorted(arrows - upward) if a == high or b == high))


def svg(root):
    lines, arrows = rooms_and_arrows(root)
    level, upward = levels(lines, arrows)
    firmware = sum(size for room, size in lines.items() if room.startswith("firmware/"))
    # base is below everything, whatever folder it lies in.
    tops = {(a.split("/")[0], b.split("/")[0]) for a, b in arrows if b != "firmware/base" and a.split("/")[0] != b.split("/")[0]}
    circles = sorted({tuple(sorted(pair)) for pair in tops if pair[::-1] in tops})
    height = TOP_PX + (max(level.values()) + 1) * ROW_PX
    place, boxes = {}, []
    for row in range(max(level.values()) + 1):
        here = sorted(room for room in lines if level[room] == row)
        for i, room in enumerate(here):
            side = 26 + 1.15 * lines[room] ** 0.5
            x, y = WIDTH * (i + 0.5) / len(here), height - ROW_PX * (row + 0.5)
            place[room] = (x, y, max(side, 62), min(side, 84))
            share = f", {100 * lines[room] / firmware:.0f} %" if room.startswith("firmware/") else ""
            boxes.append(
                f'<rect x="{x - place[room][2] / 2:.0f}" y="{y - place[room][3] / 2:.0f}" width="{place[room][2]:.0f}" height="{place[room][3]:.0f}" '
                f'rx="4" fill="{COLOURS[room.split("/")[0]]}" stroke="#444"/>'
                f'<text x="{x:.0f}" y="{y - 1:.0f}" font-weight="bold">{room.split("/")[-1]}</text>'
                f'<text x="{x:.0f}" y="{y + 12:.0f}" font-size="10">{lines[room]}{share}</text>')
    paths = []
    for above, below in sorted(arrows):
        (x1, y1, _, h1), (x2, y2, _, h2) = place[above], place[below]
        colour, width = ("#c00", 2) if (above, below) in upward else ("#8a8a8a", 0.8)
        paths.append(f'<path d="M{x1:.0f},{y1 + h1 / 2:.0f} C{x1:.0f},{y1 + 70:.0f} {x2:.0f},{y2 - 70:.0f} {x2:.0f},{y2 - h2 / 2:.0f}" '
                     f'fill="none" stroke="{colour}" stroke-width="{width}" marker-end="url(#tip)"/>')
    legend = "".join(f'<rect x="{20 + 120 * i}" y="36" width="16" height="16" fill="{colour}" stroke="#444"/>'
                     f'<text x="{42 + 120 * i}" y="48" text-anchor="start">{top}</text>' for i, (top, colour) in enumerate(COLOURS.items()))
    words = f"{len(lines)} rooms, {len(arrows)} arrows, {len(upward)} of them upwards; "
    words += "; ".join(f"{a} and {b} include each other" for a, b in circles) or "no two of programs, drivers, firmware and proto include each other"
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="12" text-anchor="middle">'
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
            '<path d="M0,0 L8,4 L0,8 z" fill="#8a8a8a"/></marker></defs>'
            f'<rect width="{WIDTH}" height="{height}" fill="white"/>'
            f'<text x="20" y="22" text-anchor="start" font-size="14">{words}. Numbers: lines, and the share of firmware.</text>{legend}'
            + "".join(paths) + "".join(boxes) + "</svg>\n")


if __name__ == "__main__":
    here = os.path.dirname(os.path.abspath(__file__))
    sys.stdout.write(svg(sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "..")))
