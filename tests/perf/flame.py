# SPDX-License-Identifier: Apache-2.0
"""Flame graphs (Gregg 2016, The Flame Graph, CACM 59:6) as SVG: a bar's width is CPU time, what it calls stands on it."""

import html
import zlib

WIDTH, ROW, NARROWEST = 1200, 16, 0.4  # pixels


def write_flame(path, title, samples):
    """samples: (milliseconds, ["file:function", ...] from the innermost on)."""
    tree = {"ms": 0.0, "calls": {}}
    for ms, frames in samples:
        node = tree
        node["ms"] += ms
        for frame in reversed(frames):
            node = node["calls"].setdefault(frame, {"ms": 0.0, "calls": {}})
            node["ms"] += ms
    scale = WIDTH / max(tree["ms"], 1e-9)
    rows = depth(tree, scale)
    height = (rows + 2) * ROW
    bars = []
    draw(tree, 0.0, 0, scale, height, tree["ms"], bars)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="sans-serif" font-size="11">\n'
        f'<rect width="100%" height="100%" fill="white"/>\n'
        f'<text x="4" y="12">{html.escape(title)}: {tree["ms"]:.0f} ms of CPU across the whole width</text>\n' + "".join(bars) + "</svg>\n")


def depth(node, scale):
    return 1 + max((depth(c, scale) for c in node["calls"].values() if c["ms"] * scale >= NARROWEST), default=0)


def draw(node, x, level, scale, height, whole, bars):
    for frame, call in sorted(node["calls"].items()):
        width = call["ms"] * scale
        if width >= NARROWEST:
            bars.append(bar(frame, x, height - (level + 1) * ROW, width, call["ms"], whole))
            draw(call, x, level + 1, scale, height, whole, bars)
        x += width


def bar(frame, x, y, width, ms, whole):
    function = frame.rsplit(":", 1)[-1]
    shown = function[:int(width / 6.5)] if width > 20 else ""
    hue = zlib.crc32(frame.split(":")[0].encode()) % 60  # one colour a file
    return (f'<g><title>{html.escape(frame)}: {ms:.0f} ms, {100 * ms / whole:.1f} %</title>'
            f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{ROW - 1}" fill="hsl({hue},80%,65%)"/>'
            f'<text x="{x + 2:.1f}" y="{y + 11}">{html.escape(shown)}</text></g>\n')
