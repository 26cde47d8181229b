"""How cost grows: with pixels, samples, triangles and threads. Measures, fits, and draws SVG."""
import json
import math
import os
import statistics

from .cases import FOLDER, ROOT
from .measure import say
from .programs import LIMITS, timed

PICTURES = os.path.join(ROOT, "docs/performance")
CORNELL = os.path.join(ROOT, "examples/cornell_box.scn")


def cost(program, work, scene, size, samples, threads=1, params=()):
    """Of one run, to a PNG: loading what writes OpenEXR would hide the small ones."""
    words = [word for param in params for word in ("--set", param)]
    return timed([program, scene, *words, *LIMITS, "--quiet", "--threads", str(threads), "--size",
                  f"{size}x{size}", "--samples", str(samples), "-o", os.path.join(work, "plot.png")],
                 os.path.join(work, "plot.log"))


def least(runs, measure):
    """The least of several runs: other work on the machine only adds."""
    return min(measure() for _ in range(runs))


def line(xs, ys):
    """Slope and intercept of least squares, and R^2."""
    mx, my = statistics.mean(xs), statistics.mean(ys)
    sxx = sum((x - mx) ** 2 for x in xs)
    slope = sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sxx
    rest = sum((y - my - slope * (x - mx)) ** 2 for x, y in zip(xs, ys))
    total = sum((y - my) ** 2 for y in ys)
    return slope, my - slope * mx, 1 - rest / total if total else 1.0


def exponent(points):
    """Of the power of x with which y grows."""
    return line([math.log(x) for x, _ in points], [math.log(y) for _, y in points])[0]


# --- What is measured ------------------------------------------------------------------------------


def pixels(program, work, runs):
    start = least(runs, lambda: cost(program, work, CORNELL, 8, 1).cpu)
    points = [(size * size, least(runs, lambda: cost(program, work, CORNELL, size, 16).cpu) - start)
              for size in (64, 91, 128, 181, 256, 362)]
    return {"points": points, "exponent": exponent(points),
            "title": "Cornell box, 16 samples a pixel, one thread", "x": "pixels",
            "y": "processor time, s, without starting", "log": [True, True]}


def samples(program, work, runs):
    start = least(runs, lambda: cost(program, work, CORNELL, 8, 1).cpu)
    points = [(n, least(runs, lambda: cost(program, work, CORNELL, 128, n).cpu) - start)
              for n in (4, 8, 16, 32, 64, 128)]
    return {"points": points, "exponent": exponent(points),
            "title": "Cornell box, 128 × 128 pixels, one thread", "x": "samples a pixel",
            "y": "processor time, s, without starting", "log": [True, True]}


def triangles(program, work, runs):
    """Seconds for a million samples, from the difference of two numbers of samples: reading the scene
    and building the hierarchy are in both."""
    scene = os.path.join(FOLDER, "hill.scn")
    points = []
    for side in (8, 23, 64, 181, 512, 1024):
        few, many = (least(runs, lambda: cost(program, work, scene, 256, n, 1, [f"side={side}"]).cpu)
                     for n in (1, 13))
        points.append((2 * side * side, (many - few) / (12 * 256 * 256 * 1e-6)))
    slope, start, fit = line([math.log2(x) for x, _ in points], [y for _, y in points])
    return {"points": points, "slope": slope, "start": start, "r2": fit, "exponent": exponent(points),
            "title": "A hill of triangles, depth 4, one thread", "x": "triangles",
            "y": "processor time of a million samples, s", "log": [True, False]}


def threads(program, work, runs):
    """Wall time, in turn: the ratio of the least of each."""
    most = os.cpu_count()
    numbers = sorted({1, 2, most} & set(range(1, most + 1)))
    walls = {n: [] for n in numbers}
    for _ in range(max(5, runs)):
        for n in numbers:
            walls[n].append(cost(program, work, CORNELL, 256, 32, n).wall)
    points = [(n, min(walls[n])) for n in numbers]
    return {"points": points, "speedup": points[0][1] / points[-1][1],
            "title": "Cornell box, 256 × 256 pixels, 32 samples", "x": "threads", "y": "time, s",
            "log": [False, False]}


PLOTS = {"pixels": pixels, "samples": samples, "triangles": triangles, "threads": threads}


# --- Drawing ---------------------------------------------------------------------------------------

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 480, 320, 70, 36, 36, 52


def ticks(low, high, log):
    """Round numbers that cover an interval."""
    if log:
        step = max(1, math.ceil((math.log10(high) - math.log10(low)) / 6))
        return [10.0 ** k for k in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1,
                                         step)]
    step = 10 ** math.floor(math.log10(max(high - low, 1e-9) / 2))
    step *= next(k for k in (1, 2, 5, 10) if (high - low) / (step * k) <= 6)
    return [step * k for k in range(math.floor(low / step), math.ceil(high / step) + 1)]


class Axis:
    def __init__(self, values, log, start, end):
        low, high = (min(values), max(values)) if log else (0, max(values))
        self.log, self.start, self.end = log, start, end
        self.ticks = ticks(low, high, log)
        self.low, self.high = self.ticks[0], self.ticks[-1]

    def at(self, value):
        low, high, x = (math.log10(v) if self.log else v for v in (self.low, self.high, value))
        return self.start + (self.end - self.start) * (x - low) / (high - low)


def text(x, y, words, anchor="middle", turn=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{turn}>{words}</text>'


def svg(plot):
    xs, ys = Axis([x for x, _ in plot["points"]], plot["log"][0], LEFT, WIDTH - RIGHT), \
        Axis([y for _, y in plot["points"]], plot["log"][1], HEIGHT - BOTTOM, TOP)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12" fill="#222">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
           text(WIDTH / 2, 20, plot["title"])]
    for value in xs.ticks:
        x = xs.at(value)
        out += [f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>',
                text(x, HEIGHT - BOTTOM + 16, f"{value:,.10g}")]
    for value in ys.ticks:
        y = ys.at(value)
        out += [f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>',
                text(LEFT - 6, y + 4, f"{value:.4g}", "end")]
    middle = (TOP + HEIGHT - BOTTOM) / 2
    out += [text(WIDTH / 2, HEIGHT - 14, f"{plot['x']}{fitted(plot)}"),
            text(16, middle, plot["y"], turn=f' transform="rotate(-90 16 {middle:.1f})"')]
    places = [(xs.at(x), ys.at(y)) for x, y in plot["points"]]
    out.append('<path d="M' + "L".join(f"{x:.1f} {y:.1f}" for x, y in places) +
               '" fill="none" stroke="#3465a4" stroke-width="2"/>')
    out += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="#3465a4"/>' for x, y in places]
    return "\n".join(out) + "\n</svg>\n"


def fitted(plot):
    if "slope" in plot:
        return f" n: {plot['start']:.2f} + {plot['slope']:.3f} log2 n, R² = {plot['r2']:.3f}"
    if "speedup" in plot:
        return f": {plot['points'][-1][0]} are {plot['speedup']:.2f} times as fast as one"
    return f": time grows with the power {plot['exponent']:.3f}"


def run(program, work, runs, names):
    os.makedirs(PICTURES, exist_ok=True)
    for name, measure in PLOTS.items():
        if names and name not in names:
            continue
        plot = measure(program, work, runs)
        with open(os.path.join(work, f"plot_{name}.json"), "w", encoding="utf-8") as file:
            json.dump(plot, file, indent=1)
        path = os.path.join(PICTURES, f"{name}.svg")
        with open(path, "w", encoding="utf-8") as file:
            file.write(svg(plot))
        say(f"{os.path.relpath(path, ROOT)}: {plot['x']}{fitted(plot)}")
    return 0
