/** @file
 * Samples of a field to a sink.
 */
#ifndef VVI_IO_SAMPLE_WRITER_H
#define VVI_IO_SAMPLE_WRITER_H
#include "io/sink.h"

/** All samples, x fastest, components interleaved; component >= 0: that one alone. */
vv_status vvi_samples_write(vv_sink *sink, const vv_field *field, int component, bool big_endian, vv_job *job);
/** Whether big_endian is not the machine's order. */
bool vvi_order_swapped(bool big_endian);
/** How samples are handed on: n samples of `bytes` bytes together, as many calls as it takes. */
typedef vv_status vvi_samples_fn(void *user, void *data, size_t n_bytes);
vv_status vvi_samples_each(const vv_field *field, int component, vvi_samples_fn *fn, void *user, vv_job *job);
/** Warns of what a format without a header for it does not keep. */
void vvi_log_loss(const vv_sink *sink, const vv_field_info *info, size_t n_frames, const char *format, vv_job *job);
/** Warns of a unit that no other program will know: they take lengths for `taken`. */
void vvi_log_lost_unit(const vv_sink *sink, const vv_grid *grid, const char *taken, vv_job *job);
/** What a format keeps of channels and labels. */
enum { VVI_KEEPS_CHANNELS = 1, VVI_KEEPS_LABELS = 2, VVI_KEEPS_WINDOW = 4 /* of an only channel */ };
/** Warns of names, colours and windows that are there and that a format does not keep. */
void vvi_log_lost_names(const vv_sink *sink, const vv_write_options *options, unsigned keeps, const char *format,
                        vv_job *job);
#endif
