"""svg_chart: line charts as SVG, for the figures of docs/. Python's standard library only.

    import svg_chart as chart

    speed = chart.Panel("speed", "triangles", "Mrays/s", [
        chart.Line("ours", [(100, 3.1), (1000, 2.2)], style=0),
        chart.Line("grid", [(100, 1.9)], style=1, gave_up=True)])
    chart.write("speed.svg", "How fast", [("a ball", [speed])], note="higher is better")

Good for: a few lines over a few decades, small panels side by side that share their lines. Both axes are logarithmic
unless a panel says `log_x=False` or `log_y=False`. Each line is named at its end; names are moved apart and never
overlap. A style is a colour, a marker and a dash together (M. Okabe, K. Ito, "Color Universal Design", 2008), so that lines can be
told apart in grey and by the colour-blind. Style 0 is black and thick: what the figure is about. A line that
gave up ends in a hollow marker. A band (`Band`) is a translucent strip between two curves: an interval of confidence.

Not for: points beyond a line's first gap, negative numbers on logarithmic axes (ValueError), interaction.
SPDX-License-Identifier: MIT
"""

import dataclasses
import math
import os
import xml.sax.saxutils

WIDTH, HEIGHT = 224, 220  # of a panel's plot
LEFT, TOP, BOTTOM = 58, 26, 44  # about it; on the right, the names
HEADING, TITLE, NOTE = 24, 30, 18  # of a row, the whole, a line of the note
FONT, SMALL = 12, 11
LETTER = 0.6  # width of a letter at the most on average, in parts of its size
LABEL_STEP = 14  # between the names of two lines
INK, GREY, FAINT = "#1a1a1a", "#5a5a5a", "#e3e3e3"

# colour, marker, dash, width
STYLES = [
    ("#000000", "circle", "", 2.6),
    ("#0072b2", "square", "7 3", 1.6),
    ("#d55e00", "triangle", "2 2.5", 1.6),
    ("#009e73", "diamond", "9 3 2 3", 1.6),
    ("#cc79a7", "cross", "", 1.6),
    ("#e69f00", "pentagon", "4 2", 1.6),
    ("#56b4e9", "wedge", "1 3", 1.6),
]


@dataclasses.dataclass
class Line:
    """points: (x, y), x ascending. gave_up: there is no value at the next x, which is worth telling."""
    name: str
    points: list
    style: int
    gave_up: bool = False


@dataclasses.dataclass
class Band:
    """Between (x, low) and (x, high), in the colour of a style."""
    points: list  # (x, low, high)
    style: int


@dataclasses.dataclass
class Panel:
    """x_range and y_range, (least, most), make panels comparable; left out, the data decide."""
    title: str
    x_label: str
    y_label: str
    lines: list
    bands: list = dataclasses.field(default_factory=list)
    x_range: tuple = None
    y_range: tuple = None
    log_x: bool = True
    log_y: bool = True


class Axis:
    """Values to a length in pixels, and where its ticks are."""

    def __init__(self, values, bounds, log, length):
        least, most = bounds or (min(values), max(values))
        if log and least <= 0:
            raise ValueError(f"a logarithmic axis begins above 0, not at {least}")
        self.log, self.length = log, length
        a, b = self._scale(least), self._scale(most)
        room = 0 if bounds else 0.05 * (b - a) or 0.5
        self.begin, self.end = a - room, b + room

    def _scale(self, value):
        return math.log10(value) if self.log else value

    def at(self, value):
        return (self._scale(value) - self.begin) / (self.end - self.begin) * self.length

    def ticks(self):
        """(value, its text or None), ascending."""
        found = self._log_ticks() if self.log else self._even_ticks()
        return [(v, t) for v, t in found if -0.01 <= self.at(v) <= self.length + 0.01]

    def _log_ticks(self):
        decades = self.end - self.begin
        named = (1,) if decades > 1.7 else (1, 2, 5) if decades > 0.7 else range(1, 10)
        for power in range(math.floor(self.begin), math.ceil(self.end) + 1):
            for m in range(1, 10):
                value = float(f"{m}e{power}")
                if m in named or decades < 4:
                    yield value, number(value) if m in named else None

    def _even_ticks(self):
        raw = (self.end - self.begin) / 6
        power = 10 ** math.floor(math.log10(raw))
        step = next(m * power for m in (1, 2, 5, 10) if m * power >= raw)
        for i in range(math.ceil(self.begin / step), math.floor(self.end / step) + 1):
            yield i * step, number(i * step)


def number(value):
    """1e-05 as 10⁻⁵, 0.001, 1, 1000 as 1 k, 1e6 as 1 M."""
    if value and abs(value) < 0.001:
        power = math.floor(math.log10(abs(value)) + 1e-9)
        head = f"{value / 10 ** power:g}×" if round(value / 10 ** power, 6) != 1 else ""
        return head + "10" + str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    for size, letter in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(value) >= size:
            return f"{value / size:g} {letter}"
    return f"{value:g}"


def text(x, y, what, size=SMALL, anchor="start", color=INK, more=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{color}"{more}>'
            f"{xml.sax.saxutils.escape(what)}</text>")


def polygon(x, y, corners):
    return "M" + "L".join(f"{x + a:.1f} {y + b:.1f}" for a, b in corners) + "Z"


def marker(x, y, style, hollow=False):
    color, shape, _, _ = STYLES[style]
    around = [(math.sin(2 * math.pi * i / 5), -math.cos(2 * math.pi * i / 5)) for i in range(5)]
    paint = f'fill="{"#ffffff" if hollow else color}" stroke="{color}" stroke-width="1.2"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" {paint}/>'
    if shape == "cross":
        arms = f"M{x - 3.4:.1f} {y - 3.4:.1f}l6.8 6.8M{x - 3.4:.1f} {y + 3.4:.1f}l6.8 -6.8"
        ring = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.8" {paint}/>' if hollow else ""
        return ring + f'<path d="{arms}" stroke="{color}" stroke-width="2" fill="none"/>'
    corners = {
        "square": [(-3.2, -3.2), (3.2, -3.2), (3.2, 3.2), (-3.2, 3.2)],
        "triangle": [(0, -4.2), (4, 3), (-4, 3)],
        "diamond": [(0, -4.4), (4.4, 0), (0, 4.4), (-4.4, 0)],
        "pentagon": [(4.2 * a, 4.2 * b) for a, b in around],
        "wedge": [(0, 4.2), (4, -3), (-4, -3)],
    }[shape]
    return f'<path d="{polygon(x, y, corners)}" {paint}/>'


def apart(wanted, step, low, high):
    """Heights as near the wanted ones as can be, `step` apart, in the same order, between low and high.

    Neighbours that touch make a block, which lies at the mean of what its members want."""
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    blocks = []  # [first height wanted on average, members]
    for rank, i in enumerate(order):
        blocks.append([wanted[i] - step * rank, 1])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            mean, count = blocks.pop()
            total = blocks[-1][1] + count
            blocks[-1] = [(blocks[-1][0] * blocks[-1][1] + mean * count) / total, total]
    flat = [mean for mean, count in blocks for _ in range(count)]
    top, last = low, high - step * (len(wanted) - 1)
    heights = [0.0] * len(wanted)
    for rank, i in enumerate(order):
        heights[i] = max(top, min(flat[rank], last)) + step * rank
    return heights


def axes(panel, x, y):
    """The frame with its ticks, from the plot's top left corner (0, 0)."""
    out = [text(0, -10, panel.title, FONT, more=' font-weight="bold"')]
    for value, name in x.ticks():
        at = x.at(value)
        out.append(f'<path d="M{at:.1f} 0V{HEIGHT}" stroke="{FAINT}" stroke-width="{1 if name else 0.4}"/>')
        if name:
            out.append(text(at, HEIGHT + 16, name, anchor="middle"))
    for value, name in y.ticks():
        at = HEIGHT - y.at(value)
        out.append(f'<path d="M0 {at:.1f}H{WIDTH}" stroke="{FAINT}" stroke-width="{1 if name else 0.4}"/>')
        if name:
            out.append(text(-7, at + 4, name, anchor="end"))
    out.append(f'<path d="M0 0V{HEIGHT}H{WIDTH}" stroke="{GREY}" fill="none"/>')
    out.append(text(WIDTH / 2, HEIGHT + 34, panel.x_label, anchor="middle", color=GREY))
    out.append(text(0, 0, panel.y_label, anchor="middle", color=GREY,
                    more=f' transform="translate({14 - LEFT} {HEIGHT / 2}) rotate(-90)"'))
    return out


def names(lines, ends):
    """Each line's name beside the plot, at its end's height or near it; a thin line leads there."""
    out = []
    for line, (x, y), at in zip(lines, ends, apart([y for _, y in ends], LABEL_STEP, 0, HEIGHT)):
        color = STYLES[line.style][0]
        if abs(at - y) > 2 or x < WIDTH - 20:
            out.append(f'<path d="M{x + 6:.1f} {y:.1f}L{WIDTH + 5} {at:.1f}" stroke="{color}" stroke-width="0.7"/>')
        out.append(marker(WIDTH + 12, at, line.style, line.gave_up))
        bold = ' font-weight="bold"' if line.style == 0 else ""
        out.append(text(WIDTH + 20, at + 4, line.name, more=bold))
    return out


def draw(panel):
    """One panel, from the plot's top left corner."""
    lines = [line for line in panel.lines if line.points]
    xs = [p[0] for line in lines for p in line.points] + [p[0] for b in panel.bands for p in b.points]
    ys = [p[1] for line in lines for p in line.points] + [v for b in panel.bands for p in b.points for v in p[1:]]
    x = Axis(xs, panel.x_range, panel.log_x, WIDTH)
    y = Axis(ys, panel.y_range, panel.log_y, HEIGHT)
    out = axes(panel, x, y)
    for band in panel.bands:
        edge = [(x.at(a), HEIGHT - y.at(low)) for a, low, _ in band.points]
        edge += [(x.at(a), HEIGHT - y.at(high)) for a, _, high in reversed(band.points)]
        out.append(f'<path d="{polygon(0, 0, edge)}" fill="{STYLES[band.style][0]}" fill-opacity="0.18"/>')
    ends = []
    for line in sorted(lines, key=lambda one: -one.style):  # the first style on top
        color, _, dash, width = STYLES[line.style]
        spots = [(x.at(a), HEIGHT - y.at(b)) for a, b in line.points]
        path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in spots)
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        out.append(f'<path d="{path}" stroke="{color}" stroke-width="{width}" fill="none"{dashes}/>')
        out += [marker(a, b, line.style, line.gave_up and i == len(spots) - 1) for i, (a, b) in enumerate(spots)]
    for line in lines:
        a, b = line.points[-1]
        ends.append((x.at(a), HEIGHT - y.at(b)))
    return out + names(lines, ends)


def figure(title, rows, note=""):
    """SVG text. rows: (heading, panels) each; note: lines below, what one sees."""
    columns = max(len(panels) for _, panels in rows)
    notes = note.split("\n") if note else []
    longest = max(len(line.name) for _, panels in rows for panel in panels for line in panel.lines)
    step_x, step_y = LEFT + WIDTH + 26 + math.ceil(LETTER * SMALL * longest), HEADING + TOP + HEIGHT + BOTTOM
    width, height = columns * step_x, TITLE + len(rows) * step_y + NOTE * len(notes) + 10
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           f'role="img" font-family="Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif">',
           f"<title>{xml.sax.saxutils.escape(title)}</title>",
           f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
           text(14, 24, title, 16, more=' font-weight="bold"')]
    for i, (heading, panels) in enumerate(rows):
        top = TITLE + i * step_y
        out.append(text(14, top + 16, heading, 13, color=GREY))
        for j, panel in enumerate(panels):
            out.append(f'<g transform="translate({j * step_x + LEFT} {top + HEADING + TOP})">')
            out += draw(panel) + ["</g>"]
    for i, line in enumerate(notes):
        out.append(text(14, TITLE + len(rows) * step_y + NOTE * (i + 0.5), line, color=GREY))
    return "\n".join(out + ["</svg>", ""])


def write(path, title, rows, note=""):
    """The whole file or none of it."""
    made = figure(title, rows, note)
    with open(path + ".new", "w", encoding="utf-8") as f:
        f.write(made)
    os.replace(path + ".new", path)
