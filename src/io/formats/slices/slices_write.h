/** @file
 * Writing folders of slices.
 */
#ifndef VVI_IO_FORMATS_SLICES_WRITE_H
#define VVI_IO_FORMATS_SLICES_WRITE_H
#include "io/sink.h"

/** A PNG of samples as they are: 1, 3 or 4 of u8 or u16 a pixel, of the machine's byte order; for vvi_free(). */
vv_status vvi_slices_encode_png(uint8_t **out, size_t *n_out, const uint8_t *samples, const vv_field_info *info,
                                const char *name, vv_job *job);
/** A folder of one file for each slice, channel and time step, by the names that reading understands. */
vv_status vvi_slices_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                           const vv_write_options *options, vv_job *job);
enum { VVI_SLICES_NAME_MOST = 255 };
/** The last name of a path where it has places for numbers, "out/slice_%03d.png": what its slices are called. NULL: it
 * has none. */
const char *vvi_slices_pattern(const char *path);
/** Whether names can be made by it, and in which encoding; that asked for may be NULL. */
vv_status vvi_slices_check_pattern(const char **encoding_out, const char *names, const char *encoding);
/** Whether it has a place for the number of each axis that there is: time steps, channels, slices, in this order. */
vv_status vvi_slices_check_places(const char *names, uint64_t frames, uint64_t channels, uint64_t slices);
/** With its numbers, one for each place. */
void vvi_slices_fill(char out[VVI_SLICES_NAME_MOST], const char *names, const uint64_t *numbers);
/** Whether a file is one of such a folder; the one that marks it is hidden. */
int vvi_slices_folder_file(const char *name);
#endif
