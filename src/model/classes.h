/** @file
 * Classes of the model that other components of the library need by name.
 */
#ifndef VVI_MODEL_CLASSES_H
#define VVI_MODEL_CLASSES_H
#include <volvis/model.h>

extern const vv_class vvi_placement_class, vvi_threshold_class, vvi_transfer_class, vvi_labels_class,
    vvi_label_name_class, vvi_transfer_region_class, vvi_color_data_class, vvi_volume_paint_class,
    vvi_render_choice_class, vvi_layer_choice_class, vvi_volume_texture_class, vvi_decorations_class,
    vvi_measurement_class, vvi_measured_region_class, vvi_measured_figure_class, vvi_volume_slices_class,
    vvi_volume_rays_class;

/** Names of vv_ray_mode, and what else they are called. */
extern const char *const vvi_ray_modes[], *const vvi_ray_mode_aliases[];

/** Kinds of text, by how many bytes they may have: a World is told to everybody who looks at it. */
#define VVI_TEXT(bytes) .kind = VV_KIND_STRING, .limited = true, .max = (bytes)
#define VVI_WORD VVI_TEXT(256)  /**< a name, a unit */
#define VVI_LINE VVI_TEXT(1024) /**< a title, free text */

/** Gives back, and shares, what a dataset has in memory (dataset.c). */
void vvi_dataset_copy_fields(vv_object *copy, const vv_object *from);
void vvi_dataset_drop_fields(vv_object *object);

/* Checks of classes (check.c). `path` is where the object stands; errors name the property below it. */
vv_status vvi_check_cut_plane(const vv_object *object, const char *path);
vv_status vvi_check_transfer(const vv_object *object, const char *path);
vv_status vvi_check_paint(const vv_object *object, const char *path);
vv_status vvi_check_labels(const vv_object *object, const char *path);
vv_status vvi_check_placement(const vv_object *object, const char *path);
vv_status vvi_check_dataset(const vv_object *object, const char *path);
/** "crc32:89abcdef" */
bool vvi_checksum_parse(uint32_t *out, const char *text);
#endif
