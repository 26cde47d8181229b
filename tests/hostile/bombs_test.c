// Short scenes that ask for very much: loops, recursion, lists and texts that double, instances of
// instances, pictures and meshes that declare enormous sizes. Each ends within a second of the
// processor (the last line has the longest) and MOST_MIB of memory, in the diagnostic that is
// named.
//     bombs_test PROGRAM FOLDER [N]    FOLDER: where the scenes are written; N: each Nth only
#include "program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The evaluator's own limit (--limit memory=N) is 1 GiB; the rest is the program, the text and the
// scene.
enum { MOST_MIB = 1536 };
static const double most_seconds = 4; // a second, on a machine that is four times slower than ours

typedef struct Bomb {
    const char *name;
    const char *says; // a piece of standard error; "" where the scene may be fine
    const char *text; // of the scene
} Bomb;

// What the scenes below have in common.
#define DOUBLE  "fn double(x, n) = if (n == 0) x else double(concat(x, x), n - 1)\n"
#define LONG    "fn long(s, n) = if (n == 0) s else long(s + s, n - 1)\n"
#define LISTS   "fn lists(x, n) = if (n == 0) x else lists([x, x], n - 1)\n"
#define BILLION "1_000_000_000"
#define STEPS   "[E0708]: more than 10000000 steps"
#define MEMORY  "[E0709]: evaluation needs more than 1073741824 bytes of memory"

static const Bomb bombs[] = {
    // Loops.
    {"a_long_loop", "[E0706]: a range of 1000000000 items is too long",
     "for (i in 0..<" BILLION ") { }"},
    {"loop_in_loop", STEPS, "for (i in 0..<9_000_000) { for (k in 0..<9_000_000) { } }"},
    {"loops_of_lets", STEPS,
     "for (i in 0..<10_000) { for (k in 0..<10_000) { let a = sin(i) * cos(k) } }"},
    {"loop_of_spheres", STEPS, "for (i in 0..<9_000_000) { sphere {} sphere {} }"},
    {"loop_of_lights", STEPS,
     "for (i in 0..<9_000_000) { point_light { position: (i, 1, 1) power: 1W } }"},
    {"loop_of_materials", "error",
     "for (i in 0..<9_000_000) { sphere { material: lambert { color: gray(i / 9_000_000) } } }"},
    {"loop_of_transforms", "error",
     "for (i in 0..<9_000_000) { sphere { transform: [translate(i, 0, 0), rotate_x(i * 1deg)] } }"},
    {"loop_of_names", STEPS, "for (i in 0..<9_000_000) { sphere { name: str(i, \"a\", i) } }"},
    {"loop_of_groups", "error",
     "for (i in 0..<9_000_000) { group { sphere {} group { sphere {} } } }"},
    {"loop_of_prints", STEPS, "for (i in 0..<9_000) { for (k in 0..<9_000) { print(\"hello\") } }"},
    {"loop_of_asserts", STEPS, "for (i in 0..<9_000) { for (k in 0..<9_000) { assert(true) } }"},
    {"loop_of_errors", STEPS, "for (i in 0..<9_000_000) { sphere { radius: -1 } }"},
    {"list_of_loops", "error", "let a = [for (i in 0..<9_000_000) for (k in 0..<9_000_000) 1]"},
    {"list_of_lists", "error", "let a = [for (i in 0..<9_000_000) [for (k in 0..<9_000_000) 1]]"},
    {"loop_with_condition", STEPS,
     "let a = [for (i in 0..<9_000_000) for (k in 0..<9_000_000) if (k < 0) 1]"},
    {"list_of_vectors", "", "let a = [for (i in 0..<9_000_000) (i, i, i)]"},
    {"list_of_functions", "", "let a = [for (i in 0..<9_000_000) fn(x) = x + i]"},
    {"list_of_kinds", "error", "let a = [for (i in 0..<9_000_000) sphere { radius: 1 + i }]"},
    // Recursion.
    {"forever", "[E0703]", "fn f(n) = f(n + 1)\nlet a = f(1)"},
    {"twice", STEPS, "fn f(n) = if (n == 0) 1 else f(n - 1) + f(n - 1)\nlet a = f(100)"},
    {"fibonacci", STEPS, "fn f(n) = if (n < 2) n else f(n - 1) + f(n - 2)\nlet a = f(90)"},
    {"ackermann", "error",
     "fn f(m, n) = if (m == 0) n + 1 else if (n == 0) f(m - 1, 1) else f(m - 1, f(m, n - 1))\n"
     "let a = f(4, 4)"},
    {"mutual", "[E0703]", "fn f(n) = g(n)\nfn g(n) = f(n)\nlet a = f(1)"},
    {"by_map", "[E0703]", "fn f(n) = map([n, n], f)\nlet a = f(1)"},
    {"by_fold", "[E0703]", "fn f(n, m) = fold([n, n], m, f)\nlet a = f(1, 1)"},
    {"by_sort", "[E0703]", "fn f(n) = len(sort([n, n], f))\nlet a = f(1)"},
    {"by_filter", "[E0703]", "fn f(n) = len(filter([n, n], f)) > 0\nlet a = f(1)"},
    {"groups_of_groups", STEPS,
     "fn f(n) = if (n == 0) group { sphere {} } else group { f(n - 1) f(n - 1) }\nf(60)"},
    {"statements", STEPS, "fn f(n) { if (n > 0) { f(n - 1) f(n - 1) } }\nf(60)"},
    {"closures", "[E0703]",
     "fn twice(f) = fn(x) = f(f(x))\n"
     "let a = twice(twice)(twice)(twice)(twice)(fn(x) = x + 1)(0)"},
    {"cycle_of_lets", "[E0502]", "let a = b\nlet b = c\nlet c = a"},
    {"imports_itself", "error", "import \"scene.scn\" as me\nlet a = 1"},
    // Lists.
    {"doubled_list", "[E0706]", DOUBLE "let a = double([1], 60)"},
    {"range_as_list", "error", "let a = range(0, 1, 1e-300)"},
    {"long_range", "error", "let a = range(9e15)"},
    {"ranges_kept", "error", "let a = [for (i in 0..<1000) range(0, 9_000_000)]"},
    {"sorted_often", STEPS, "let a = [for (i in 0..<1000) sort(range(0, 1_000_000))[0]]"},
    {"reversed_often", "error", "let a = [for (i in 0..<1000) len(reverse(0..<9_000_000))]"},
    {"summed_often", STEPS, "let a = [for (i in 0..<9_000_000) sum(0..<9_000_000)]"},
    {"zipped", "", "let a = zip(zip(0..<9_000_000, 0..<9_000_000), 0..<9_000_000)"},
    {"least_often", STEPS, "let l = range(9_000_000)\nlet a = [for (i in 0..<9_000_000) min(l)]"},
    {"lists_compared", STEPS, LISTS "let a = lists(1, 60)\nlet b = lists(1, 60)\nassert(a == b)"},
    {"lists_written", STEPS, LISTS "print(lists(1, 60))"},
    {"lists_as_text", STEPS, LISTS "let a = str(lists(1, 60))"},
    {"lists_as_param", "error", LISTS "param a: list = lists(1, 60)"},
    {"lists_as_transform", "error", LISTS "sphere { transform: lists(translate(0, 0, 0), 60) }"},
    {"lists_as_items", "error", LISTS "group { items: lists(sphere {}, 60) }"},
    {"lists_as_points", "error",
     LISTS "mesh { vertices: lists((1, 1, 1), 60) faces: lists(1, 60) }"},
    {"list_in_a_message", "error", LISTS "sphere { radius: lists(1, 60) }"},
    {"long_list_in_a_message", "error", "sphere { radius: range(9_000_000) }"},
    {"random_of_many", STEPS,
     "let a = [for (i in 0..<9_000_000) for (k in 0..<9_000_000) random(i, k)]"},
    {"noise_of_many", STEPS,
     "let a = [for (i in 0..<9_000_000) for (k in 0..<9_000_000) noise((i, k))]"},
    // Texts.
    {"doubled_text", "error", LONG "let a = long(\"x\", 60)"},
    {"long_texts_compared", "error",
     LONG "let a = long(\"x\", 24)\nlet b = long(\"x\", 24)\n"
          "let c = [for (i in 0..<9_000_000) a == b]"},
    {"long_texts_ordered", "error",
     LONG "let a = long(\"x\", 24)\nlet b = long(\"x\", 24)\n"
          "let c = [for (i in 0..<9_000_000) a < b]"},
    {"long_texts_sorted", "error",
     LONG "let a = long(\"x\", 24)\nlet c = sort([for (i in 0..<1_000_000) a])"},
    {"long_texts_counted", "error",
     LONG "let a = long(\"x\", 24)\nlet c = [for (i in 0..<9_000_000) len(a)]"},
    {"long_texts_printed", "error",
     LONG "let a = long(\"x\", 24)\nfor (i in 0..<9_000_000) { print(a) }"},
    {"long_texts_joined", "error",
     LONG "let a = long(\"x\", 24)\nlet c = [for (i in 0..<9_000_000) str(a, a)]"},
    {"long_texts_as_names", "error",
     LONG "let a = long(\"x\", 24)\nfor (i in 0..<9_000_000) { sphere { name: a } }"},
    {"long_texts_as_keys", "error",
     LONG "let a = long(\"x\", 24)\nlet c = [for (i in 0..<9_000_000) random(a)]"},
    {"long_text_as_a_file", "error", LONG "mesh { file: long(\"x/\", 24) }"},
    {"long_text_as_a_choice", "error", LONG "render { integrator: long(\"x\", 24) }"},
    {"long_text_as_a_message", "error", LONG "assert(false, long(\"x\", 24))"},
    {"long_text_as_an_object", "error",
     LONG "sphere {}\nexpect radiance(object(long(\"x\", 24))) < 1"},
    {"many_short_texts", STEPS,
     "for (i in 0..<9_000_000) { assert(str(i) + str(i + 1) + \"x\" + str(i) != \"\") }"},
    // Shapes.
    {"doubled_groups", STEPS,
     "fn f(g, n) = if (n == 0) g else f(group { g g }, n - 1)\nf(sphere {}, 60)"},
    {"doubled_instances", "error",
     "fn f(g, n) = if (n == 0) g else f(group { instance { of: g } instance { of: g } }, n - 1)\n"
     "f(sphere {}, 60)"},
    {"instances_of_lights", "error",
     "fn f(g, n) = if (n == 0) g else f(group { instance { of: g } instance { of: g } }, n - 1)\n"
     "f(point_light { power: 1W }, 60)"},
    {"bounds_of_groups", STEPS,
     "fn f(g, n) = if (n == 0) g else f(group { g g }, n - 1)\nlet a = bounds(f(sphere {}, 60))"},
    {"bounds_of_instances", STEPS,
     "fn f(g, n) = if (n == 0) g else f(group { instance { of: g } instance { of: g } }, n - 1)\n"
     "let a = bounds(f(sphere {}, 60))"},
    {"bounds_often", STEPS,
     "let g = group { for (i in 0..<1_000_000) { sphere {} } }\n"
     "let a = [for (i in 0..<9_000_000) bounds(g)]"},
    {"groups_in_groups", "error",
     "fn f(g, n) = if (n == 0) g else f(group { g }, n - 1)\n"
     "f(f(f(f(sphere {}, 900), 900), 900), 900)\nassert(false)"},
    {"withs", STEPS,
     "let s = sphere {}\nfor (i in 0..<9_000_000) { for (k in 0..<9) { s with { radius: 2 } } }"},
    {"copies_of_a_group", STEPS,
     "let g = group { for (i in 0..<100_000) { sphere {} } }\nfor (i in 0..<9_000_000) { g }"},
    // Materials and textures: walked through at each hit.
    {"doubled_material", "[E0712]",
     "fn f(m, n) = if (n == 0) m else f(mix { a: m, b: m }, n - 1)\n"
     "sphere { material: f(lambert {}, 60) }"},
    {"doubled_layers", "[E0712]",
     "fn f(m, n) = if (n == 0) m else f(layered { base: m, coat: m }, n - 1)\n"
     "sphere { material: f(lambert {}, 60) }"},
    {"doubled_texture", "[E0712]",
     "fn f(t, n) = if (n == 0) t else f(t + t, n - 1)\n"
     "sphere { material: lambert { color: f(checker {}, 60) } }"},
    {"chain_of_materials", "[E0712]",
     "fn f(m, n) = if (n == 0) m else f(mix { a: m, b: lambert {} }, n - 1)\n"
     "sphere { material: f(lambert {}, 900) }"},
    {"chain_of_textures", "[E0712]",
     "fn f(t, n) = if (n == 0) t else f(t + checker {}, n - 1)\n"
     "sphere { material: lambert { color: f(checker {}, 900) } }"},
    // Measured values.
    {"doubled_measures", "[E0415]",
     "fn f(m, n) = if (n == 0) m else f(m + m, n - 1)\nexpect f(radiance(), 60) < rgb(1, 1, 1)"},
    {"expectations", "error", "for (i in 0..<9_000_000) { expect luminance(radiance()) < i }"},
    // Sizes.
    {"film", "[E0711]: a picture of 1000000 × 1000000 pixels",
     "film { width: 1_000_000, height: 1_000_000 }"},
    {"wide_film", "[E0404]", "film { width: " BILLION ", height: 1 }"},
    {"samples", "error", "render { samples: 9_000_000_000_000_000_000_000 }"},
    {"huge_number", "error", "let a = 1e999"},
    {"power_tower", "error", "let a = 9 ^ 9 ^ 9 ^ 9"},
    {"tessellation", "error", "sphere { segments: " BILLION " }"},
    {"polygons", "error",
     "mesh { vertices: [for (i in 0..<9_000_000) (i, i, i)] faces: [0..<9_000_000] }"},
    {"faces", "error",
     "mesh { vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
     "faces: [for (i in 0..<9_000_000) [0, 1, 2]] }"},
    {"bad_faces", "error",
     "mesh { vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
     "faces: [for (i in 0..<100_000) [9, 9, 9]] }"},
};

// Files that declare more than they hold.
typedef struct File {
    const char *name, *text;
    const char *bytes;
    size_t size;
} File;
#define FILE_OF(name, text, bytes)                                                                 \
    {                                                                                              \
        name, text, bytes, sizeof bytes - 1                                                        \
    }

static const File files[] = {
    FILE_OF("bomb.ply", "mesh { file: \"bomb.ply\" }",
            "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
            "property float x\nproperty float y\nproperty float z\nelement face 4000000000\n"
            "property list uchar int vertex_indices\nend_header\n"),
    FILE_OF("ascii.ply", "mesh { file: \"ascii.ply\" }",
            "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\n"
            "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"),
    FILE_OF("nothing.ply", "mesh { file: \"nothing.ply\" }",
            "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
            "property float z\nelement nothing 4000000000\nend_header\n"),
    FILE_OF("list.ply", "mesh { file: \"list.ply\" }",
            "ply\nformat binary_little_endian 1.0\nelement face 1\n"
            "property list uint int vertex_indices\nend_header\n\xff\xff\xff\xff"),
    FILE_OF("bomb.obj", "mesh { file: \"bomb.obj\" }",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 999999999 999999998 -999999999\n"),
    FILE_OF("bomb.stl", "mesh { file: \"bomb.stl\" }",
            "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
            "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
            "\xff\xff\xff\xff"),
    FILE_OF("bomb.glb", "mesh { file: \"bomb.glb\" }",
            "glTF\2\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7fJSON{}"),
    FILE_OF("bomb.ies", "photometric_light { position: (0, 0, 1), file: \"bomb.ies\" }",
            "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2000000000 2000000000 1 2 0 0 0\n1 1 1\n0 90\n"),
    FILE_OF("bomb.hdr", "environment_light { radiance: image { file: \"bomb.hdr\" } }",
            "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n"),
    FILE_OF("bomb.pfm", "environment_light { radiance: image { file: \"bomb.pfm\" } }",
            "PF\n1000000 1000000\n-1.0\n"),
    FILE_OF("bomb.png", "sphere { material: lambert { color: image { file: \"bomb.png\" } } }",
            "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x08\x02\0\0\0\xc1\xd4"
            "\xb2\x6f"),
    FILE_OF("bomb.ppm", "sphere { material: lambert { color: image { file: \"bomb.ppm\" } } }",
            "P6\n2000000000 2000000000\n255\n"),
    FILE_OF("bomb.bmp", "sphere { material: lambert { color: image { file: \"bomb.bmp\" } } }",
            "BM\xff\xff\xff\x7f\0\0\0\0\x36\0\0\0\x28\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\1\0"
            "\x18\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"),
    FILE_OF("bomb.tga", "sphere { material: lambert { color: image { file: \"bomb.tga\" } } }",
            "\0\0\2\0\0\0\0\0\0\0\0\0\xff\xff\xff\xff\x18\0"),
    FILE_OF("bomb.exr", "sphere { material: lambert { color: image { file: \"bomb.exr\" } } }",
            "\x76\x2f\x31\x01\2\0\0\0"
            "dataWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f"
            "displayWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\0"),
    FILE_OF("bomb.dds", "sphere { material: lambert { color: image { file: \"bomb.dds\" } } }",
            "DDS \x7c\0\0\0\7\x10\0\0\xff\xff\xff\x7f\xff\xff\xff\x7f\0\0\0\0\0\0\0\0\0\0\0\0"
            "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
            "\x20\0\0\0\4\0\0\0DXT1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x10\0\0"),
};

// --- Running them --------------------------------------------------------------------------------

// threads: NULL for as many as there are processors.
static bool check(const char *program, const char *folder, const char *name, const char *text,
                  const char *says, const char *threads, Worst *worst)
{
    const char *command[] = {
        "scene.scn", "-o", "out.exr", "-q", "--size", "16x16", threads ? "--threads" : NULL,
        threads,     NULL};
    program_write(folder, "scene.scn", text, strlen(text));
    ProgramRun run;
    program_run(program, command, folder, (unsigned)(60 * slower), &run);
    bool good = (run.status == 1 || (run.status == 0 && !says[0])) && strstr(run.errors, says) &&
                run.cpu_seconds <= most_seconds * slower &&
                (!counts_memory || run.peak_kib <= (long)MOST_MIB << 10);
    if (!good) {
        printf("%s: status %d, %.2f s of the processor, %ld MiB, wanted `%s`\n%.600s\n", name,
               run.status, run.cpu_seconds, run.peak_kib >> 10, says, run.errors);
    }
    worst_take(worst, &run, name);
    return good;
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fputs("usage: bombs_test PROGRAM FOLDER\n", stderr);
        return 2;
    }
    Worst worst = {0};
    unsigned number = 0;
    int count = 0, failed = 0;
    for (size_t i = 0; i < sizeof bombs / sizeof bombs[0]; ++i) {
        if (!program_takes(argc, argv, number++)) {
            continue;
        }
        ++count;
        failed +=
            !check(argv[1], argv[2], bombs[i].name, bombs[i].text, bombs[i].says, NULL, &worst);
    }
    // What is made beside one another shares the limit of memory.
    if (program_takes(argc, argv, number++)) {
        ++count;
        failed +=
            !check(argv[1], argv[2], "ranges_kept_by_32",
                   "let a = [for (i in 0..<1000) range(0, 9_000_000)]", "error", "32", &worst);
    }
    for (size_t i = 0; i < sizeof files / sizeof files[0]; ++i) {
        if (!program_takes(argc, argv, number++)) {
            continue;
        }
        ++count;
        program_write(argv[2], files[i].name, files[i].bytes, files[i].size);
        const char *code = strncmp(files[i].text, "mesh", 4) == 0 ? "[E085" : "[E09";
        failed += !check(argv[1], argv[2], files[i].name, files[i].text, code, NULL, &worst);
    }
    printf("%d bombs, %d failed; the slowest was %s (%.2f s of the processor), the largest %s "
           "(%ld MiB)\n",
           count, failed, worst.slowest, worst.seconds, worst.largest, worst.kib >> 10);
    return failed ? 1 : 0;
}
