#include "base/microfacet.h" // where it lives
