# The exported hall has no lamps: they are one mesh of small polyhedra here, which Cycles finds by its
# hierarchy of boxes. (Its own sphere lights are tried one by one by every ray that is looking for lamps:
# thirty times slower. Exported spheres have 65,000 faces each.) Each polyhedron gives the sphere's
# power. Where they hang comes from the scene as scnrender evaluated it.
import json

import bmesh

plain_build = build


def polyhedron():
    """Points and triangles of a sphere of radius 1 divided into 80, of the sphere's area."""
    ball = bmesh.new()
    bmesh.ops.create_icosphere(ball, subdivisions=2, radius=1)
    grow = math.sqrt(4 * math.pi / sum(face.calc_area() for face in ball.faces))
    points = [tuple(grow * x for x in vertex.co) for vertex in ball.verts]
    return points, [[vertex.index for vertex in face.verts] for face in ball.faces]


def build():
    plain_build()
    with open(JOB["dump"], encoding="utf-8") as file:
        scene = json.load(file)
    shapes = {shape["id"]: shape["fields"] for shape in scene["shapes"]}
    ball_points, ball_faces = polyhedron()
    lamps = Geometry()
    lamps.colors = []
    for light in scene["lights"]:
        ball = shapes[light["fields"]["shape"]]
        start = len(lamps.points)
        lamps.points += [add(ball["center"], p, ball["radius"]) for p in ball_points]
        lamps.faces += [[start + i for i in face] for face in ball_faces]
        shine = times(light["color"], light["fields"]["radiance"]["value"])
        lamps.colors += [shine] * len(ball_points)
    glow = material("lamps", lambda n: n.emission(n.vertex_color()))
    shape(None, "lamps", blender_mesh("lamps", lamps), glow)
