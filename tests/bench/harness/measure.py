"""Runs the cases, here and in the peer in turn, and keeps what was measured."""
import copy
import math
import os
import statistics
import sys

from .programs import Job

# name: (what, unit, digits, whether more is better)
FIGURES = {
    "wall": ("time", "s", 3, False),
    "cpu": ("processor time", "s", 3, False),
    "peak": ("peak memory", "MB", 1, False),
    "rate": ("text read", "MB/s of one processor", 0, True),
    "check_ms": ("`check` alone", "ms", 1, False),
    "speed": ("samples by time", "million/s", 3, True),
    "cpu_speed": ("samples by processor time", "million/s", 3, True),
    "mse": ("mean squared error", "", 9, False),
    "efficiency": ("efficiency by time", "1/(MSE s)", 1, True),
    "cpu_efficiency": ("efficiency by processor time", "1/(MSE s)", 1, True),
    "dark_mse": ("mean squared error without lamps' pixels", "", 9, False),
    "dark_efficiency": ("efficiency without lamps' pixels, by processor time", "1/(MSE s)", 1, True),
    "equal_error": ("processor time to equal error", "s", 3, False),
}


def say(text):
    print(text, file=sys.stderr, flush=True)


def ratio(figure, ours, theirs):
    """Above 1 where scnrender is ahead."""
    more = FIGURES[figure][3]
    up, down = (ours, theirs) if more else (theirs, ours)
    return up / down if down else math.inf


def compare(pairs):
    """[(figures of ours, of theirs or None)] of runs in turn -> {figure: {ours, theirs, ratio, low,
    high}}: medians, and the spread of the ratios of pairs."""
    table = {}
    for figure in FIGURES:
        values = [ours[figure] for ours, _ in pairs if figure in ours]
        if not values:
            continue
        row = {"ours": statistics.median(values)}
        both = [(ours[figure], theirs[figure]) for ours, theirs in pairs
                if theirs and figure in ours and figure in theirs]
        if both:
            ratios = [ratio(figure, *pair) for pair in both]
            row.update(theirs=statistics.median(theirs for _, theirs in both),
                       ratio=statistics.median(ratios), low=min(ratios), high=max(ratios))
        table[figure] = row
    return table


class Runs:
    """The runs of a case, here and there in turn."""

    def __init__(self, job, numbers, peers, extra):
        self.job, self.numbers, self.peers = job, numbers, peers
        self.pairs, self.extra = [], extra

    def alternate(self, ours, theirs):
        for number in self.numbers:
            self.pairs.append((ours(number), theirs(number) if self.peers else None))

    def same_scene(self, ours, theirs):
        """Keeps the mean luminance of two linear pictures."""
        errors = self.job.errors([ours], [theirs])[0]
        self.extra["means"] = [errors["reference"], errors["mean"]]


def check(runs):
    job = runs.job
    megabytes = os.path.getsize(job.scene) / 1e6

    def ours(_):
        cost = job.check().figures()
        if job.case.scene == "flat":
            cost["rate"] = megabytes / cost["cpu"]
        return cost
    ours(0)  # reads the file into memory
    runs.alternate(ours, lambda _: job.povray().figures())


def picture(runs):
    job = runs.job

    def ours(_):
        cost = job.ours(job.file("ours.png")).figures()
        if job.case.name == "start":
            # The least of ten: waiting behind other work is no part of it.
            cost["check_ms"] = 1e3 * min(job.check().wall for _ in range(10))
        return cost
    ours(0)
    runs.alternate(ours, lambda _: job.povray(job.file("theirs.png")).figures())
    if runs.peers:
        job.ours(job.file("ours.exr"))
        job.povray(job.file("theirs.exr"), linear=True)
        runs.same_scene(job.file("ours.exr"), job.file("theirs.exr"))


def first(runs):
    job, whole = runs.job, []

    def theirs(_):
        call, process = job.cycles(job.file("theirs.exr"))
        whole.append(process.wall)
        return call.figures()
    runs.alternate(lambda _: job.ours(job.file("ours.png")).figures(), theirs)
    if runs.peers:
        runs.extra["notes"] = [f"Blender's whole process took {statistics.median(whole):.1f} s."]
        # The same trees must stand there: fewer of them, seen by more rays.
        few = copy.deepcopy(job.size)
        few.params["rows"], few.samples, few.width, few.height = 100, 16, 320, 180
        other = Job(job.case, few, job.program, os.path.join(job.work, "few"), job.threads)
        other.ours(other.file("ours.exr"))
        other.cycles(other.file("theirs.exr"))
        runs.same_scene(other.file("ours.exr"), other.file("theirs.exr"))


def noise(runs):
    job, size = runs.job, runs.job.size
    million = 1e-6 * size.width * size.height * size.samples
    references = {}
    for who in ["scnrender"] + (["cycles"] if runs.peers else []):
        say(f"{job.case.name}: reference of {who}")
        references[who] = job.references(who)

    def one(who, run):
        output = job.file(f"{who}_{run}.exr")
        cost = job.render(who, output, seed=100 + run).figures()
        error = job.errors(references[who], [output])[0]
        cost.update(speed=million / cost["wall"], cpu_speed=million / cost["cpu"], mse=error["mse"],
                    efficiency=1 / (error["mse"] * cost["wall"]), dark_mse=error["dark_mse"],
                    cpu_efficiency=1 / (error["mse"] * cost["cpu"]),
                    dark_efficiency=1 / (error["dark_mse"] * cost["cpu"]))
        if who == "cycles":
            cost["equal_error"] = cost["cpu"]
        return cost

    equal = any(aim.figure == "equal_error" for aim in job.case.aims) and runs.peers
    for number in runs.numbers:
        here, there = one("scnrender", number), one("cycles", number) if runs.peers else None
        if equal:
            if "equal_samples" not in runs.extra:
                runs.extra["equal_samples"] = samples_for(job, references["scnrender"], there["mse"])
            samples = runs.extra["equal_samples"]
            here["equal_error"] = job.ours(job.file("equal.exr"), samples, 400 + number).cpu
            runs.extra["notes"] = [f"Equal error: {samples} samples here, {size.samples} there."]
        runs.pairs.append((here, there))
    if runs.peers:
        runs.extra["means"] = [job.errors(references[who], references[who])[-1]["mean"]
                               for who in references]


def samples_for(job, reference, wanted):
    """As many samples as bring an error: it falls with a power of their number, which is interpolated
    between powers of two."""
    error = job.file("equal.exr")

    def mse(samples):
        job.ours(error, samples, 300)
        return job.errors(reference, [error])[0]["mse"]
    samples = 1
    before = after = mse(1)
    while after > wanted and samples < 16 * job.size.samples:
        before, samples = after, 2 * samples
        after = mse(samples)
    if samples == 1 or before <= after:
        return samples
    return math.ceil(samples / 2 * 2 ** (math.log(before / wanted) / math.log(before / after)))


KINDS = {"check": check, "picture": picture, "first": first, "noise": noise}


def run_case(case, given, program, work, kept):
    """`kept`, the result of earlier runs, is added to."""
    size = case.quick if given.quick else case.full
    job = Job(case, size, program, work, given.threads)
    say(f"{case.name}: {case.what}")
    pairs = kept["pairs"] if kept else []
    extra = {"equal_samples": kept["equal_samples"]} if kept and "equal_samples" in kept else {}
    runs = Runs(job, range(len(pairs), len(pairs) + given.runs), not given.quick, extra)
    KINDS[case.kind](runs)
    pairs = pairs + runs.pairs
    result = {"case": case.name, "figures": compare(pairs), "runs": len(pairs), "pairs": pairs,
              "threads": given.threads, "load": os.getloadavg()[1], **runs.extra}
    means = result.get("means")
    if means and abs(means[1] / means[0] - 1) > 0.02:
        result.setdefault("notes", []).append("**The means differ: not the same scene.**")
    return result
