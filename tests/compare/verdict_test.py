"""What compare/compare concludes from figures, and what scn_metrics finds in pictures made for it."""
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "compare"))
from tool import verdict  # noqa: E402
from tool.scene import Directives, SceneError, Wish  # noqa: E402


def side(mean, error):
    return {"mean": mean, "error": error, "rgb": [mean] * 3}


def figures(ours, theirs, percent=100.0):
    return {"regions": [{"name": "ball", "pixels": 10, "ours": side(*ours), "theirs": side(*theirs)}],
            "agree": {"percent": percent}}


def asked(regions):
    wish = Wish()
    wish.agrees = regions
    return wish


class Judgement(unittest.TestCase):
    def fault(self, ours, theirs):
        return verdict.judge_region(verdict.rows_of(figures(ours, theirs))[0])

    def test_ratio_and_its_error(self):
        row = verdict.rows_of(figures((2.0, 0.02), (2.1, 0.021)))[0]
        self.assertAlmostEqual(row["ratio"], 1.05)
        self.assertAlmostEqual(row["error"], 1.05 * (0.01 ** 2 + 0.01 ** 2) ** 0.5)
        self.assertAlmostEqual(row["z"], 0.1 / (0.02 ** 2 + 0.021 ** 2) ** 0.5)

    def test_agreement(self):
        self.assertIsNone(self.fault((1.0, 0.001), (1.003, 0.001)))

    def test_a_wrong_ratio(self):
        self.assertIn("+0.60 %", self.fault((1.0, 0.0015), (1.006, 0.0015)))

    def test_a_small_but_certain_difference(self):
        self.assertIn("standard errors apart", self.fault((1.0, 0.0001), (1.004, 0.0001)))

    def test_noise_proves_nothing(self):
        self.assertIn("too noisy", self.fault((1.0, 0.01), (1.0, 0.01)))

    def test_black(self):
        self.assertIsNone(self.fault((0.0, 0.0), (0.0, 0.0)))
        self.assertIn("black", self.fault((0.0, 0.0), (1.0, 0.0)))

    def test_regions_that_are_not_seen(self):
        self.assertEqual(verdict.judge(asked(["cube"]), "cycles", figures((1, 0), (1, 0))),
                         ["cube: not to be seen"])
        self.assertEqual(verdict.judge(asked(None), "cycles", figures((1, 0), (2, 0))), [])

    def test_pixels_of_povray(self):
        self.assertEqual(verdict.judge(asked([]), "povray", figures((1, 0), (1, 0), 99.6)), [])
        self.assertEqual(len(verdict.judge(asked([]), "povray", figures((1, 0), (1, 0), 99.4))), 1)


class Baseline(unittest.TestCase):
    @staticmethod
    def results(ratio, error, percent=100.0):
        rows = [{"name": "ball", "ratio": ratio, "error": error}]
        return [{"name": "scene", "partners": {
            "cycles": {"agree": {"percent": percent}, "rows": rows}}}]

    def moved(self, before, now):
        return verdict.moved(verdict.figures_to_keep(self.results(*before)), self.results(*now))

    def test_within_the_error(self):
        self.assertEqual(self.moved((1.0, 0.001), (1.004, 0.001)), [])

    def test_beyond_the_error(self):
        self.assertEqual(len(self.moved((1.0, 0.001), (1.007, 0.001))), 1)

    def test_without_noise_little_is_allowed(self):
        self.assertEqual(len(self.moved((1.0, 0), (1.0001, 0))), 1)

    def test_fewer_pixels_agree(self):
        self.assertEqual(len(self.moved((1.0, 0), (1.0, 0, 99.9))), 1)

    def test_noise_moves_the_share_of_pixels(self):
        self.assertEqual(self.moved((1.0, 0.001, 41.0), (1.0, 0.001, 39.0)), [])

    def test_unknown_scene(self):
        self.assertEqual(len(verdict.moved({}, self.results(1.0, 0))), 1)


class Kept(unittest.TestCase):
    def scene(self, name, **wishes):
        with tempfile.NamedTemporaryFile("w", suffix=".scn") as file:
            scene = Directives(file.name)
        scene.name = name
        for partner, regions in wishes.items():
            scene.wishes[partner].agrees = regions
        return scene

    def test_summary(self):
        kept = {"a": {"povray": {"percent": 99.9, "regions": {}},
                      "cycles": {"percent": 1, "regions": {"(picture)": [0.999, 0], "x": [1.003, 0], "y": [2, 0]}}},
                "b": {"povray": {"percent": 10, "regions": {}}}}
        lines = verdict.kept_summary(kept, [self.scene("a", povray=[], cycles=["x", "picture"]),
                                            self.scene("b"), self.scene("new", cycles=[])])
        self.assertEqual(lines["povray"], "1 scene: 99.90 % to 99.90 % of the pixels are within 0.1 %")
        self.assertEqual(lines["cycles"], "1 scene, 2 regions: mean radiance 0.9990 to 1.0030 of ours, "
                                          "0.22 % off (root mean square)")  # sqrt((.1² + .3²)/2)


class Comments(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.scn")
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            return Directives(path)

    def test_all_of_them(self):
        scene = self.read("// What it is,\n// and why.\n//@ povray agrees\n//@ cycles agrees: a, b\n"
                          "//@ cycles differs: c, d: it is so\n//@   for a reason\n//@ samples: 12\n"
                          "//@ cycles samples: 34\n")
        self.assertEqual(scene.title, "What it is, and why.")
        self.assertEqual(scene.wishes["povray"].agrees, [])
        self.assertEqual(scene.wishes["cycles"].agrees, ["a", "b"])
        self.assertEqual(scene.wishes["cycles"].differs,
                         {"c": "it is so for a reason", "d": "it is so for a reason"})
        self.assertEqual(scene.samples, {"scnrender": 12, "cycles": 34})

    def test_a_mistake(self):
        with self.assertRaisesRegex(SceneError, "scene.scn:1"):
            self.read("//@ povray agree\n")


class CommandLine(unittest.TestCase):
    def run_compare(self, *arguments):
        return subprocess.run([sys.executable, os.path.join(ROOT, "compare/compare"), *arguments],
                              capture_output=True, text=True, check=False)

    def test_wrong_use(self):
        for arguments in ((), ("--seeds", "1", "a.scn"), ("--only", "mitsuba", "a.scn")):
            self.assertEqual(self.run_compare(*arguments).returncode, 2)

    def test_a_scene_that_is_not_there(self):
        done = self.run_compare("nowhere.scn")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nowhere.scn", done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_every_scene_says_what_must_agree_or_why_not(self):
        folder = os.path.join(ROOT, "compare/scenes")
        scenes = [Directives(os.path.join(folder, name)) for name in sorted(os.listdir(folder))
                  if name.endswith(".scn")]
        self.assertGreaterEqual(len(scenes), 20)
        for scene in scenes:
            self.assertTrue(scene.title, scene.name)
            for partner, wish in scene.wishes.items():
                self.assertTrue(wish.agrees is not None or wish.differs, f"{scene.name}: {partner}")
            self.assertTrue(any(wish.agrees is not None for wish in scene.wishes.values()),
                            scene.name)


def pfm(path, rows):
    """Little-endian floats, the bottom row first."""
    with open(path, "wb") as file:
        file.write(f"PF\n{len(rows[0])} {len(rows)}\n-1.0\n".encode())
        for row in reversed(rows):
            for value in row:
                file.write(struct.pack("<3f", *value))


def tiff_of_ids(path, rows):
    """One channel of whole numbers of 32 bits, uncompressed."""
    height, width = len(rows), len(rows[0])
    data = b"".join(struct.pack("<I", value) for row in rows for value in row)
    tags = [(256, 3, width), (257, 3, height), (258, 3, 32), (259, 3, 1), (262, 3, 1), (273, 4, 0),
            (277, 3, 1), (278, 3, height), (279, 4, len(data)), (339, 3, 1)]
    offset = 8 + 2 + 12 * len(tags) + 4
    out = struct.pack("<2sHI", b"II", 42, 8) + struct.pack("<H", len(tags))
    for tag, kind, value in tags:
        out += struct.pack("<HHII", tag, kind, 1, offset if tag == 273 else value)
    with open(path, "wb") as file:
        file.write(out + struct.pack("<I", 0) + data)


@unittest.skipUnless(os.environ.get("SCN_METRICS"), "without scn_metrics")
class Metrics(unittest.TestCase):
    def test_regions_and_edges(self):
        # Two objects side by side, 6 x 4 pixels; at the seam between them is no inside.
        ids = [[7] * 3 + [9] * 3] * 4
        ours = [[[1, 2, 3]] * 3 + [[4, 4, 4]] * 3] * 4
        with tempfile.TemporaryDirectory() as folder:
            def file(name):
                return os.path.join(folder, name)
            tiff_of_ids(file("ids.tif"), ids)
            with open(file("names.txt"), "w", encoding="utf-8") as names:
                names.write("7\tleft\n9\tright \"quoted\"\n")
            pfm(file("a1.pfm"), ours)
            pfm(file("a2.pfm"), [[[2 * c for c in p] for p in row] for row in ours])
            pfm(file("b1.pfm"), ours)
            pfm(file("b2.pfm"), ours)
            done = subprocess.run(
                [os.environ["SCN_METRICS"], file("ids.tif"), file("names.txt"), file("out"),
                 file("a1.pfm"), file("a2.pfm"), "--", file("b1.pfm"), file("b2.pfm")],
                capture_output=True, text=True, check=True)
            for picture in ("ours", "theirs", "difference", "relative", "flip"):
                self.assertTrue(os.path.getsize(file(f"out_{picture}.png")) > 50)
        got = json.loads(done.stdout)
        regions = {region["name"]: region for region in got["regions"]}
        self.assertEqual(regions["left"]["pixels"], 8)
        self.assertEqual(regions['right "quoted"']["pixels"], 8)
        self.assertEqual(regions["(edges)"]["pixels"], 8)
        self.assertEqual(regions["left"]["theirs"]["rgb"], [1, 2, 3])
        self.assertEqual(regions["left"]["ours"]["mean"], 3)  # of 2 and 4
        self.assertAlmostEqual(regions["left"]["ours"]["error"], 1)  # sqrt(2)/sqrt(2)
        self.assertEqual(regions["left"]["theirs"]["error"], 0)
        self.assertEqual(got["agree"]["percent"], 0)
        self.assertEqual(got["agree"]["differ_on_silhouettes"], 8)
        self.assertEqual(got["agree"]["differ_elsewhere"], 16)


if __name__ == "__main__":
    unittest.main()
