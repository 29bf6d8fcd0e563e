/** @file
 * What writers of mesh files share.
 */
#ifndef VVI_IO_MESH_WRITE_H
#define VVI_IO_MESH_WRITE_H
#include "io/sink.h"
#include <volvis/mesh.h>

/** Place of a vertex in the world. */
void vvi_mesh_place(double out[3], const vv_mesh_info *mesh, size_t vertex);
/** Whether places need more than single precision (vvi_mesh_is_far()). */
bool vvi_mesh_needs_doubles(const vv_mesh *mesh);
/** The part of a triangle; `*at` is a number of a part at or before it, from 0, and goes on with it. NULL: no parts. */
const vv_mesh_part *vvi_mesh_part_at(const vv_mesh_info *mesh, size_t triangle, size_t *at);
/** Whether any part has a colour. */
bool vvi_mesh_has_part_colors(const vv_mesh_info *mesh);

/** A name as text of one line: line ends and other control bytes become blanks. */
void vvi_mesh_line_of(char out[64], const char *name);

/** Rows of text, or of bytes, through a room of its own. */
typedef struct vvi_mesh_text {
    vv_sink *sink; /**< NULL: all stays in the room, which grows */
    vv_job *job;
    vv_status status; /**< the first failure; nothing is written after it */
    size_t n, room_bytes;
    char *room;
    bool in_line; /**< something stands before the next word */
} vvi_mesh_text;
vv_status vvi_mesh_text_begin(vvi_mesh_text *out, vv_sink *sink, vv_job *job);
/** Rows first <= i < end of something. Any thread. */
typedef void vvi_mesh_rows(vvi_mesh_text *text, const void *user, size_t first, size_t end);
/** Rows 0 <= i < n, some thousands at a time on each thread, written in their order: the same bytes for any number of
 * threads. */
void vvi_mesh_text_rows(vvi_mesh_text *text, vvi_mesh_rows *rows, const void *user, size_t n);
void vvi_mesh_text_bytes(vvi_mesh_text *text, const void *bytes, size_t n);
void vvi_mesh_text_add(vvi_mesh_text *text, const char *s);
/** A number with the fewest digits that say it, after a blank where it does not begin the line. */
void vvi_mesh_text_float(vvi_mesh_text *text, float value);
void vvi_mesh_text_double(vvi_mesh_text *text, double value);
void vvi_mesh_text_uint(vvi_mesh_text *text, uint64_t value);
/** Of a vertex, in the precision that it needs. */
void vvi_mesh_text_place(vvi_mesh_text *text, const vv_mesh_info *mesh, size_t vertex, bool doubles);
/** What is left goes out; the first failure of all. The room is gone. */
vv_status vvi_mesh_text_end(vvi_mesh_text *text);
#endif
