"""Runs the three renderers and scn_metrics."""
import json
import os
import re
import shutil
import subprocess
import time

PROGRAMS = {"scnrender": "scnrender", "povray": "POV-Ray", "cycles": "Cycles"}


class RunError(Exception):
    """A program that failed, with what it said."""


class Tools:
    """Where the programs lie."""

    def __init__(self, root):
        self.scnrender = os.environ.get("SCNRENDER")
        if not self.scnrender:
            folder = subprocess.run([os.path.join(root, "tools/build"), "release"], check=True,
                                    capture_output=True, text=True).stdout.strip()
            self.scnrender = os.path.join(root, folder, "bin/scnrender")
        self.metrics = os.path.join(os.path.dirname(self.scnrender), "scn_metrics")
        subprocess.run([os.path.join(root, "compare/setup")], check=True)
        for program in ("povray", "blender", "oiiotool", "idiff"):
            if not shutil.which(program):
                raise RunError(f"{program} isn't there")

    def versions(self):
        blender = self.first_line(["blender", "--version"])
        return {"scnrender": self.first_line([self.scnrender, "--version"]),
                "povray": self.first_line(["povray", "--version"], "POV-Ray"),
                "cycles": f"Cycles of {blender}"}

    @staticmethod
    def first_line(command, beginning=""):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        for line in (done.stdout + done.stderr).splitlines():
            if line.strip().startswith(beginning):
                return line.strip()
        return command[0]


def run(command, log=None, **options):
    """Its standard output; the log keeps everything."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, errors="replace",
                          **options)
    if log:
        with open(log, "w", encoding="utf-8") as file:
            file.write(done.stdout + done.stderr)
    if done.returncode != 0:
        said = (done.stderr or done.stdout)[-2000:]
        raise RunError(f"{' '.join(command[:6])} … failed ({done.returncode}):\n{said}")
    return done.stdout


class Pictures:
    """What one renderer made: files, and the seconds that each took."""

    def __init__(self):
        self.files, self.seconds = [], []
        self.samples = 1

    def mean_seconds(self):
        return sum(self.seconds) / len(self.seconds) if self.seconds else 0


class Job:
    """One scene in all renderers."""

    def __init__(self, tools, scene, work, seeds, scale):
        self.tools, self.scene, self.work, self.seeds = tools, scene, work, seeds
        os.makedirs(work, exist_ok=True)
        self.dump = json.loads(run([tools.scnrender, scene.path, "--dump", "scene", "--quiet"]))
        film, render = self.setting("film"), self.setting("render")
        self.width = max(8, round(film["width"] * scale))
        self.height = max(8, round(film["height"] * scale))
        self.size = f"{self.width}x{self.height}"
        # One ray through each pixel's centre, and no integrator that draws lots.
        self.noiseless = film["filter"] == "center" and render["samples"] == 1
        self.samples = scene.samples["scnrender"] or render["samples"]
        self.cycles_samples = scene.samples["cycles"] or (64 if self.noiseless else self.samples)

    def setting(self, kind):
        defaults = {"film": {"width": 960, "height": 540, "filter": "blackman_harris"},
                    "render": {"samples": 64}}
        for setting in self.dump["settings"]:
            if setting["kind"] == kind:
                return setting["fields"]
        return defaults[kind]

    def file(self, name):
        return os.path.join(self.work, name)

    def export(self, target, extension):
        file = self.file(f"{self.scene.name}.{extension}")
        run([self.tools.scnrender, "export", "--to", target, self.scene.path, "--quiet", "-o", file])
        return file

    def notes(self, target):
        """What has no exact partner: [{"place": "file:line", "texts": […]}]."""
        done = subprocess.run([self.tools.scnrender, "check", "--for", target, self.scene.path,
                               "--diagnostics=json"], capture_output=True, text=True, check=False)
        notes = []
        for line in (done.stderr + done.stdout).splitlines():
            if line.startswith("{"):
                diagnostic = json.loads(line)
                if diagnostic.get("code") == "N0980":
                    notes.append(read_note(diagnostic))
        return notes

    def scnrender(self):
        made = Pictures()
        made.samples = self.samples
        for seed in range(1, (1 if self.noiseless else self.seeds) + 1):
            file = self.file(f"scnrender_{seed}.exr")
            start = time.monotonic()
            run([self.tools.scnrender, self.scene.path, "--quiet", "--size", self.size, "--samples",
                 str(self.samples), "--seed", str(seed), "-o", file])
            made.seconds.append(time.monotonic() - start)
            made.files.append(file)
        return made

    def object_ids(self):
        """The object-id AOV as a picture of whole numbers, and the names of its regions."""
        layers, ids, names = self.file("ids.exr"), self.file("ids.tif"), self.file("regions.txt")
        run([self.tools.scnrender, self.scene.path, "--quiet", "--size", self.size, "--samples", "1",
             "--aov", "object_id", "-o", layers])
        run(["oiiotool", layers, "--ch", "object_id.id", "-d", "uint32", "-o", ids])
        with open(names, "w", encoding="utf-8") as file:
            file.write("0\t(background)\n")
            for shape in self.dump["shapes"]:
                file.write(f"{shape['id'] + 1}\t{region_name(shape)}\n")
        return ids, names

    def povray(self):
        made = Pictures()
        source, file = self.export("povray", "pov"), self.file("povray.exr")
        start = time.monotonic()
        run(["povray", f"+I{source}", f"+O{file}", f"+W{self.width}", f"+H{self.height}", "+FE", "-A",
             "-D", "-P", "-V"], self.file("povray.log"), env={**os.environ, "HOME": self.work})
        made.seconds.append(time.monotonic() - start)
        made.files.append(file)
        return made

    def cycles(self):
        made = Pictures()
        made.samples = self.cycles_samples
        seeds = range(1, self.seeds + 1)
        pattern = self.file("cycles_{seed}.exr")
        out = run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                   self.export("blender", "py"), "--", "--output", pattern, "--samples",
                   str(self.cycles_samples), "--size", self.size, "--seeds",
                   ",".join(map(str, seeds))], self.file("cycles.log"))
        made.seconds = [float(s) for s in re.findall(r"^seed \d+: ([\d.]+) seconds", out, re.M)]
        made.files = [pattern.replace("{seed}", str(seed)) for seed in seeds]
        if len(made.seconds) != len(made.files):
            raise RunError(f"Blender made {len(made.seconds)} of {len(made.files)} pictures")
        return made

    def compare(self, partner, ids, names, ours, theirs):
        prefix = self.file(partner)
        figures = json.loads(run([self.tools.metrics, ids, names, prefix, *ours.files, "--",
                                  *theirs.files]))
        figures["oiio"] = idiff(prefix + "_ours.exr", prefix + "_theirs.exr")
        return figures


def region_name(shape):
    if shape["name"]:
        return shape["name"].replace("\t", " ")
    place = (shape["place"] or "").rsplit(":", 1)[0]
    return f"{shape['kind']} {os.path.basename(place)}".strip()


def read_note(diagnostic):
    span = diagnostic.get("span") or diagnostic
    file, line = span.get("file"), span.get("line")
    texts = [re.sub(r"^for [^:]*: ", "", diagnostic["message"])]
    texts += [note if isinstance(note, str) else note.get("message", "")
              for note in diagnostic.get("notes", [])]
    return {"place": f"{os.path.basename(file)}:{line}" if file else "", "texts": texts}


def idiff(a, b):
    """Errors of one picture against another, by OpenImageIO."""
    done = subprocess.run(["idiff", "-v", "-a", a, b], capture_output=True, text=True, check=False)
    names = {"Mean error": "mean", "RMS error": "rms", "Peak SNR": "psnr", "Max error": "max"}
    out = {}
    for name, key in names.items():
        match = re.search(rf"{name}\s*=\s*([-+.\deE]+|inf|nan)", done.stdout)
        if match:
            value = float(match[1])
            out[key] = value if abs(value) < 1e30 else None
    return out
