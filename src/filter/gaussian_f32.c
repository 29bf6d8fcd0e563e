/* Gaussian smoothing in single precision: for samples of up to 16 bits and floats. */
#define REAL float
#define NAME(x) x##_f32
#include "filter/gaussian_body.h"
