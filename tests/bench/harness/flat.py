"""front_loop.scn's spheres as literal statements, for scnrender and for POV-Ray."""
import math
import os
import subprocess

from .cases import FOLDER


def spheres(count):
    for i in range(count):
        for j in range(count):
            yield (f"{0.1 * i:.1f}", f"{math.sin(i * 0.05) * math.sin(j * 0.05):.8f}", 0.1 * j,
                   f"{0.02 + 0.01 * ((i + j) % 3):.2f}")


def write(program, folder, count):
    """The two files, written where they aren't there yet. POV-Ray's camera, light and material are those
    of the exporter, its spheres as short as they can be."""
    scn, pov = (os.path.join(folder, f"flat_{count}.{end}") for end in ("scn", "pov"))
    if os.path.exists(scn) and os.path.exists(pov):
        return scn, pov
    with open(os.path.join(FOLDER, "flat_head.scn"), encoding="utf-8") as file:
        head = file.read()
    one = os.path.join(folder, "flat_one.scn")
    with open(one, "w", encoding="utf-8") as file:
        file.write(head + "sphere { material: clay }\n")
    exported = subprocess.run([program, "export", "--to", "povray", one, "--quiet", "-o", "-"],
                              check=True, capture_output=True, text=True).stdout
    exported = exported[:exported.index("sphere {")]
    with open(scn + ".new", "w", encoding="utf-8") as ours, \
            open(pov + ".new", "w", encoding="utf-8") as theirs:
        ours.write(head)
        theirs.write(exported)
        for x, y, z, r in spheres(count):
            ours.write(f"sphere {{ center: ({x}, {y}, {z:.1f}), radius: {r}, material: clay }}\n")
            theirs.write(f"sphere {{ <{x}, {y}, {-z:.1f}>, {r} material {{ Material_0 }} }}\n")
    os.replace(pov + ".new", pov)
    os.replace(scn + ".new", scn)
    return scn, pov
