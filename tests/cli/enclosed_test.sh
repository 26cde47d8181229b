# Lights inside what they can't shine out of: a warning, at the light and at the shape (W0902).
. "$SOURCE_DIR/tests/cli/support.sh"
cat >enclosed.scn <<'END'
sphere { radius: 1 }
torus { center: (5, 0, 0), major_radius: 1, minor_radius: 0.3, transform: translate(1, 0, 0) }
box { min: (9, -1, -1), max: (11, 1, 1), material: fresnel {} }
cylinder { from: (20, 0, 0), to: (20, 2, 0), radius: 1, caps: false }
point_light { position: (0, 0.5, 0), intensity: 1 }
point_light { position: (7, 0.1, 0), intensity: 1 }
point_light { position: (0.1, 0.1, 0), intensity: 1, transform: translate(6, 0, 0) } // the torus' hole
point_light { position: (10, 0, 0), intensity: 1 }                                   // in glass
point_light { position: (20, 1, 0), intensity: 1 }                                   // in an open pipe
END
run check enclosed.scn
expect_code 0
expect_text err "enclosed.scn:5:1"
expect_text err "this light lies inside an opaque sphere"
expect_text err "enclosed.scn:6:1"
expect_text err "this light lies inside an opaque torus"
expect_text err "2 warnings"
run enclosed.scn -o enclosed.png --size 8x8 --samples 1
expect_code 0
expect_text err "this light lies inside an opaque sphere"
finish
