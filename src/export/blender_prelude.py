# --- How scenes are built in Blender ---------------------------------------------------------------
#
# Lengths are metres, colors linear Rec.709, and points those of the .scn file: right-handed, y up.
# Blender's z is up, so a point (x, y, z) is made (x, -z, y), and a map M becomes T M T^-1.

import array
import base64
import functools
import math
import os
import sys
import time

import bpy
from mathutils import Matrix, Vector

# Pieces around a curved shape. A polygon of so many sides lies within 1 - cos(pi / SEGMENTS) of its
# circle's radius: 7.5e-5 of it for 256.
SEGMENTS = 256

SCENE = None  # the Blender scene that is built
TO_BLENDER = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def point(p):
    return (p[0], -p[2], p[1])


def scene_matrix(rows):
    """4 x 4 of the three rows of a map of the scene; of None the identity."""
    return Matrix((*rows, (0, 0, 0, 1))) if rows else Matrix.Identity(4)


# --- Vectors ---------------------------------------------------------------------------------------


def add(a, b, k=1):
    return (a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2])


def times(a, k):
    return (a[0] * k, a[1] * k, a[2] * k)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return times(a, 1 / math.sqrt(dot(a, a)))


def frame(n):
    """Two axes across a unit vector, as scnrender lays them (Duff et al. 2017)."""
    sign = math.copysign(1, n[2])
    a = -1 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


# --- Geometry --------------------------------------------------------------------------------------


class Geometry:
    """Vertices with their normals, texture coordinates and tangents (dp/du), and faces."""

    def __init__(self):
        self.points, self.normals, self.uvs, self.tangents = [], [], [], []
        self.colors = None
        self.faces = []
        self.smooth = False

    def vertex(self, p, n, uv, tangent):
        self.points.append(p)
        self.normals.append(n)
        self.uvs.append(uv)
        self.tangents.append(tangent)
        return len(self.points) - 1

    def grid(self, columns, rows, at, tip=()):
        """Quads over (u, v) in [0, 1]^2; at(u, v) gives a vertex. Rows in `tip` are one point."""
        us = [i / columns for i in range(columns + 1)]
        start = len(self.points)
        for j, v in enumerate(rows):
            for i, u in enumerate(us):
                self.vertex(*at(u + 0.5 / columns if j in tip and i < columns else u, v))
        width = columns + 1
        for j in range(len(rows) - 1):
            for i in range(columns):
                a = start + j * width + i
                quad = [a, a + 1, a + 1 + width, a + width]
                if j in tip:
                    quad = [a, a + 1 + width, a + width]
                elif j + 1 in tip:
                    quad = [a, a + 1, a + width]
                self.faces.append(quad)

    def quad(self, corner, u, v, uvs=((0, 0), (1, 0), (1, 1), (0, 1))):
        n = unit(cross(u, v))
        points = (corner, add(corner, u), add(add(corner, u), v), add(corner, v))
        self.faces.append([self.vertex(p, n, uv, unit(u)) for p, uv in zip(points, uvs)])


MESHES = {}


def shared(make):
    """The same arguments give the same mesh, which Blender keeps once."""

    @functools.wraps(make)
    def lookup(*arguments, **named):
        key = (make.__name__, arguments, tuple(sorted(named.items())))
        if key not in MESHES:
            MESHES[key] = blender_mesh(make.__name__, make(*arguments, **named))
        return MESHES[key]

    return lookup


def blender_mesh(name, geometry):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([point(p) for p in geometry.points], [], geometry.faces)
    corners = [i for face in geometry.faces for i in face]
    if geometry.uvs:
        layer = mesh.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", [x for i in corners for x in geometry.uvs[i]])
    if geometry.tangents:
        layer = mesh.attributes.new("tangent", "FLOAT_VECTOR", "POINT")
        layer.data.foreach_set("vector", [x for t in geometry.tangents for x in point(t)])
    if geometry.colors:
        layer = mesh.color_attributes.new("vertex_color", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", [x for c in geometry.colors for x in (*c, 1)])
    mesh.polygons.foreach_set("use_smooth", [geometry.smooth] * len(geometry.faces))
    if geometry.smooth:
        if hasattr(mesh, "use_auto_smooth"):  # until Blender 4.0
            mesh.use_auto_smooth = True
            mesh.auto_smooth_angle = math.pi
        mesh.normals_split_custom_set_from_vertices([point(n) for n in geometry.normals])
    mesh.update()
    mesh.materials.append(None)  # each object has its own material in this slot
    return mesh


@shared
def sphere(center=(0, 0, 0), radius=1):
    g = Geometry()
    g.smooth = True

    def at(u, v):
        longitude, latitude = (2 * u - 1) * math.pi, (v - 0.5) * math.pi
        n = (math.sin(longitude) * math.cos(latitude), math.sin(latitude),
             math.cos(longitude) * math.cos(latitude))
        return (add(center, n, radius), n, (u, v), (math.cos(longitude), 0, -math.sin(longitude)))

    rings = SEGMENTS // 2
    g.grid(SEGMENTS, [j / rings for j in range(rings + 1)], at, (0, rings))
    return g


@shared
def box(low, high):
    a, b = low, high
    s = add(b, a, -1)
    g = Geometry()
    g.quad(a, (0, 0, s[2]), (0, s[1], 0))
    g.quad((b[0], a[1], b[2]), (0, 0, -s[2]), (0, s[1], 0))
    g.quad(a, (s[0], 0, 0), (0, 0, s[2]))
    g.quad((a[0], b[1], b[2]), (s[0], 0, 0), (0, 0, -s[2]))
    g.quad((b[0], a[1], a[2]), (-s[0], 0, 0), (0, s[1], 0))
    g.quad((a[0], a[1], b[2]), (s[0], 0, 0), (0, s[1], 0))
    return g


@shared
def plane(at, normal, size, middle):
    """A square, `size` from its middle (below the point `middle`) to the edges: with no end in the
    scene. Finer towards the middle, where single precision matters."""
    s = (1, 0, 0) if abs(normal[0]) < 0.9 else (0, 0, -1)
    s = unit(add(s, normal, -dot(s, normal)))
    t = cross(normal, s)
    u0, v0 = dot(add(middle, at, -1), s), dot(add(middle, at, -1), t)
    steps = [-size, -size / 100, -size / 10000, size / 10000, size / 100, size]
    g = Geometry()
    for v in steps:
        for u in steps:
            p = add(add(at, s, u0 + u), t, v0 + v)
            g.vertex(p, normal, (u0 + u, v0 + v), s)
    for j in range(5):
        for i in range(5):
            a = 6 * j + i
            g.faces.append([a, a + 1, a + 7, a + 6])
    return g


@shared
def disc(center, normal, radius, inner_radius=0):
    s, t = frame(normal)
    g = Geometry()

    def at(u, v):
        c, d = math.cos(2 * math.pi * u), math.sin(2 * math.pi * u)
        out = add(times(s, c), t, d)
        r = radius + (inner_radius - radius) * v
        return add(center, out, r), normal, (u, v), add(times(s, -d), t, c)

    g.grid(SEGMENTS, (0, 1), at, () if inner_radius > 0 else (1,))
    return g


@shared
def rectangle(corner, u, v, pieces=1):
    """Lamps are cut into pieces: Cycles (until 3.6 at least) samples large triangles that are seen
    flat up to 1 % too dark."""
    g = Geometry()
    n, tangent = unit(cross(u, v)), unit(u)

    def at(x, y):
        return add(add(corner, u, x), v, y), n, (x, y), tangent

    g.grid(pieces, [j / pieces for j in range(pieces + 1)], at)
    return g


@shared
def triangle(a, b, c):
    g = Geometry()
    u, v = add(b, a, -1), add(c, a, -1)
    n = unit(cross(u, v))
    g.faces.append([g.vertex(p, n, uv, unit(u))
                    for p, uv in ((a, (0, 0)), (b, (1, 0)), (c, (0, 1)))])
    return g


@shared
def frustum(start, end, radius_start, radius_end, caps=True):
    """A cylinder, or a cone or a piece of one."""
    axis = add(end, start, -1)
    height = math.sqrt(dot(axis, axis))
    axis = times(axis, 1 / height)
    s, t = frame(axis)
    slope = (radius_end - radius_start) / height
    g = Geometry()
    g.smooth = True

    def around(u):
        c, d = math.cos(2 * math.pi * u), math.sin(2 * math.pi * u)
        return add(times(s, c), t, d), add(times(s, -d), t, c)

    def side(u, v):
        out, tangent = around(u)
        p = add(add(start, axis, v * height), out, radius_start + (radius_end - radius_start) * v)
        return p, unit(add(out, axis, -slope)), (u, v), tangent

    g.grid(SEGMENTS, (0, 1), side, (0,) * (radius_start == 0) + (1,) * (radius_end == 0))
    for at, radius, turn in ((start, radius_start, -1), (end, radius_end, 1)):

        def cap(u, v):
            out, tangent = around(turn * u)
            return add(at, out, radius * (1 - v)), times(axis, turn), (u, v), times(tangent, turn)

        if caps and radius > 0:
            g.grid(SEGMENTS, (0, 1), cap, (1,))
    return g


@shared
def torus(center, axis, major_radius, minor_radius):
    s, t = frame(axis)
    g = Geometry()
    g.smooth = True

    def at(u, v):
        c, d = math.cos(2 * math.pi * u), math.sin(2 * math.pi * u)
        out, tangent = add(times(s, c), t, d), add(times(s, -d), t, c)
        n = add(times(out, math.cos(2 * math.pi * v)), axis, math.sin(2 * math.pi * v))
        return add(add(center, out, major_radius), n, minor_radius), n, (u, v), tangent

    rows = SEGMENTS // 2
    g.grid(SEGMENTS, [j / rows for j in range(rows + 1)], at)
    return g


def packed(kind, text):
    """Little-endian numbers of 4 bytes in base64."""
    values = array.array(kind)
    values.frombytes(base64.b64decode(text))
    if sys.byteorder == "big":
        values.byteswap()
    return values


def tuples(values, size):
    step = iter(values)
    return list(zip(*[step] * size))


def tangent_of(points, uvs, face):
    """dp/du of a triangle, in its plane."""
    a, b, c = face
    p, q = add(points[b], points[a], -1), add(points[c], points[a], -1)
    x, y = uvs[b][0] - uvs[a][0], uvs[b][1] - uvs[a][1]
    z, w = uvs[c][0] - uvs[a][0], uvs[c][1] - uvs[a][1]
    area = x * w - y * z
    return times(add(times(p, w), q, -y), 1 / area) if area else (0, 0, 0)


def mesh(name, origin, positions, triangles, normals=None, uvs=None, colors=None):
    """Flat lists, or base64 of them; positions are offsets from `origin`."""
    def numbers(kind, data, size):
        return tuples(packed(kind, data) if isinstance(data, str) else data, size)

    g = Geometry()
    g.points = [add(origin, p) for p in numbers("f", positions, 3)]
    g.faces = numbers("I", triangles, 3)
    g.normals = numbers("f", normals, 3) if normals else []
    g.smooth = bool(normals)
    g.uvs = numbers("f", uvs, 2) if uvs else []
    g.colors = numbers("f", colors, 3) if colors else None
    if uvs:
        sums = [(0, 0, 0)] * len(g.points)
        for face in g.faces:
            tangent = tangent_of(g.points, g.uvs, face)
            for i in face:
                sums[i] = add(sums[i], tangent)
        g.tangents = [unit(t) if dot(t, t) > 0 else (1, 0, 0) for t in sums]
    return blender_mesh(name, g)


# --- Objects ---------------------------------------------------------------------------------------


def link(into, thing):
    (into or SCENE.collection).objects.link(thing)


def put(thing, matrix):
    """At a matrix of Blender's space. One that shears can't be an object's own: a parent's inverse
    holds it."""
    thing.matrix_world = matrix
    location, rotation, scale = matrix.decompose()
    made = Matrix.LocRotScale(location, rotation, scale)
    size = max(abs(matrix[i][j]) for i in range(3) for j in range(3))
    if any(abs(made[i][j] - matrix[i][j]) > 1e-5 * size for i in range(3) for j in range(3)):
        holder = bpy.data.objects.new(thing.name + " (shear)", None)
        holder.empty_display_size = 0.01
        for collection in thing.users_collection:
            collection.objects.link(holder)
        thing.matrix_world = Matrix.Identity(4)
        thing.parent = holder
        thing.matrix_parent_inverse = matrix


def shape(into, name, data, material, matrix=None, unit_sphere=None):
    """An object. `unit_sphere`, a center and a radius, is applied before `matrix`."""
    thing = bpy.data.objects.new(name, data)
    link(into, thing)
    m = scene_matrix(matrix)
    if unit_sphere:
        center, radius = unit_sphere
        m = m @ Matrix.Translation(center) @ Matrix.Scale(radius, 4)
    put(thing, TO_BLENDER @ m @ TO_BLENDER.inverted())
    slot = thing.material_slots[0]
    slot.link = "OBJECT"
    slot.material = material or default_material()
    return thing


PROTOTYPES = {}


def instance(make, name, material, matrix):
    """One more of the collection that `make(collection, material)` fills."""
    key = (make.__name__, material.name if material else None)
    if key not in PROTOTYPES:
        PROTOTYPES[key] = bpy.data.collections.new(make.__doc__ or make.__name__)
        make(PROTOTYPES[key], material)
    thing = bpy.data.objects.new(name, None)
    thing.empty_display_size = 0.01
    thing.instance_type = "COLLECTION"
    thing.instance_collection = PROTOTYPES[key]
    link(None, thing)
    put(thing, TO_BLENDER @ scene_matrix(matrix) @ TO_BLENDER.inverted())


def area_of(data, matrix):
    """Square metres of a mesh under a matrix of the scene."""
    m = TO_BLENDER @ scene_matrix(matrix) @ TO_BLENDER.inverted()
    points = [m @ v.co for v in data.vertices]
    data.calc_loop_triangles()
    return sum((points[t.vertices[1]] - points[t.vertices[0]])
               .cross(points[t.vertices[2]] - points[t.vertices[0]]).length / 2
               for t in data.loop_triangles)


# --- Nodes -----------------------------------------------------------------------------------------


class Nodes:
    """Builds a node tree. Values are numbers, tuples, or sockets of other nodes."""

    def __init__(self, tree):
        self.tree = tree
        self.volume = None
        self.turned = False  # on the back of a two-sided material
        tree.nodes.clear()

    def node(self, kind, **settings):
        node = self.tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        return node

    def set(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif socket.type == "VALUE":
            socket.default_value = value
            if abs(socket.default_value - value) > 1e-6 * abs(value):  # beyond the slider's end
                node = self.node("ShaderNodeValue")
                node.outputs[0].default_value = value
                self.tree.links.new(node.outputs[0], socket)
        else:
            value = value if isinstance(value, tuple) else (value,) * 3
            socket.default_value = (*value, 1) if socket.type == "RGBA" else value

    def put(self, kind, inputs, output=0, **settings):
        node = self.node(kind, **settings)
        for name, value in inputs.items():
            self.set(node.inputs[name], value)
        return node.outputs[output]

    def layout(self):
        """Columns by the distance to the output, for whoever looks at the nodes."""
        depth = {}

        def visit(node, column):
            if depth.get(node, -1) < column:
                depth[node] = column
                for socket in node.inputs:
                    for incoming in socket.links:
                        visit(incoming.from_node, column + 1)

        for node in self.tree.nodes:
            if not any(socket.links for socket in node.outputs):
                visit(node, 0)
        rows = {}
        for node in self.tree.nodes:
            column = depth.get(node, 0)
            rows[column] = rows.get(column, 0) + 1
            node.location = (-220 * column, -260 * (rows[column] - 1))

    # Arithmetic.

    def math(self, operation, a, b=0.0, c=0.0):
        node = self.node("ShaderNodeMath", operation=operation)
        for socket, value in zip(node.inputs, (a, b, c)):
            self.set(socket, value)
        return node.outputs[0]

    def vector(self, operation, a, b=(0.0, 0.0, 0.0), output=0):
        node = self.node("ShaderNodeVectorMath", operation=operation)
        self.set(node.inputs[0], a)
        if len(node.inputs) > 1:
            self.set(node.inputs[1], b)
        return node.outputs[output]

    def dot(self, a, b):
        return self.vector("DOT_PRODUCT", a, b, "Value")

    def clamp(self, value):
        return self.put("ShaderNodeClamp", {"Value": value})

    def parts(self, vector):
        node = self.node("ShaderNodeSeparateXYZ")
        self.set(node.inputs[0], vector)
        return node.outputs

    def channels(self, color):
        return self.parts(color) if isinstance(color, bpy.types.NodeSocket) else color

    def join(self, x, y, z):
        return self.put("ShaderNodeCombineXYZ", {"X": x, "Y": y, "Z": z})

    # A texture's color as a number is its luminance.
    def gray(self, color):
        return self.dot(color, (0.2126, 0.7152, 0.0722))

    def arithmetic(self, operation, a, b):
        # Blender's division by zero is zero, too.
        return self.vector(operation.upper(), a, b)

    # Textures. Coordinates are those of the .scn file.

    def coordinates(self, space):
        if space == "uv":
            return self.put("ShaderNodeUVMap", {}, uv_map="uv")
        if space == "object":
            p = self.put("ShaderNodeTexCoord", {}, "Object")
        else:
            p = self.put("ShaderNodeNewGeometry", {}, "Position")
        x, y, z = self.parts(p)
        return self.join(x, z, self.math("MULTIPLY", y, -1.0))

    def checker(self, a, b, scale, space):
        # The shift keeps a face that lies on a boundary of cells in one color.
        p = self.vector("MULTIPLY", self.coordinates(space), scale)
        x, y, z = self.parts(self.vector("FLOOR", self.vector("ADD", p, (1e-6,) * 3)))
        cells = self.math("ADD", x, y)
        if space != "uv":
            cells = self.math("ADD", cells, z)
        odd = self.math("MULTIPLY", self.math("FRACT", self.math("MULTIPLY", cells, 0.5)), 2.0)
        return self.blend(a, b, odd)

    def along(self, space, form, start, axis):
        """How far a point lies along an axis, or from its start."""
        p = self.vector("SUBTRACT", self.coordinates(space), start)
        if form == "radial":
            return self.math("DIVIDE", self.vector("LENGTH", p, output="Value"),
                             math.sqrt(dot(axis, axis)))
        return self.math("DIVIDE", self.dot(p, axis), dot(axis, axis))

    def gradient(self, colors, positions, wrap, t):
        if wrap == "repeat":
            t = self.math("FRACT", t)
        elif wrap == "mirror":
            t = self.math("PINGPONG", t, 1.0)
        color = colors[0]
        for i in range(1, len(colors)):
            low, high = positions[i - 1], positions[i]
            if high > low:
                part = self.clamp(self.math("DIVIDE", self.math("SUBTRACT", t, low), high - low))
            else:  # an edge
                part = self.math("SUBTRACT", 1.0, self.math("LESS_THAN", t, high))
            step = add(colors[i], colors[i - 1], -1)
            color = self.vector("ADD", color, self.scaled(step, part))
        return color

    def noise(self, a, b, space, scale, octaves):
        value = self.put("ShaderNodeTexNoise", {"Vector": self.coordinates(space), "Scale": scale,
                                                "Detail": octaves - 1.0}, "Fac")
        return self.blend(a, b, value)

    def blend(self, a, b, weight):
        keep = self.math("SUBTRACT", 1.0, weight)
        return self.vector("ADD", self.scaled(a, keep), self.scaled(b, weight))

    def scaled(self, a, k):
        node = self.node("ShaderNodeVectorMath", operation="SCALE")
        self.set(node.inputs[0], a)
        self.set(node.inputs["Scale"], k)
        return node.outputs[0]

    def image(self, file, linear, nearest, extension, scale=(1, 1), offset=(0, 0)):
        p = self.vector("MULTIPLY", self.coordinates("uv"), (*scale, 1))
        p = self.vector("ADD", p, (*offset, 0))
        return self.picture("ShaderNodeTexImage", file, linear, p,
                            interpolation="Closest" if nearest else "Linear", extension=extension)

    def picture(self, kind, file, linear, p, **settings):
        image = bpy.data.images.load(file, check_existing=True)
        if linear is not None:
            image.colorspace_settings.name = "Non-Color" if linear else "sRGB"
        return self.put(kind, {"Vector": p}, "Color", image=image, **settings)

    def vertex_color(self):
        # "color" would be the object's own.
        return self.put("ShaderNodeAttribute", {}, "Color", attribute_name="vertex_color")

    def tangent(self):
        """dp/du, in the world."""
        p = self.put("ShaderNodeAttribute", {}, "Vector", attribute_name="tangent")
        return self.put("ShaderNodeVectorTransform", {"Vector": p}, vector_type="VECTOR",
                        convert_from="OBJECT", convert_to="WORLD")

    # What a surface is seen from.

    def back(self):
        return self.put("ShaderNodeNewGeometry", {}, "Backfacing")

    def front(self):
        return self.math("SUBTRACT", 1.0, self.back())

    def cosine(self):
        geometry = self.node("ShaderNodeNewGeometry")
        return self.math("ABSOLUTE", self.dot(geometry.outputs["Incoming"],
                                              geometry.outputs["Normal"]))

    # Materials: each gives a shader.

    def diffuse(self, color):
        return self.put("ShaderNodeBsdfDiffuse", {"Color": color, "Roughness": 0.0})

    def black(self):
        return self.diffuse((0, 0, 0))

    def emission(self, color, strength=1.0):
        return self.put("ShaderNodeEmission", {"Color": color, "Strength": strength})

    def sum(self, a, b):
        node = self.node("ShaderNodeAddShader")
        self.set(node.inputs[0], a)
        self.set(node.inputs[1], b)
        return node.outputs[0]

    def mix(self, a, b, weight):
        node = self.node("ShaderNodeMixShader")
        self.set(node.inputs[0], weight)
        self.set(node.inputs[1], a)
        self.set(node.inputs[2], b)
        return node.outputs[0]

    def emissive(self, radiance, base, two_sided=False):
        side = self.back if self.turned else self.front
        shine = self.emission(radiance, 1.0 if two_sided else side())
        return self.sum(shine, base) if base else shine

    def two_sided(self, front, back):
        """front(n), and back(n), where what is emissive shines backwards."""
        a = front(self)
        self.turned = not self.turned
        b = back(self)
        self.turned = not self.turned
        return self.mix(a, b, self.back())

    def mask(self, opacity, base):
        return self.mix(self.put("ShaderNodeBsdfTransparent", {"Color": (1, 1, 1)}), base, opacity)

    def principled(self, inputs, distribution="GGX"):
        """The Principled shader with all lobes off that `inputs` don't name."""
        node = self.node("ShaderNodeBsdfPrincipled", distribution=distribution.replace(
            "MULTI_GGX", "MULTISCATTER_GGX" if bpy.app.version >= (4, 0) else "MULTI_GGX"))
        off = {"Specular": 0.0, "Specular IOR Level": 0.0, "Sheen": 0.0, "Sheen Weight": 0.0,
               "Clearcoat": 0.0, "Coat Weight": 0.0, "Emission Strength": 0.0, "Metallic": 0.0,
               "Transmission": 0.0, "Transmission Weight": 0.0, "Subsurface": 0.0,
               "Subsurface Weight": 0.0, "Alpha": 1.0, "Specular Tint": 0.0}
        for name, value in {**off, **inputs}.items():
            if name in node.inputs and not (name in off and node.inputs[name].type == "RGBA"):
                self.set(node.inputs[name], value)
        return node.outputs[0]

    def burley(self, color, roughness):
        """The Principled shader's diffuse lobe is Burley's (until Blender 3.6)."""
        return self.principled({"Base Color": color, "Roughness": roughness})

    def roughness(self, alpha):
        """Cycles squares its roughness."""
        return self.math("SQRT", alpha) if isinstance(alpha, bpy.types.NodeSocket) \
            else math.sqrt(alpha)

    def mirror(self, color):
        try:
            return self.put("ShaderNodeBsdfGlossy", {"Color": color}, distribution="SHARP")
        except TypeError:  # from Blender 4.0 on that is roughness 0
            return self.put("ShaderNodeBsdfGlossy", {"Color": color, "Roughness": 0.0})

    def ggx(self, color, alpha, rotation=0.0, distribution="GGX"):
        """A constant reflectance. A pair is alpha along the tangent and across it."""
        if not isinstance(alpha, tuple):
            return self.put("ShaderNodeBsdfGlossy",
                            {"Color": color, "Roughness": self.roughness(alpha)},
                            distribution=distribution)
        roughness, anisotropy = self.anisotropy(alpha)
        return self.put("ShaderNodeBsdfAnisotropic",
                        {"Color": color, "Roughness": roughness, "Anisotropy": anisotropy,
                         "Rotation": self.turns(rotation), "Tangent": self.tangent()},
                        distribution=distribution)

    def anisotropy(self, alpha):
        """Cycles: alpha = r^2 (1 - a), r^2 / (1 - a) where a > 0; r^2 / (1 + a), r^2 (1 + a)."""
        x, y = alpha
        a = 1 - math.sqrt(x / y) if x <= y else math.sqrt(y / x) - 1
        return math.sqrt(math.sqrt(x * y)), a

    def turns(self, angle):
        return self.math("DIVIDE", angle, 2 * math.pi) \
            if isinstance(angle, bpy.types.NodeSocket) else angle / (2 * math.pi)

    def principled_ggx(self, inputs, alpha, rotation, distribution):
        if isinstance(alpha, tuple):
            # Principled: aspect = sqrt(1 - 0.9 anisotropic), alpha = r^2 / aspect, r^2 aspect.
            x, y = alpha
            if x < y:  # its long axis is the tangent's
                x, y, rotation = y, x, self.math("ADD", rotation, math.pi / 2)
            inputs = {**inputs, "Anisotropic": (1 - y / x) / 0.9,
                      "Anisotropic Rotation": self.turns(rotation), "Tangent": self.tangent()}
            alpha = math.sqrt(x * y)
        return self.principled({**inputs, "Roughness": self.roughness(alpha)},
                               distribution=distribution)

    def ggx_ior(self, ior, alpha, rotation=0.0, distribution="GGX"):
        """Exact Fresnel in every microfacet: the Principled shader's specular lobe."""
        if "Specular" in self.node_inputs("ShaderNodeBsdfPrincipled"):
            inputs = {"Specular": self.math("DIVIDE", self.f0(ior), 0.08)}
        else:
            inputs = {"IOR": ior, "Specular IOR Level": 0.5}
        return self.principled_ggx({"Base Color": (0, 0, 0), **inputs}, alpha, rotation,
                                   distribution)

    def ggx_tinted(self, f0, alpha, rotation=0.0, distribution="GGX"):
        """A reflectance that rises towards white at grazing angles: the Principled shader's
        metal."""
        return self.principled_ggx({"Base Color": f0, "Metallic": 1.0, "Specular": 0.5,
                                    "Specular IOR Level": 0.5}, alpha, rotation, distribution)

    def node_inputs(self, kind):
        node = self.node(kind)
        names = set(node.inputs.keys())
        self.tree.nodes.remove(node)
        return names

    def f0(self, ior):
        root = self.math("DIVIDE", self.math("SUBTRACT", ior, 1.0), self.math("ADD", ior, 1.0))
        return self.math("MULTIPLY", root, root)

    def conductor(self, eta, k, cosine):
        """A metal's exact reflectance, by Fresnel's equations for a complex index."""
        c2 = self.math("MULTIPLY", cosine, cosine)
        s2 = self.math("SUBTRACT", 1.0, c2)
        channels = []
        for n, x in zip(self.channels(eta), self.channels(k)):
            n2, x2 = self.math("MULTIPLY", n, n), self.math("MULTIPLY", x, x)
            t0 = self.math("SUBTRACT", self.math("SUBTRACT", n2, x2), s2)
            root = self.math("SQRT", self.math(
                "ADD", self.math("MULTIPLY", t0, t0),
                self.math("MULTIPLY", self.math("MULTIPLY", n2, x2), 4.0)))
            a = self.math("SQRT", self.math("MAXIMUM", self.math(
                "MULTIPLY", self.math("ADD", root, t0), 0.5), 0.0))
            t1 = self.math("ADD", root, c2)
            t2 = self.math("MULTIPLY", self.math("MULTIPLY", a, cosine), 2.0)
            rs = self.math("DIVIDE", self.math("SUBTRACT", t1, t2), self.math("ADD", t1, t2))
            t3 = self.math("ADD", self.math("MULTIPLY", c2, root), self.math("MULTIPLY", s2, s2))
            t4 = self.math("MULTIPLY", t2, s2)
            rp = self.math("MULTIPLY", rs, self.math(
                "DIVIDE", self.math("SUBTRACT", t3, t4), self.math("ADD", t3, t4)))
            channels.append(self.math("MULTIPLY", self.math("ADD", rs, rp), 0.5))
        return self.join(*channels)

    def schlick_dielectric(self, ior):
        """Schlick's approximation, the cosine taken in the thinner medium; 1 beyond the critical
        angle."""
        f0 = ((ior - 1) / (ior + 1)) ** 2
        c, inside = self.cosine(), self.back() if ior > 1 else self.front()
        ratio = max(ior, 1 / ior)
        sine2 = self.math("MULTIPLY", self.math(
            "SUBTRACT", 1.0, self.math("MULTIPLY", c, c)), ratio * ratio)
        outer = self.math("SQRT", self.math("MAXIMUM", self.math("SUBTRACT", 1.0, sine2), 0.0))
        difference = self.math("SUBTRACT", outer, c)
        thinner = self.math("ADD", c, self.math("MULTIPLY", inside, difference))
        power = self.math("POWER", self.math("SUBTRACT", 1.0, thinner), 5.0)
        return self.math("ADD", f0, self.math("MULTIPLY", power, 1 - f0))

    def glass(self, ior, color=(1, 1, 1), alpha=0.0, absorption=None, schlick=False):
        """The reflection is white, what passes is tinted."""
        smooth = not isinstance(alpha, bpy.types.NodeSocket) and alpha < 1e-4
        factor = self.schlick_dielectric(ior) if schlick else \
            self.put("ShaderNodeFresnel", {"IOR": ior})
        if smooth:
            reflected = self.mirror((1, 1, 1))
            try:
                passing = self.put("ShaderNodeBsdfRefraction", {"Color": color, "IOR": ior},
                                   distribution="SHARP")
            except TypeError:
                passing = self.put("ShaderNodeBsdfRefraction",
                                   {"Color": color, "IOR": ior, "Roughness": 0.0})
        else:
            roughness = self.roughness(alpha)
            reflected = self.ggx((1, 1, 1), alpha)
            passing = self.put("ShaderNodeBsdfRefraction",
                               {"Color": color, "IOR": ior, "Roughness": roughness},
                               distribution="GGX")
        if absorption:
            most = max(absorption)
            self.volume = self.put("ShaderNodeVolumeAbsorption", {
                "Color": tuple(1 - a / most for a in absorption), "Density": most})
        return self.mix(passing, reflected, factor)

    def coated(self, base, ior, alpha):
        smooth = not isinstance(alpha, bpy.types.NodeSocket) and alpha < 1e-4
        coat = self.mirror((1, 1, 1)) if smooth else self.ggx((1, 1, 1), alpha)
        return self.mix(base, coat, self.put("ShaderNodeFresnel", {"IOR": ior}))

    def bent(self, base, normal):
        """`base` with another normal, wherever it takes one."""
        done = set()

        def visit(socket):
            node = socket.node
            if node in done:
                return
            done.add(node)
            for incoming in node.inputs:
                if incoming.name == "Normal" and incoming.type == "VECTOR" and not incoming.links:
                    self.tree.links.new(normal, incoming)
                elif incoming.type == "SHADER":
                    for step in incoming.links:
                        visit(step.from_socket)

        visit(base)
        return base

    def normal_map(self, base, color, strength):
        r, g, b = self.parts(color)
        half = [self.math("MULTIPLY_ADD", self.math("SUBTRACT", c, 0.5), strength, 0.5)
                for c in (r, g)]
        normal = self.put("ShaderNodeNormalMap", {"Color": self.join(*half, b), "Strength": 1.0},
                          space="TANGENT", uv_map="uv")
        return self.bent(base, normal)

    def bump_map(self, base, height, strength):
        normal = self.put("ShaderNodeBump", {"Height": height, "Distance": strength,
                                             "Strength": 1.0}, "Normal")
        return self.bent(base, normal)

    # Lights: factors of the intensity.

    def distance(self):
        """(r^2, r), both relative to Cycles' own 1 / r^2."""
        node = self.node("ShaderNodeLightFalloff")
        self.set(node.inputs["Strength"], 1.0)
        self.set(node.inputs["Smooth"], 0.0)
        return node.outputs["Constant"], node.outputs["Linear"]

    def constant(self):
        return self.distance()[0]

    def polynomial(self, a, b, c):
        r2, r = self.distance()
        down = self.math("ADD", self.math("MULTIPLY_ADD", r, b, a), self.math("MULTIPLY", r2, c))
        return self.math("DIVIDE", r2, down)

    def window(self, start, end):
        r2, r = self.distance()
        part = self.clamp(self.math("DIVIDE", self.math("SUBTRACT", r, start), end - start))
        left = self.math("SUBTRACT", 1.0, part)
        return self.math("MULTIPLY", r2, self.math("MULTIPLY", left, left))

    def emitted(self):
        """The direction from the light to what it lights, in the light's space; its axis is -z."""
        return self.put("ShaderNodeTexCoord", {}, "Normal")

    def axis_cosine(self):
        return self.math("MULTIPLY", self.parts(self.emitted())[2], -1.0)

    def cosine_lobe(self, exponent):
        return self.math("POWER", self.math("MAXIMUM", self.axis_cosine(), 0.0), exponent)

    def smooth_cone(self, inner, outer):
        # The angle by its tangent: arccos is coarse near the axis.
        x, y, z = self.parts(self.emitted())
        across = self.math("SQRT", self.math(
            "ADD", self.math("MULTIPLY", x, x), self.math("MULTIPLY", y, y)))
        angle = self.math("ARCTAN2", across, self.math("MULTIPLY", z, -1.0))
        left = self.clamp(self.math("DIVIDE", self.math("SUBTRACT", outer, angle), outer - inner))
        return self.math("MULTIPLY", left, left)

    def photometric(self, text, largest, mirrored):
        """Candelas of a table. Cycles' IES texture gives 4 pi / 177.83 for each."""
        direction = self.vector("MULTIPLY", self.emitted(), (1.0 if mirrored else -1.0, 1.0, 1.0))
        data = bpy.data.texts.new("luminaire.ies")
        data.write(text)
        table = self.put("ShaderNodeTexIES", {"Vector": direction, "Strength": 1.0}, mode="INTERNAL",
                         ies=data)
        return self.math("MULTIPLY", table, largest / 1000 / 0.0706650768394)


def material(name, build):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = Nodes(made.node_tree)
    surface = build(nodes)
    output = nodes.node("ShaderNodeOutputMaterial")
    nodes.set(output.inputs["Surface"], surface)
    if nodes.volume:
        nodes.set(output.inputs["Volume"], nodes.volume)
    nodes.layout()
    return made


@functools.lru_cache(maxsize=None)
def use(build):
    """The material of a material_N(n), made once."""
    return material(build.title, build)


def lamp(name, radiance, base=None, two_sided=False):
    """A shape of an area_light: radiance(n) in W/(m^2 sr)."""
    return material(name, lambda n: n.emissive(radiance(n), base(n) if base else n.black(),
                                               two_sided))


def radiance_of(power, data, matrix, sides):
    """Of watts that a surface emits evenly."""
    return times(power, 1 / (math.pi * area_of(data, matrix) * sides))


@functools.lru_cache(maxsize=None)
def default_material():
    return material("lambert {}", lambda n: n.diffuse((0.5, 0.5, 0.5)))


# --- Lights ----------------------------------------------------------------------------------------


def light(into, kind, name, matrix, color, factors, shadows):
    """`factors(n)` gives a list of what the color is multiplied by."""
    data = bpy.data.lights.new(name, kind)
    data.use_nodes = True
    data.use_shadow = shadows
    if hasattr(data.cycles, "cast_shadow"):
        data.cycles.cast_shadow = shadows
    nodes = Nodes(data.node_tree)
    most = max(max(color), 1e-30)
    strength = most
    for factor in factors(nodes) if factors else ():
        strength = nodes.math("MULTIPLY", factor, strength)
    output = nodes.node("ShaderNodeOutputLight")
    nodes.set(output.inputs["Surface"],
              nodes.emission(tuple(c / most for c in color), strength))
    nodes.layout()
    thing = bpy.data.objects.new(name, data)
    link(into, thing)
    put(thing, matrix)
    return data


def point_light(into, name, position, intensity, factors=None, shadows=True,
                axes=((1, 0, 0), (0, 1, 0), (0, 0, 1))):
    """Intensity in W/sr; `axes`, in the scene, are the light's own: it looks along -z."""
    x, y, z = axes
    m = Matrix(((x[0], y[0], z[0], position[0]), (x[1], y[1], z[1], position[1]),
                (x[2], y[2], z[2], position[2]), (0, 0, 0, 1)))
    data = light(into, "POINT", name, TO_BLENDER @ m, intensity, factors, shadows)
    data.energy = 4 * math.pi  # Cycles: W/sr = energy / 4 pi
    data.shadow_soft_size = 0


def spot_light(into, name, position, axis, intensity, factors, shadows=True):
    """The whole beam is in `factors`: Cycles' own spot has another edge."""
    z = times(axis, -1)
    x, y = frame(z)
    point_light(into, name, position, intensity, factors, shadows, (x, y, z))


def directional_light(into, name, direction, irradiance, angle=0.0, shadows=True):
    z = times(direction, -1)
    x, y = frame(z)
    m = Matrix((*zip(x, y, z), )).to_4x4()
    half, wide = angle / 2, 1
    if 0 < half < math.pi / 2 and bpy.app.version < (3, 6):
        # Cycles' disc lies in a plane and is brighter towards its rim: it gives
        # 2 (1 - cos)/(cos tan^2) of the irradiance asked for.
        wide = math.cos(half) * math.tan(half) ** 2 / (2 * (1 - math.cos(half)))
    data = light(into, "SUN", name, TO_BLENDER @ m, times(irradiance, wide), None, shadows)
    data.energy = 1
    data.angle = angle


def surroundings(build):
    world = bpy.data.worlds.new("surroundings")
    world.use_nodes = True
    nodes = Nodes(world.node_tree)
    output = nodes.node("ShaderNodeOutputWorld")
    nodes.set(output.inputs["Surface"], build(nodes))
    nodes.layout()
    SCENE.world = world


def background(n, color, file=None, rotation=0.0, axes=None, linear=None, texture=None):
    """Surroundings of a color, or a picture (or a texture(n)) times a color. `axes` are the rows of
    a rotation from the world."""
    if file:
        # Blender's u is 1/2 - atan2(y, x) / 2 pi, the scene's 1/2 + atan2(x, -z) / 2 pi.
        d = n.put("ShaderNodeTexCoord", {}, "Generated")
        x, y, z = n.parts(d)
        d = n.join(x, z, n.math("MULTIPLY", y, -1.0))  # in the scene
        if axes:
            d = n.join(*(n.dot(d, axis) for axis in axes))
        d = n.put("ShaderNodeVectorRotate", {"Vector": d, "Angle": -rotation},
                  rotation_type="Y_AXIS")
        x, y, z = n.parts(d)
        d = n.join(n.math("MULTIPLY", z, -1.0), n.math("MULTIPLY", x, -1.0), y)
        color = n.vector("MULTIPLY", n.picture("ShaderNodeTexEnvironment", file, linear, d), color)
    return n.put("ShaderNodeBackground", {"Color": color, "Strength": 1.0})


# --- Camera, film, render --------------------------------------------------------------------------


def camera(name, matrix, projection, fov=0.0, height=0.0, aperture=0.0, focus=1.0):
    """`matrix` has the camera's axes in the scene: right, up, back."""
    data = bpy.data.cameras.new(name)
    data.sensor_fit = "VERTICAL"
    data.clip_start, data.clip_end = 1e-5, 1e7
    panorama = data if hasattr(data, "panorama_type") else data.cycles
    if projection == "orthographic":
        data.type = "ORTHO"
        data.ortho_scale = height
    elif projection == "perspective":
        data.lens = 50
        data.sensor_height = 100 * math.tan(fov / 2)
    elif projection == "fisheye":
        data.type = "PANO"
        panorama.panorama_type = "FISHEYE_EQUIDISTANT"
        panorama.fisheye_fov = fov
    else:
        data.type = "PANO"
        panorama.panorama_type = "EQUIRECTANGULAR"
    if aperture > 0:
        data.dof.use_dof = True
        data.dof.focus_distance = focus
        data.dof.aperture_fstop = data.lens / 1000 / (2 * aperture)
        data.dof.aperture_blades = 0
    thing = bpy.data.objects.new(name, data)
    link(None, thing)
    thing.matrix_world = TO_BLENDER @ scene_matrix(matrix)
    SCENE.camera = thing


def film(width, height, filter_type, filter_width, exposure):
    SCENE.render.resolution_x, SCENE.render.resolution_y = width, height
    SCENE.render.resolution_percentage = 100
    SCENE.cycles.pixel_filter_type = filter_type
    SCENE.cycles.filter_width = filter_width
    SCENE.view_settings.view_transform = "Standard"
    SCENE.view_settings.exposure = exposure


def render_settings(samples, seed, bounces, diffuse_bounces, clamp):
    """Everything that biases Cycles is off, unless the scene asks for it."""
    SCENE.render.engine = "CYCLES"
    cycles = SCENE.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.diffuse_bounces = diffuse_bounces
    cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct, cycles.sample_clamp_indirect = 0, clamp
    cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True


# --- The command line ------------------------------------------------------------------------------


def options():
    """What stands behind "--": {"output": …}."""
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    names = ("--output", "--samples", "--seeds", "--size", "--threads")
    if len(given) % 2 or any(name not in names for name in given[::2]):
        sys.exit("usage: blender -b -P " + os.path.basename(__file__) + " -- [--output FILE.exr] "
                 "[--samples N] [--seeds N,…] [--size WxH] [--threads N]\n"
                 "  with several seeds, the file's name must hold \"{seed}\"")
    return {name[2:]: value for name, value in zip(given[::2], given[1::2])}


def render(given):
    """Renders a linear OpenEXR picture of 32-bit floats for each seed."""
    settings = SCENE.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGB"
    settings.exr_codec = "ZIP"
    if "samples" in given:
        SCENE.cycles.samples = int(given["samples"])
    if "size" in given:
        SCENE.render.resolution_x, SCENE.render.resolution_y = map(int, given["size"].split("x"))
    if "threads" in given:
        SCENE.render.threads_mode, SCENE.render.threads = "FIXED", int(given["threads"])
    SCENE.render.use_persistent_data = True
    for seed in given.get("seeds", str(SCENE.cycles.seed)).split(","):
        SCENE.cycles.seed = int(seed)
        SCENE.render.filepath = os.path.abspath(given["output"].replace("{seed}", seed))
        start = time.time()
        bpy.ops.render.render(write_still=True, scene=SCENE.name)
        print(f"seed {seed}: {time.time() - start:.3f} seconds", flush=True)


def main(name, build):
    global SCENE
    given = options() if bpy.app.background else {}
    SCENE = bpy.data.scenes.new(name)
    if bpy.context.window:
        bpy.context.window.scene = SCENE
    build()
    if "output" in given:
        render(given)


