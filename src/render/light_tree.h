// A hierarchy over lights, by which one of thousands is chosen for a point with a chance about
// proportional to what it gives there: Conty Estevez and Kulla 2018, "Importance Sampling of Many
// Lights with Adaptive Tree Splitting" (without the splitting). Each node has up to eight children,
// which vectors weigh together, and of which one is chosen with more known than of two.
#ifndef RENDER_LIGHT_TREE_H
#define RENDER_LIGHT_TREE_H

#include "render/light.h"

typedef struct LightTreeNode LightTreeNode;

typedef struct LightTree {
    LightTreeNode *nodes; // the root is the first; NULL: no lights
    uint32_t *places;     // by light: where it hangs
    uint32_t count;       // lights
    double scale;         // 1 over the radius of all of them, 1/m
    double unit;          // of importances: their intensity times scale²
} LightTree;

// What the tree knows of a light.
typedef struct LightTreeItem {
    Box3 bounds; // finite
    LightCone cone;
    double intensity; // > 0
} LightTreeItem;

// False when memory runs out; the tree lies in the arena. count may be 0.
bool light_tree_build(LightTree *tree, Arena *arena, const LightTreeItem *items, uint32_t count);
// About the irradiance at a point by all the tree's lights, in the unit of intensity over m²; 0
// only where none of them shines. The tree must not be empty, as below.
double light_tree_importance(const LightTree *tree, const LightReceiver *at);
// The item that u in [0, 1) chooses, and its chance; NONE_ID where a way down leads to lights none
// of which shines on the point (so that the chances of all items may sum to less than one).
uint32_t light_tree_choose(const LightTree *tree, const LightReceiver *at, double u,
                           double *chance);
double light_tree_chance(const LightTree *tree, const LightReceiver *at, uint32_t item);

#endif
