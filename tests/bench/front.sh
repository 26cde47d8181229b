#!/bin/sh
# What the front end costs: a million spheres from a nested loop and as literal statements, beside
# POV-Ray 3.7 on the same scenes, alternating. Prints seconds of processor time and peak memory.
# Usage: tests/bench/front.sh [RUNS]   (needs the package povray; scnrender is built if need be)
set -eu
cd "$(dirname "$0")/../.."
runs=${1:-3}
here=$PWD
command -v povray >/dev/null || { echo "needs povray: apt-get install povray" >&2; exit 1; }
tools/build release >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp tests/bench/front_loop.scn tests/bench/front_loop.pov "$work"

# The same spheres as literal statements.
awk -v scn="$work/front_flat.scn" -v pov="$work/front_flat.pov" 'BEGIN {
    print "camera { position: (50, 60, -40), look_at: (50, 0, 50) }\nlet clay = lambert { color: rgb(0.8, 0.5, 0.3) }" > scn
    print "#version 3.7;\nglobal_settings { assumed_gamma 1 }\ncamera { location <50, 60, 40> look_at <50, 0, -50> }\n" \
          "#declare Clay = texture { pigment { rgb <0.8, 0.5, 0.3> } finish { ambient 0 diffuse 1 } };" > pov
    for (i = 0; i < 1000; ++i) for (j = 0; j < 1000; ++j) {
        y = sin(i * 0.05) * sin(j * 0.05); r = 0.02 + 0.01 * ((i + j) % 3)
        printf "sphere { center: (%.1f, %.8f, %.1f), radius: %.2f, material: clay }\n", i / 10, y, j / 10, r > scn
        printf "sphere { <%.1f, %.8f, %.1f>, %.2f texture { Clay } }\n", i / 10, y, -j / 10, r > pov
    }
    print "point_light { position: (50, 80, 0), intensity: 6000 }" > scn
    print "light_source { <50, 80, 0> rgb 1 }" > pov
}'
ls -l "$work" | awk 'NR > 1 { print $NF, $5, "bytes" }'

measure() { # name command…
    name=$1
    shift
    /usr/bin/time -f "%U %S %e %M" -o "$work/time" "$@" >"$work/out" 2>&1 || { cat "$work/out"; exit 1; }
    awk -v name="$name" '{ printf "%-28s cpu %6.2f s  wall %6.2f s  peak %7.1f MB\n", name, $1 + $2, $3, $4 / 1024 }' "$work/time"
}
cd "$work"
for run in $(seq "$runs"); do
    for scene in front_loop front_flat; do
        measure "scnrender check $scene" "$here/build/release/bin/scnrender" check $scene.scn
        # One pixel and no light to speak of: POV-Ray's time is its parsing.
        measure "povray parse $scene" povray +I$scene.pov +O/dev/null +W1 +H1 -D -V -GA +WT1
    done
done
