/** @file
 * One question on its way to its answer: what rows share.
 */
#ifndef VVI_MEASURING_MEASURING_H
#define VVI_MEASURING_MEASURING_H
#include "measuring/answer.h"
#include <volvis/measure.h>

enum { VVI_PLANES_MOST = 38 }; /* six of a box */

typedef struct vvi_measuring {
    const vv_measurement *asked;
    const vv_measured_inputs *inputs;
    const vv_measured_data *input; /**< what is looked at now: the first input, or the second */
    unsigned what;                 /**< of the form */
    const char *uses;              /**< of the form */
    vv_answer *answer;
    vv_job *job;
    /* of a volume */
    vv_field *field, *mask;
    vv_plane planes[VVI_PLANES_MOST - 6];
    size_t n_planes;
    vv_measure_options choice;
    vv_region_shape shape; /**< where choice.region is set */
    double *outline;       /**< of the shape */
    bool chosen;           /**< an object was asked for */
    bool automatic;        /**< VolVis chose the value */
    bool of_scene;         /**< it is the one that the scene shows */
    bool took_missing;     /**< field is without them */
    bool told_seed;        /**< for programs, once */
    bool told_empty;       /**< that the object is empty */
    bool labels;           /**< its figures are told as those of labels */
    char object[160];      /**< what it is, for people */
    char region[96];
} vvi_measuring;

/** Whether a property of the question is set. */
bool vvi_asks(const vvi_measuring *m, const char *property);
/** "X,Y,Z" as it is typed. */
enum { VVI_POINT_TEXT = 96 };
const char *vvi_point_print(char out[VVI_POINT_TEXT], vv_vec3 p);

/** The choice of a question about m->input, a volume. Close it also when it fails. */
vv_status vvi_measuring_open(vvi_measuring *m);
void vvi_measuring_close(vvi_measuring *m);
/** Whether it asks of a region with a frame of its own. */
bool vvi_measurement_has_region(const vv_measurement *m);
/** That region; place: from sample indices to the world. *outline is yours to free(), also when this fails. Errors:
 * VV_E_ARGUMENT (what it needs is missing, or says nothing), VV_E_MEMORY. */
vv_status vvi_measurement_shape(vv_region_shape *out, double **outline, const vv_measurement *m,
                                const vv_affine *place);
/** Of a question: takes it into the choice, names it, "": there is none, and tells how large it is. */
vv_status vvi_measuring_take_region(vvi_measuring *m);
void vvi_measuring_name_region(char out[64], const vvi_measuring *m);
vv_status vvi_measuring_put_region(vvi_measuring *m);
/** Of a mesh: the region in the world, and what is told of it; of kind VV_REGION_NONE where there is none. *outline is
 * yours to free(), also when this fails. */
vv_status vvi_measuring_mesh_region(vv_region_shape *out, double **outline, const vvi_measuring *m);
/** Whether the question is of a part of the volume: a region, a box of samples, or what planes leave. */
bool vvi_measuring_is_part(const vvi_measuring *m);
/** Where no object is asked for: of a region all of it; else the values above the one that best splits the histogram,
 * or below it where the larger ones surround the object; of labels all but 0. To be asked before areas and volumes are
 * measured. */
vv_status vvi_measuring_choose(vvi_measuring *m);
/** Of an object below a value that was chosen so: the surface of that value, which bounds it from outside. */
void vvi_measuring_take_surface(vvi_measuring *m);
/** Of data that turned out to be steps: counts from now on, where the method was left to VolVis. False: it was not. */
bool vvi_measuring_count_steps(vvi_measuring *m);
/** The planes of the region in the world, those of the box too, at its outermost samples. How many there are. */
size_t vvi_measuring_planes(vv_plane out[VVI_PLANES_MOST], const vvi_measuring *m);
/** Of labels: counts, unless Marching Cubes was asked for. */
void vvi_measuring_label_method(vvi_measuring *m);
/** The object is a label; called: what it is called, NULL: by its number. */
void vvi_measuring_take_label(vvi_measuring *m, vv_label_id label, const char *called);
/** A field that is told sample by sample with the volume: it goes where the scene puts the volume, and its samples must
 * lie where the volume's do; in the volume's order then. marks: it is a mask, 0 where it has no samples; else it must
 * have one wherever the volume has. */
vv_status vvi_measuring_beside(vv_field **out, const vvi_measuring *m, const vv_measured_data *data, bool marks);
/** The seed for programs, once, where there is one. */
void vvi_measuring_put_seed(vvi_measuring *m);
/** A note that the object is empty, once, though values and the object may both be asked for. */
void vvi_measuring_note_empty(vvi_measuring *m);
/** " in box of samples ..": "" of everything. */
const char *vvi_measuring_in(const vvi_measuring *m, const char **region_out);
/** How well a place is known along one direction: it is picked from samples, to half a step along each axis. */
double vvi_place_error(const vvi_measuring *m);
/** A box as it is typed, "10..59,..,5..19"; VV_E_ARGUMENT. */
vv_status vvi_measuring_box(vv_box *out, const char *typed, const vv_grid *grid);
/** The places of the question as index coordinates; VV_E_ARGUMENT says how many `what` needs. */
vv_status vvi_measuring_points(vv_vec3 *out, size_t n, const vvi_measuring *m, const char *what);
/** Which samples a plot is of, for the line under its title; "" of all. object: those of the object alone. */
const char *vvi_measuring_subset(const vvi_measuring *m, bool object);
/** Of a series: which time step was measured. */
void vvi_measuring_put_step(vvi_measuring *m);
/** Whether the samples are labels, as the scene or the file says, or (*sensed) look like labels, as pictures show them;
 * *untold: that takes more memory than there is. */
vv_status vvi_measuring_of_labels(bool *labels, bool *sensed, bool *untold, const vvi_measuring *m);
/** The file's name without its folder, for titles. */
const char *vvi_measuring_title(const vvi_measuring *m);

/** VV_E_ARGUMENT: a kind that such data (`name`) do not have, and which they have. */
vv_status vvi_measure_refuse(const vv_measure_kind *kind, unsigned input, const char *name);

/* Rows ------------------------------------------------------------------------------------------------------------ */

/** What is told of an object, a bit each: m->what. */
enum { VVI_AREA = 1, VVI_VOLUME = 2, VVI_BOX = 4, VVI_DETAILS = 8, VVI_EXTENT = 7, VVI_SURFACE = 16 };

vv_status vvi_measure_object(vvi_measuring *m);
vv_status vvi_measure_summary(vvi_measuring *m);
vv_status vvi_measure_mesh(vvi_measuring *m);
vv_status vvi_measure_shown(vvi_measuring *m);
vv_status vvi_measure_statistics(vvi_measuring *m);
vv_status vvi_measure_histogram(vvi_measuring *m);
vv_status vvi_measure_joint_histogram(vvi_measuring *m);
vv_status vvi_measure_profile(vvi_measuring *m);
vv_status vvi_measure_distance(vvi_measuring *m);
/** Of a mesh: between places, or from a single one to its surface. */
vv_status vvi_measure_mesh_distance(vvi_measuring *m);
vv_status vvi_measure_angle(vvi_measuring *m);
vv_status vvi_measure_point(vvi_measuring *m);
vv_status vvi_measure_label_table(vvi_measuring *m);
/* With VVI_SURFACE: these open volumes, whose surfaces they are of, themselves. */
vv_status vvi_measure_point_to_surface(vvi_measuring *m);
vv_status vvi_measure_two_surfaces(vvi_measuring *m);
vv_status vvi_measure_geodesic(vvi_measuring *m);
/** Whether a word is one of those in a list, between spaces, such as vv_measure_form.uses; list NULL: there is none. */
bool vvi_measure_has_word(const char *list, const char *word);
#endif
