/** @file
 * Eigenvalues and eigenvectors of symmetric matrices of three rows.
 */
#ifndef VVI_CORE_SYMMETRIC_H
#define VVI_CORE_SYMMETRIC_H
#include <volvis/vec.h>

/** The entries of a symmetric matrix, in this order. */
enum { VVI_XX, VVI_YY, VVI_ZZ, VVI_XY, VVI_XZ, VVI_YZ, VVI_SYMMETRIC };

/**
 * In closed form, ascending: the best separated eigenvalue by the trigonometric formula, the other two in the plane at
 * right angles to its vector (Eberly, A Robust Eigensolver for 3 x 3 Symmetric Matrices).
 *
 * Range    entries are finite, or all results are NaN
 * Errors   of values, about 1e-15 of the largest one, also where they are equal
 */
void vvi_symmetric_values(double value[3], const double m[VVI_SYMMETRIC]);
/** The same, and unit vectors of them, at right angles to each other. */
void vvi_symmetric_eigen(double value[3], vv_vec3 vector[3], const double m[VVI_SYMMETRIC]);
#endif
