"""Run inside Blender: renders an exported scene once, and says what that took.

    blender -b --factory-startup --python-exit-code 1 -P cycles.py -- '{"scene": …}'

The last argument is JSON: "scene", what `scnrender export --to blender` wrote; "hook", Python beside a
case that is run among the scene's own names before it is built, or null; "params", "dump": the scene's
parameters and the file of `scnrender --dump scene`, for the hook; "output", "samples", "seed", "threads",
"size". The last line printed is JSON: seconds and processor seconds of the render call alone, without
Blender's start and the building of its scene in Python, but with all that Cycles itself does first.
"""
import json
import os
import sys
import time

import bpy

job = json.loads(sys.argv[-1])
names = {"__name__": "scene", "__file__": job["scene"], "JOB": job}


def run(path):
    with open(path, encoding="utf-8") as file:
        exec(compile(file.read(), path, "exec"), names)


def render(_):
    scene = names["SCENE"]
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
    scene.cycles.samples, scene.cycles.seed = job["samples"], job["seed"]
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.filepath = os.path.abspath(job["output"])
    wall, cpu = time.monotonic(), time.process_time()
    bpy.ops.render.render(write_still=True, scene=scene.name)
    print(json.dumps({"wall": time.monotonic() - wall, "cpu": time.process_time() - cpu}),
          flush=True)


run(job["scene"])
if job["hook"]:
    run(job["hook"])
names["render"] = render
sys.argv = sys.argv[:1] + ["--", "--output", job["output"]]
names["main"](os.path.basename(job["scene"]), names["build"])
