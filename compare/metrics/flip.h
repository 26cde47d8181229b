// ꟻLIP, a difference evaluator for alternating images: Andersson, Nilsson, Akenine-Möller,
// Oskarsson, Åström and Fairchild, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020; sections
// and symbols below are the paper's. For pictures in [0, 1] (LDR).
#ifndef COMPARE_METRICS_FLIP_H
#define COMPARE_METRICS_FLIP_H

#include <stdbool.h>

// Pixels per degree of a viewer at `distance` metres from a monitor of `width` metres and
// `resolution` pixels. The paper's default, 0.7, 0.7 and 3840, gives 67.0.
double flip_pixels_per_degree(double distance, double width, double resolution);

// The error of each pixel, in [0, 1], between two pictures of linear light, `width * height * 3`
// floats that are clipped to [0, 1]. False without memory.
bool flip(const float *reference, const float *test, int width, int height,
          double pixels_per_degree, float *error);

// Parts of it, for tests.

// Of two linear colors without spatial filtering: section 4.1's redistributed color difference.
double flip_color_difference(const double reference[3], const double test[3]);

typedef struct FlipKernel {
    int radius;      // 2 radius + 1 numbers a side
    double *weights; // owned: flip_kernel_free
} FlipKernel;

typedef enum FlipChannel { FLIP_ACHROMATIC, FLIP_RED_GREEN, FLIP_BLUE_YELLOW } FlipChannel;
// The contrast sensitivity of a channel as a filter of pixels; its sum is 1.
bool flip_contrast_kernel(FlipChannel channel, double pixels_per_degree, FlipKernel *out);
// Edge detector (first derivative of a Gaussian) or point detector (second) along x: the positive
// weights sum to 1, the negative ones to -1.
bool flip_feature_kernel(bool points, double pixels_per_degree, FlipKernel *out);
void flip_kernel_free(FlipKernel *kernel);

#endif
