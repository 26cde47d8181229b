"""The cases of tools/bench: what is run, how large, against whom, and what is aimed at."""
import os
from dataclasses import dataclass, field

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "cases")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(FOLDER)))


@dataclass
class Size:
    """How large a case is. `reference` samples are rendered with each of `seeds` seeds."""
    width: int = 0
    height: int = 0
    samples: int = 1
    reference: int = 0
    seeds: int = 4
    params: dict = field(default_factory=dict)


@dataclass
class Aim:
    """A figure of the table (measure.FIGURES), and the least that it should be: a ratio, or where
    `absolute` is set a value of scnrender's own."""
    figure: str
    least: float
    absolute: bool = False


@dataclass
class Case:
    name: str
    what: str
    peer: str  # povray or cycles
    kind: str  # check: no picture; picture: without noise; noise: efficiency; first: the first pixel
    scene: str  # its file, or flat: generated
    full: Size
    quick: Size
    aims: list
    peer_params: dict = field(default_factory=dict)  # of what is exported

    def path(self):
        return self.scene if os.path.isabs(self.scene) else os.path.join(FOLDER, self.scene)

    def beside(self, extension):
        """A file of the peer's that is written by hand, or None."""
        file = os.path.splitext(self.path())[0] + extension
        return file if os.path.exists(file) else None


CASES = [
    Case("front-loop", "a million spheres from a nested loop, read and evaluated", "povray", "check",
         "front_loop.scn", Size(), Size(params={"count": 100}), [Aim("cpu", 12)]),
    Case("front-flat", "the same spheres as literal statements, 72 MB of text, read and evaluated",
         "povray", "check", "flat", Size(params={"count": 1000}), Size(params={"count": 60}),
         [Aim("cpu", 12), Aim("rate", 200, absolute=True)]),
    Case("flat-picture", "the same text to a picture of 1024 × 1024 pixels, one ray each, one light with "
         "shadows", "povray", "picture", "flat", Size(1024, 1024, params={"count": 1000}),
         Size(64, 64, params={"count": 60}), [Aim("wall", 10), Aim("peak", 3)]),
    Case("cornell", "the Cornell box, 512 × 512 pixels, depth 8", "cycles", "noise",
         os.path.join(ROOT, "examples/cornell_box.scn"), Size(512, 512, 64, 32),
         Size(32, 32, 4, 16, 2),
         [Aim("cpu_speed", 3), Aim("cpu_efficiency", 5), Aim("dark_efficiency", 5), Aim("equal_error", 5)]),
    Case("materials", "16 spheres of GGX, glass and coats under a picture of the surroundings, depth 12",
         "cycles", "noise", "materials.scn", Size(256, 144, 64, 128), Size(48, 27, 4, 16, 2),
         [Aim("cpu_efficiency", 4)]),
    Case("many-lights", "2,000 coloured spheres of light in a hall", "cycles", "noise",
         "many_lights.scn", Size(240, 135, 64, 128, 2), Size(48, 27, 4, 16, 2, {"lamps": 100}),
         [Aim("cpu_efficiency", 10)], {"lamps": 0}),
    Case("instances", "a million instances of a tree of 100,000 triangles, the first pixel", "cycles",
         "first", "instances.scn", Size(64, 36, 1, params={"rows": 1000}),
         Size(32, 18, 1, params={"rows": 10, "leaves": 100}), [Aim("wall", 5), Aim("peak", 2)],
         {"rows": 1}),
    Case("caustic", "a glass ball over a matt floor under a small area light", "cycles", "noise",
         "caustic.scn", Size(240, 180, 64, 512, 2), Size(32, 24, 4, 16, 2), [Aim("cpu_efficiency", 10)]),
    Case("start", "a picture of one sphere, 64 × 64 pixels, cold", "povray", "picture", "start.scn",
         Size(64, 64), Size(64, 64), [Aim("wall", 3), Aim("check_ms", 10, absolute=True)]),
]
