#!/usr/bin/env python3
"""Draws docs/figures/faces.svg: the named faces of every shape. Needs Python alone: scripts/faces_figure.py [OUTPUT]"""

import math
import sys

CELL = (250, 210)
COLUMNS = 3
INK, FILL, WORDS = "#333333", "#dfe8f2", "#0b4f8a"
COS, SIN = math.cos(math.radians(30)), math.sin(math.radians(30))


def project(x, y, z):
    """Isometric view: x to the lower right, y to the upper right, z up."""
    return ((x + y) * COS, (x - y) * SIN - z)


class Cell:
    """One shape in its own coordinates about the middle of its cell."""

    def __init__(self, index, title):
        self.origin = ((index % COLUMNS + 0.5) * CELL[0], (index // COLUMNS + 0.55) * CELL[1])
        left, top = index % COLUMNS * CELL[0], index // COLUMNS * CELL[1]
        self.parts = [text(left + 10, top + 20, title, INK, "start", 13)]

    def at(self, point):
        u, v = project(*point) if len(point) == 3 else (point[0], -point[1])
        return (self.origin[0] + u, self.origin[1] + v)

    def shape(self, points, fill=FILL, dash=""):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, points))
        self.parts.append(f'<polygon points="{path}" fill="{fill}" stroke="{INK}"{dash}/>')

    def line(self, points, dash=""):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, points))
        self.parts.append(f'<polyline points="{path}" fill="none" stroke="{INK}"{dash}/>')

    def label(self, words, point, offset=(0, 0), anchor="middle"):
        x, y = self.at(point)
        u, v = x + offset[0], y + offset[1]
        if offset != (0, 0):
            self.parts.append(f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v - 4:.1f}" stroke="{WORDS}"/>')
        self.parts.append(text(u, v, words, WORDS, anchor, 12))


DASHED = ' stroke-dasharray="4 3"'


def text(x, y, words, colour, anchor, size):
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}">{words}</text>'


def circle(r, z, first=0.0, last=360.0):
    angles = [math.radians(first + (last - first) * k / 48) for k in range(49)]
    return [(r * math.cos(a), r * math.sin(a), z) for a in angles]


def box():
    cell = Cell(0, "box")
    a, b, c = 55, 40, 30
    cell.shape([(-a, -b, c), (a, -b, c), (a, b, c), (-a, b, c)])
    cell.shape([(-a, -b, -c), (a, -b, -c), (a, -b, c), (-a, -b, c)])
    cell.shape([(a, -b, -c), (a, b, -c), (a, b, c), (a, -b, c)])
    cell.label("z+ (end)", (0, 0, c), (0, 4))
    cell.label("y-", (0, -b, 0), (0, 4))
    cell.label("x+", (a, 0, 0), (0, 4))
    cell.label("x-", (-a, 0, 0), (-38, -42))
    cell.label("y+", (0, b, 0), (60, -52))
    cell.label("z- (start)", (0, 0, -c), (-10, 70))
    return cell


def round_body(index, title, bore):
    cell = Cell(index, title)
    r, h = 42, 45
    # The outline of a cylinder seen from above: tangents at +-45 degrees of the isometric view.
    cell.shape(circle(r, -h, -135, 45) + circle(r, h, 45, -135))
    cell.shape(circle(r, h))
    if bore:
        cell.shape(circle(bore, h), "#ffffff")
        cell.line(circle(bore, -h), DASHED)
        cell.label("inner", (-bore * 0.7, bore * 0.7, h * 0.9), (-75, -28))
        cell.label("z+ (end)", (0.75 * r, 0, h), (52, -36))
    else:
        cell.label("z+ (end)", (0, 0, h), (0, 4))
    cell.label("outer" if bore else "jacket", (0, -r, 0), (10, 4))
    cell.label("z- (start)", (0, 0, -h), (-68, 30))
    return cell


def ball(index):
    cell = Cell(index, "sphere, ellipsoid")
    cell.shape([(55 * math.cos(math.radians(a)), 55 * math.sin(math.radians(a))) for a in range(0, 360, 5)])
    cell.line([(55 * math.cos(math.radians(a)), 16 * math.sin(math.radians(a))) for a in range(180, 361, 5)])
    cell.label("surface", (0, 10))
    return cell


def rectangle(index):
    cell = Cell(index, "rectangle (plane)")
    a, b = 70, 35
    cell.shape([(-a, -b), (a, -b), (a, b), (-a, b)])
    cell.label("x- (start)", (-a, 0), (30, -2), "start")
    cell.label("x+ (end)", (a, 0), (-12, 22), "end")
    cell.label("y-", (0, -b), (0, 18))
    cell.label("y+", (0, b), (0, -8))
    return cell


def disc(index):
    cell = Cell(index, "disc (plane)")
    cell.shape([(50 * math.cos(math.radians(a)), 50 * math.sin(math.radians(a))) for a in range(0, 360, 5)])
    cell.label("rim", (35, 35), (30, -12))
    return cell


def meridian(index, title, outline, labels):
    """A half section in (r, z): r to the right, z up, with the axis."""
    cell = Cell(index, title)
    cell.line([(-35, -85), (-35, 85)], ' stroke-dasharray="8 3 2 3"')
    cell.shape([(r - 35, z) for r, z in outline])
    for words, (r, z), offset, anchor in labels:
        cell.label(words, (r - 35, z), offset, anchor)
    return cell


def meridians():
    rod = meridian(
        5, "rod (axisymmetric)", [(0, -60), (45, -60), (45, 60), (0, 60)],
        [("z+ (end)", (25, 60), (25, -6), "start"), ("z- (start)", (25, -60), (25, 20), "start"),
         ("jacket", (45, 0), (25, 4), "start")],
    )
    arc = [(45 * math.sin(math.radians(a)), -15 - 45 * math.cos(math.radians(a))) for a in range(0, 91, 5)]
    spherical = meridian(
        6, "rod-spherical-end", arc + [(45, 60), (0, 60)],
        [("z+ (end)", (25, 60), (25, -6), "start"), ("z- (start)", (33, -46), (25, 18), "start"),
         ("jacket", (45, 20), (25, 4), "start")],
    )
    tube = meridian(
        7, "hollow-cylinder (axisymmetric)", [(40, -60), (75, -60), (75, 60), (40, 60)],
        [("z+ (end)", (57, 60), (30, -6), "start"), ("z- (start)", (57, -60), (30, 20), "start"),
         ("inner", (40, 0), (-22, 24), "end"), ("outer", (75, 0), (20, 4), "start")],
    )
    return [rod, spherical, tube]


def patch(index):
    cell = Cell(index, "nurbs")
    cell.shape([(-70, -30), (-20, -42), (30, -38), (75, -20), (62, 35), (20, 28), (-25, 30), (-62, 42)])
    cell.label("xi-", (-66, 5), (24, 4), "start")
    cell.label("xi+", (69, 8), (-14, 4), "end")
    cell.label("eta-", (5, -40), (0, 20))
    cell.label("eta+", (0, 29), (0, -8))
    cell.label("solid: zeta-, zeta+ too", (0, -84), (0, 0))
    return cell


def gear_tooth(index):
    """A tooth of 12, module 32, with its sector; the axis to the left."""
    cell = Cell(index, "gear-tooth (plane)")
    teeth, alpha, pitch = 12, math.radians(20), 192.0
    base, shift = pitch * math.cos(alpha), 176.0
    root, tip, bore = pitch - 40, pitch + 32, 112.0
    half = math.pi / (2 * teeth) + math.tan(alpha) - alpha

    def polar(r, angle):
        return (r * math.cos(angle) - shift, r * math.sin(angle))

    def flank(r):
        pressure = math.acos(min(1.0, base / r))
        return polar(r, half - math.tan(pressure) + pressure)

    upper = [polar(root, half)] + [flank(base + (tip - base) * k / 20) for k in range(21)]
    sector = math.pi / teeth
    land = [polar(root, sector + (half - sector) * k / 5) for k in range(6)]
    side = [polar(bore, sector * (1 - k / 5)) for k in range(6)]
    above = side[::-1] + land + upper
    cell.shape(above + [(x, -y) for x, y in reversed(above)])
    cell.label("tip", (tip - shift, 0), (18, 4), "start")
    cell.label("last-flank", flank(pitch), (14, -26), "start")
    cell.label("first-flank", (flank(pitch)[0], -flank(pitch)[1]), (14, 34), "start")
    cell.label("root", polar(root, 0.85 * sector), (-14, -38))
    cell.label("bore", (bore - shift, 0), (-18, 4), "end")
    cell.label("last", polar(0.5 * (bore + root), sector), (-36, -24), "end")
    cell.label("first", polar(0.5 * (bore + root), -sector), (-36, 30), "end")
    cell.label("solid: z-, z+ too", (0, -84), (0, 0))
    return cell


def main():
    cells = [box(), round_body(1, "cylinder", 0), round_body(2, "hollow-cylinder", 20), ball(3), rectangle(4)]
    cells += meridians() + [patch(8), disc(9), gear_tooth(10)]
    rows = -(-len(cells) // COLUMNS)
    width, height = COLUMNS * CELL[0], rows * CELL[1]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif">\n<title>Named faces of the shapes</title>\n'
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>\n'
    )
    body = "\n".join(part for cell in cells for part in cell.parts)
    output = sys.argv[1] if len(sys.argv) > 1 else "docs/figures/faces.svg"
    with open(output, "w", encoding="utf-8") as file:
        file.write(f"{head}{body}\n</svg>\n")


if __name__ == "__main__":
    main()
