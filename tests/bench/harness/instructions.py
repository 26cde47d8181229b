"""Instructions that fixed small cases take under callgrind: nearly the same from run to run, so that a
change of one per cent shows, whatever else the machine does."""
import json
import os
import re
import shutil
import subprocess
import tempfile

from . import flat
from .cases import FOLDER, ROOT
from .programs import BenchError

BASELINE = os.path.join(ROOT, "tests/bench/instructions.json")
MOST = 1.03  # what a count may grow to

CORNELL = os.path.join(ROOT, "examples/cornell_box.scn")


def cases(program, work):
    """name: what stands behind `scnrender`. Only PNG, since loading OpenImageIO would hide the rest."""
    scn, _ = flat.write(program, work, 60)

    def scene(name):
        return os.path.join(FOLDER, name + ".scn")

    def picture(file, width, height, samples, *rest):
        return [file, "--quiet", "--threads", "1", "--size", f"{width}x{height}", "--samples",
                str(samples), "-o", os.path.join(work, "picture.png"), *rest]
    return {
        "check-loop": ["check", scene("front_loop"), "--set", "count=150"],
        "check-flat": ["check", scn],
        "flat-picture": picture(scn, 64, 64, 1),
        "cornell": picture(CORNELL, 32, 32, 16),
        "materials": picture(scene("materials"), 48, 27, 8, "--set", "picture=false"),
        "many-lights": picture(scene("many_lights"), 32, 18, 8, "--set", "lamps=200"),
        "instances": picture(scene("instances"), 48, 27, 4, "--set", "rows=30", "--set",
                             "leaves=1000"),
        "caustic": picture(scene("caustic"), 48, 36, 8),
        "start": [scene("start"), "--quiet", "--threads", "1", "-o",
                  os.path.join(work, "picture.png")],
    }


def count(program, arguments, work):
    environment = {"PATH": "/usr/bin:/bin", "LC_ALL": "C"}
    if "SCNRENDER_MODULES" in os.environ:
        environment["SCNRENDER_MODULES"] = os.environ["SCNRENDER_MODULES"]
    done = subprocess.run(["valgrind", "--tool=callgrind",
                           f"--callgrind-out-file={os.path.join(work, 'callgrind')}", program,
                           *arguments], env=environment, capture_output=True, text=True,
                          errors="replace", check=False)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found:
        raise BenchError(f"callgrind failed ({done.returncode}):\n{done.stderr[-2000:]}")
    return int(found[1])


def output_of(command):
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout


def surroundings(program):
    """All that a count depends on beside the sources."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        flags = next((line.split() for line in file if line.startswith("flags")), [])
    compilers = re.findall(r"\]\s+(.+)", output_of(["readelf", "-p", ".comment", program]))
    libraries = re.findall(r"(lib(?:embree|tbb)\S+) =>", output_of(["ldd", program]))
    return {"compiler": "; ".join(sorted(set(line.strip() for line in compilers))),
            "libc": os.confstr("CS_GNU_LIBC_VERSION"),
            "libraries": " ".join(sorted(set(libraries))),
            "valgrind": output_of(["valgrind", "--version"]).strip(),
            # Valgrind shows the program AVX2 where the processor has it, never AVX-512.
            "vectors": "AVX2" if "avx2" in flags else "SSE"}


def changes(kept, here):
    return [f"{name}: {here[name]} here, {kept.get(name)} in the baseline"
            for name in here if kept.get(name) != here[name]]


def run(program, update):
    """The exit status: 0, 1 where a count grew, 77 where there is nothing to compare with."""
    if not shutil.which("valgrind") or not shutil.which("readelf"):
        print("tools/bench: counting instructions needs valgrind and readelf")
        return 77
    with open(BASELINE, encoding="utf-8") as file:
        baseline = json.load(file)
    here = surroundings(program)
    differ = changes(baseline["surroundings"], here)
    if differ and not update:
        print("not compared, since counts depend on these:\n  " + "\n  ".join(differ))
        return 77
    counts, grown = {}, []
    with tempfile.TemporaryDirectory() as work:
        for name, arguments in cases(program, work).items():
            counts[name] = count(program, arguments, work)
            before = baseline["counts"].get(name)
            change = f"{100 * (counts[name] / before - 1):+8.2f} %" if before else "     new"
            print(f"{name:14} {counts[name] / 1e6:9.2f} million {change}", flush=True)
            if not before or counts[name] > MOST * before:
                grown.append(name)
    if update:
        with open(BASELINE + ".new", "w", encoding="utf-8") as file:
            json.dump({"surroundings": here, "counts": counts}, file, indent=1)
            file.write("\n")
        os.replace(BASELINE + ".new", BASELINE)
        return 0
    if grown:
        print(f"grown by more than {100 * MOST - 100:.0f} %: {', '.join(grown)}\n"
              "Where that is worth it: tools/bench --instructions --update, and say why in the commit.")
    return 1 if grown else 0
