"""Runs scnrender, POV-Ray and Blender, and tells what each run cost."""
import hashlib
import json
import os
import shutil
import subprocess
import time
from dataclasses import dataclass

from . import flat
from .cases import ROOT


# A million of things take more steps than a scene that nobody knows may.
LIMITS = ["--limit", "steps=1000000000", "--limit", "memory=17179869184"]
TIME = shutil.which("time")


class BenchError(Exception):
    """A program that failed, with what it said."""


@dataclass
class Cost:
    """Seconds, processor seconds and the largest resident memory in MB, of a whole process."""
    wall: float
    cpu: float
    peak: float
    output: str = ""

    def figures(self):
        return {"wall": self.wall, "cpu": self.cpu, "peak": self.peak}


def timed(command, log, env=None):
    """Runs a command; its output goes to the file `log`. A process that Python starts counts Python's own
    20 MB as its peak, but one that the command `time` starts does not."""
    memory = log + ".memory"
    measured = [TIME, "-q", "-f", "%M", "-o", memory, *command] if TIME else command
    with open(log, "w+b") as file:
        start = time.monotonic()
        process = subprocess.Popen(measured, stdin=subprocess.DEVNULL, stdout=file,
                                   stderr=subprocess.STDOUT, env=env)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        file.seek(0)
        output = file.read().decode(errors="replace")
    if process.returncode != 0:
        raise BenchError(f"{' '.join(command[:6])} … failed ({process.returncode}):\n{output[-2000:]}")
    peak = usage.ru_maxrss
    if TIME:
        with open(memory, encoding="ascii") as file:
            peak = int(file.read())
    return Cost(wall, usage.ru_utime + usage.ru_stime, peak / 1024, output)


def scnrender_path():
    program = os.environ.get("SCNRENDER")
    if not program:
        subprocess.run([os.path.join(ROOT, "tools/build"), "release"], check=True,
                       stdout=subprocess.DEVNULL)
        program = os.path.join(ROOT, "build/release/bin/scnrender")
    return program


def install_peers():
    subprocess.run([os.path.join(ROOT, "compare/setup")], check=True)
    for program in ("povray", "blender"):
        if not shutil.which(program):
            raise BenchError(f"{program} isn't there")


class Job:
    """A case at one size."""

    def __init__(self, case, size, program, work, threads):
        self.case, self.size, self.program, self.threads = case, size, program, threads
        self.work = os.path.join(work, case.name)
        os.makedirs(self.work, exist_ok=True)
        self.partner = None  # the peer's file
        if case.scene == "flat":
            self.scene, self.partner = flat.write(program, work, size.params["count"])
            self.params = []
        else:
            self.scene = case.path()
            self.params = self.settings(size.params)

    @staticmethod
    def settings(params):
        return [word for name, value in params.items() for word in ("--set", f"{name}={value}")]

    def file(self, name):
        return os.path.join(self.work, name)

    def log(self):
        return self.file("log.txt")

    # scnrender

    def check(self):
        return timed([self.program, "check", self.scene, *self.params, *LIMITS], self.log())

    def ours(self, output, samples=None, seed=0):
        size = self.size
        return timed([self.program, self.scene, *self.params, *LIMITS, "--quiet",
                      "--threads", str(self.threads), "--size", f"{size.width}x{size.height}",
                      "--samples", str(samples or size.samples), "--seed", str(seed), "-o", output],
                     self.log())

    # POV-Ray

    def exported(self, target, extension):
        if not self.partner:
            self.partner = self.case.beside(extension) if target == "povray" else None
        if not self.partner:
            self.partner = self.file("exported" + extension)
            params = {**self.size.params, **self.case.peer_params}
            subprocess.run([self.program, "export", "--to", target, self.scene, "--quiet", *LIMITS,
                            "-o", self.partner, *self.settings(params)], check=True)
        return self.partner

    def povray(self, output=None, linear=False):
        """Without an output, one pixel: what is left is reading the scene."""
        scene = self.exported("povray", ".pov")
        width, height = (self.size.width, self.size.height) if output else (1, 1)
        return timed(["povray", f"+I{scene}", f"+O{output or '/dev/null'}", f"+W{width}", f"+H{height}",
                      "+FE" if linear else "+FN", "-A", "-D", "-P", "-V", "-GA", f"+WT{self.threads}"],
                     self.log(), {**os.environ, "HOME": self.work})

    # Cycles

    def cycles(self, output, samples=None, seed=0):
        """The cost of the render call, with the whole process's memory, and the process's seconds."""
        dump, params = None, dict(self.size.params)
        if self.case.beside(".py"):
            dump = self.file("dump.json")
            small = self.settings({**params, **({"rows": 1} if "rows" in params else {})})
            with open(dump, "w", encoding="utf-8") as file:
                subprocess.run([self.program, self.scene, "--dump", "scene", "--quiet", *small, *LIMITS],
                               check=True, stdout=file)
        job = {"scene": self.exported("blender", ".export.py"), "hook": self.case.beside(".py"),
               "dump": dump, "params": params, "output": output, "seed": seed, "threads": self.threads,
               "samples": samples or self.size.samples, "size": [self.size.width, self.size.height]}
        whole = timed(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P",
                       os.path.join(ROOT, "tests/bench/cycles.py"), "--", json.dumps(job)], self.log())
        for line in whole.output.splitlines():
            if line.startswith("{"):
                call = json.loads(line)
                return Cost(call["wall"], call["cpu"], whole.peak), whole
        raise BenchError(f"Blender rendered nothing:\n{whole.output[-2000:]}")

    def render(self, who, output, samples=None, seed=0):
        if who == "scnrender":
            return self.ours(output, samples, seed)
        return self.cycles(output, samples, seed)[0]

    # References

    def references(self, who):
        """The pictures of the long reference of one renderer, rendered where they aren't kept yet. They
        are kept by the scene's text and the settings: the mean of a scene's picture never changes."""
        size = self.size
        with open(self.scene, "rb") as file:
            key = hashlib.sha256(file.read())
        hook = self.case.beside(".py")
        if who != "scnrender" and hook:
            with open(hook, "rb") as file:
                key.update(file.read())
        key.update(repr((size.width, size.height, size.params, size.reference)).encode())
        files = []
        for seed in range(size.seeds):
            file = self.file(f"reference_{who}_{key.hexdigest()[:12]}_{seed}.exr")
            if not os.path.exists(file):
                part = file[:-4] + ".part.exr"
                self.render(who, part, size.reference, 1000 + seed)
                os.replace(part, file)
            files.append(file)
        return files

    def errors(self, references, pictures):
        """[{mse, dark_mse, mean, reference}] of each picture, and of the mean of all."""
        done = subprocess.run([os.path.join(os.path.dirname(self.program), "picture_error"), *references,
                               "--", *pictures], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BenchError(done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]
