# The exported scene has one tree. A point for each of all, with its size and turn, and "Instance on
# Points": Blender's leanest way to have a million.
ROWS = int(JOB["params"]["rows"])


def chance(i, k):
    x = math.sin(i * 12.9898 + k * 78.233) * 43758.5453
    return x - math.floor(x)


def trees():
    points, turns, sizes = array.array("f"), array.array("f"), array.array("f")
    for i in range(ROWS):
        for j in range(ROWS):
            k = i * ROWS + j
            x, z = 3 * (j - ROWS / 2) + 2 * chance(k, 22), 30 - 3 * i + 2 * chance(k, 23)
            points.extend((x, -z, 0))
            turns.extend((0, 0, 2 * math.pi * chance(k, 21)))
            sizes.append(0.7 + 0.6 * chance(k, 20))
    mesh = bpy.data.meshes.new("places")
    mesh.vertices.add(ROWS * ROWS)
    mesh.vertices.foreach_set("co", points)
    mesh.attributes.new("turn", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turns)
    mesh.attributes.new("size", "FLOAT", "POINT").data.foreach_set("value", sizes)
    return mesh


def instance(make, name, material, matrix):
    """All trees in place of the one."""
    tree = make(bpy.data.collections.new("tree"), material).objects[0]
    forest = bpy.data.objects.new("forest", trees())
    link(None, forest)
    group = bpy.data.node_groups.new("forest", "GeometryNodeTree")
    group.inputs.new("NodeSocketGeometry", "Geometry")
    group.outputs.new("NodeSocketGeometry", "Geometry")
    nodes, links = group.nodes, group.links
    source, result = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    info = nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = tree
    info.inputs["As Instance"].default_value = True
    place = nodes.new("GeometryNodeInstanceOnPoints")
    for field, kind, socket in (("turn", "FLOAT_VECTOR", "Rotation"), ("size", "FLOAT", "Scale")):
        value = nodes.new("GeometryNodeInputNamedAttribute")
        value.data_type = kind
        value.inputs["Name"].default_value = field
        output = next(o for o in value.outputs if o.enabled and o.name == "Attribute")
        links.new(output, place.inputs[socket])
    links.new(source.outputs[0], place.inputs["Points"])
    links.new(info.outputs["Geometry"], place.inputs["Instance"])
    links.new(place.outputs[0], result.inputs[0])
    forest.modifiers.new("forest", "NODES").node_group = group
