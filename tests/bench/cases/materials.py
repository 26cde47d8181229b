# Cycles mixes coat and base by Fresnel's factor, without the second crossing of the coat and what is
# reflected below it. A base of another color gives the same mean: with 0.908 of the light let in by the
# coat from outside and 0.596 of it reflected from inside (ior 1.5), a base of albedo a looks as one of
# 0.908 a / (n^2 (1 - 0.596 a)) would.
plain_coated = Nodes.coated


def coated(self, base, ior, alpha):
    color = base.node.inputs["Color"]
    seen = [0.908 * a / (ior ** 2 * (1 - 0.596 * a)) for a in color.default_value[:3]]
    color.default_value = (*seen, 1)
    return plain_coated(self, base, ior, alpha)


Nodes.coated = coated
