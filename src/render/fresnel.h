#include "base/fresnel.h" // where it lives
