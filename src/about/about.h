/** @file
 * What the files of this folder share.
 */
#ifndef VVI_ABOUT_ABOUT_H
#define VVI_ABOUT_ABOUT_H
#include "measuring/answer.h"
#include <volvis/about.h>

/** One answer on its way. */
typedef struct vvi_about {
    vv_answer *answer;
    const vv_file *file;
    vv_about_options options;
    vv_job *job;
} vvi_about;

/** A new answer: *out. */
vv_status vvi_about_begin(vvi_about *about, vv_answer **out, const vv_about_options *options, vv_job *job);
/** After the last item: what is to be returned. */
vv_status vvi_about_end(const vv_answer *answer, vv_status st);
/** How many lines of a list are shown. */
size_t vvi_about_lines(const vvi_about *about);
/** What follows a list of n that was cut. */
void vvi_about_more(const vvi_about *about, size_t n);
/** Name, colour and window of a channel as keys of the object that is open. channel NULL: none of it. */
void vvi_about_channel_keys(vv_answer *answer, const vv_channel *channel);
/** "1 DAPI #0000ff, window 0 to 4095"; channel NULL: only its number. */
void vvi_about_channel_line(vv_answer *answer, int component, const vv_channel *channel);
void vvi_about_parts(const vvi_about *about);
/** Channels without statistics. */
void vvi_about_channels(const vvi_about *about);
/** Labels without counts. */
void vvi_about_labels(const vvi_about *about);
/** With how often each stands in the field, named or not, and the volume that it takes. */
vv_status vvi_about_label_counts(const vvi_about *about);
/** What the header says of numbers that stand for no value, where it does. */
void vvi_about_missing(const vvi_about *about);
vv_status vvi_about_range(const vvi_about *about);
vv_status vvi_about_statistics(const vvi_about *about);
#endif
