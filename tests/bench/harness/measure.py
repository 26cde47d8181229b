"""Runs the cases, here and in the peer in turn, and keeps what was measured."""
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
    "speed": ("samples", "million/s", 3, True),
    "cpu_speed": ("samples", "million/s of a processor", 3, True),
    "mse": ("mean squared error", "", 9, False),
    "efficiency": ("efficiency", "1/(MSE s)", 1, True),
    "cpu_efficiency": ("efficiency by processor time", "1/(MSE s)", 1, True),
    "dark_mse": ("MSE without lamps' pixels", "", 9, False),
    "dark_efficiency": ("efficiency without lamps' pixels", "1/(MSE s)", 1, True),
    "equal_error": ("time to equal error", "s", 3, False),
    "equal_error_cpu": ("processor time to equal error", "s", 3, False),
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
        if figure not in pairs[0][0]:
            continue
        row = {"ours": statistics.median(ours[figure] for ours, _ in pairs)}
        both = [(ours[figure], theirs[figure]) for ours, theirs in pairs if theirs and figure in theirs]
        if both:
            ratios = [ratio(figure, *pair) for pair in both]
            row.update(theirs=statistics.median(theirs for _, theirs in both),
                       ratio=statistics.median(ratios), low=min(ratios), high=max(ratios))
        table[figure] = row
    return table


def alternate(runs, ours, theirs):
    """Figures of runs in turn; the first ones of each side warm the disk and aren't counted."""
    pairs = []
    for run in range(runs):
        pairs.append((ours(run), theirs(run) if theirs else None))
    return pairs


def check(job, runs, peers):
    megabytes = os.path.getsize(job.scene) / 1e6

    def ours(_):
        cost = job.check().figures()
        if job.case.scene == "flat":
            cost["rate"] = megabytes / cost["cpu"]
        return cost

    def theirs(_):
        return job.povray().figures()
    ours(0)
    return {"figures": compare(alternate(runs, ours, theirs if peers else None))}


def picture(job, runs, peers):
    def ours(_):
        cost = job.ours(job.file("ours.png")).figures()
        if job.case.name == "start":
            cost["check_ms"] = 1e3 * job.check().wall
        return cost

    def theirs(_):
        return job.povray(job.file("theirs.png")).figures()
    ours(0)
    result = {"figures": compare(alternate(runs, ours, theirs if peers else None))}
    if peers:
        job.ours(job.file("ours.exr"))
        job.povray(job.file("theirs.exr"), linear=True)
        errors = job.errors([job.file("ours.exr")], [job.file("theirs.exr")])[0]
        result["means"] = [errors["reference"], errors["mean"]]
    return result


def first(job, runs, peers):
    def ours(_):
        return job.ours(job.file("ours.png")).figures()

    whole = []

    def theirs(_):
        call, process = job.cycles(job.file("theirs.exr"))
        whole.append(process.wall)
        return call.figures()
    result = {"figures": compare(alternate(runs, ours, theirs if peers else None))}
    if peers:
        result["notes"] = [f"Blender's whole process took {statistics.median(whole):.1f} s."]
        # The same trees must stand there: fewer of them, seen by more rays.
        job.size.samples = 64
        job.ours(job.file("ours.exr"))
        job.cycles(job.file("theirs.exr"))
        errors = job.errors([job.file("ours.exr")], [job.file("theirs.exr")])[0]
        result["means"] = [errors["reference"], errors["mean"]]
    return result


def noise(job, runs, peers):
    size, sides = job.size, ["scnrender"] + (["cycles"] if peers else [])
    million = 1e-6 * size.width * size.height * size.samples
    references = {}
    for who in sides:
        say(f"{job.case.name}: reference of {who}")
        references[who] = job.references(who)

    def one(who, run):
        output = job.file(f"{who}_{run}.exr")
        cost = job.render(who, output, seed=100 + run).figures()
        error = job.errors(references[who], [output])[0]
        cost.update(speed=million / cost["wall"], cpu_speed=million / cost["cpu"], mse=error["mse"],
                    efficiency=1 / (error["mse"] * cost["wall"]), dark_mse=error["dark_mse"],
                    cpu_efficiency=1 / (error["mse"] * cost["cpu"]),
                    dark_efficiency=1 / (error["dark_mse"] * cost["wall"]))
        return cost
    pairs = alternate(runs, lambda run: one("scnrender", run),
                      (lambda run: one("cycles", run)) if peers else None)
    result = {"figures": compare(pairs)}
    if peers:
        ours, theirs = (job.errors(references[who], [job.file(f"{who}_0.exr")])[0]["reference"]
                        for who in sides)
        result["means"] = [ours, theirs]
        if any(aim.figure == "equal_error" for aim in job.case.aims):
            equal_error(job, runs, references["scnrender"], result)
    return result


def equal_error(job, runs, reference, result):
    """As many samples here as bring the error that the peer has, then both in turn."""
    wanted = result["figures"]["mse"]["theirs"]
    error = job.file("equal.exr")

    def mse(samples, seed):
        job.ours(error, samples, seed)
        return job.errors(reference, [error])[0]["mse"]
    # The error falls with a power of the samples: interpolated between powers of two around it.
    samples = 1
    before = after = mse(1, 300)
    while after > wanted and samples < 64 * job.size.samples:
        before, samples = after, 2 * samples
        after = mse(samples, 300)
    if samples > 1 and before > after:
        samples = math.ceil(samples / 2 * 2 ** (math.log(before / wanted) / math.log(before / after)))

    def ours(run):
        cost = job.ours(job.file("equal.exr"), samples, 400 + run)
        return {"equal_error": cost.wall, "equal_error_cpu": cost.cpu}

    def theirs(run):
        cost = job.render("cycles", job.file("equal_theirs.exr"), seed=400 + run)
        return {"equal_error": cost.wall, "equal_error_cpu": cost.cpu}
    result["figures"].update(compare(alternate(runs, ours, theirs)))
    result.setdefault("notes", []).append(
        f"Equal error: {samples} samples here, {job.size.samples} there.")


KINDS = {"check": check, "picture": picture, "first": first, "noise": noise}


def run_case(case, given, program, work):
    size = case.quick if given.quick else case.full
    job = Job(case, size, program, work, given.threads)
    say(f"{case.name}: {case.what}")
    result = KINDS[case.kind](job, given.runs, not given.quick)
    result.update(case=case.name, peer=None if given.quick else case.peer, runs=given.runs,
                  threads=given.threads, load=os.getloadavg()[0])
    means = result.get("means")
    if means and not abs(means[1] / means[0] - 1) < 0.02:
        result.setdefault("notes", []).append("The means differ: not the same scene.")
    return result


