/** @file
 * What is told of a mesh, or of several together.
 */
#ifndef VVI_MEASURING_MESHES_H
#define VVI_MEASURING_MESHES_H
#include "measuring/measuring.h"
#include <volvis/measure_mesh.h>

/** The figures that `what` asks for. */
void vvi_mesh_measures_put(vv_answer *answer, unsigned what, const vv_mesh_measures *measures, const char *unit);
/** Where area and volume alone are known: its box and centroid are NaN. */
void vvi_mesh_measures_drop_box(vv_mesh_measures *measures);
/** Says so where nothing of it is left. */
void vvi_measuring_note_no_triangles(vvi_measuring *m, const vv_mesh_measures *found);
/** mesh_region.c: of meshes as a scene has them what of them is in a region, cut there; the flat faces that close it,
 * there and where the scene cuts it, are no part of its area unless `closed`. Where only area and volume are known, the
 * box is NaN, and so is the centroid. VV_E_ARGUMENT: it is open, and not to be. */
vv_status vvi_measure_in_region(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *region,
                                bool open, bool closed, vv_job *job);
/** A sentence where box and centroid alone are asked for, or faces that close it, and are not known there; a note where
 * more is. */
vv_status vvi_measuring_check_mesh_region(const vvi_measuring *m, const vv_region_shape *region);
/** As a scene shows it: of what is in the ellipsoid (NULL: everywhere), of its planes cut off. */
vv_status vvi_measure_cut_mesh(vv_mesh_measures *out, const vv_measured_data *data, const vv_region_shape *ellipsoid,
                               bool open, bool closed, vv_job *job);
/** What a scene shows of a mesh, in its World: where it is placed, and what planes leave of it. */
vv_status vvi_shown_mesh(vv_mesh **out, const vv_measured_data *shown, vv_job *job);
#endif
