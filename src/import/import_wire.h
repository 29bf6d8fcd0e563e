/** @file
 * What is said between a program that reads under --safe and its import program (src/import), on a socket: messages
 * of a kind, a length and as many bytes. Both sides are of one build, so numbers go as they lie in memory.
 *
 * The reader of a message trusts nothing in it: every taker checks what is left; past the end, or at a text that does
 * not end, the message turns bad once and for all and takers give 0 or "".
 */
#ifndef VVI_IMPORT_WIRE_H
#define VVI_IMPORT_WIRE_H
#include "core/text.h"
#include <volvis/file.h>
#include <volvis/mesh.h>

typedef enum vvi_wire_kind {
    VVI_WIRE_OPEN = 1, /* to the import program: a file and how to read it */
    VVI_WIRE_READ,     /* a frame or a box of it, with a descriptor of shared memory for the samples */
    VVI_WIRE_OPEN_MESH,
    VVI_WIRE_READ_MESH,  /* its arrays, one after the other, with such a descriptor */
    VVI_WIRE_READ_TEXTS, /* of an image: no pixels */
    VVI_WIRE_OPEN_IMAGE,
    VVI_WIRE_READ_IMAGE, /* its pixels and layers, as of a mesh */
    VVI_WIRE_LOG,        /* from here on from the import program */
    VVI_WIRE_PROGRESS,
    VVI_WIRE_METADATA,
    VVI_WIRE_WARNING,
    VVI_WIRE_PART,
    VVI_WIRE_CHANNEL,
    VVI_WIRE_LABEL,
    VVI_WIRE_KEPT,
    VVI_WIRE_OPENED, /* this and the next end what was asked for */
    VVI_WIRE_OPENED_MESH,
    VVI_WIRE_TEXTS,
    VVI_WIRE_OPENED_IMAGE,
    VVI_WIRE_DONE,
    VVI_WIRE_FAILED
} vvi_wire_kind;

enum { VVI_WIRE_VERSION = 10, VVI_WIRE_MAGIC = 0x76766977, VVI_IMPORT_SOCKET = 3 };

typedef struct vvi_wire_head {
    uint32_t magic, kind;
    uint64_t n_bytes;
} vvi_wire_head;

/** Bytes of a message that is read. Texts that were taken lie in it. */
typedef struct vvi_wire_in {
    const char *bytes;
    size_t n, at;
    bool bad;
} vvi_wire_in;

/** A message to be written is a vvi_text; bad when memory ran out. */
void vvi_wire_put(vvi_text *out, const void *data, size_t n);
void vvi_wire_put_number(vvi_text *out, int64_t number);
void vvi_wire_put_text(vvi_text *out, const char *text); /* NULL is another thing than "" */
void vvi_wire_put_channel(vvi_text *out, const vv_channel *channel);
void vvi_wire_put_label(vvi_text *out, const vv_label *label);

/** All of a mesh but its arrays, of which it says which there are (VVI_MESH_*) and how many of each. */
void vvi_wire_put_mesh(vvi_text *out, const vv_mesh_info *mesh, unsigned with);

/** n bytes where they lie; NULL when they are not there. */
const void *vvi_wire_take_bytes(vvi_wire_in *in, size_t n);
/** n bytes, copied; zeros when they are not there. */
void vvi_wire_take(vvi_wire_in *in, void *out, size_t n);
int64_t vvi_wire_take_number(vvi_wire_in *in);
/** A number from lo to hi; another one makes the message bad. */
int64_t vvi_wire_take_between(vvi_wire_in *in, int64_t lo, int64_t hi);
const char *vvi_wire_take_text(vvi_wire_in *in); /* never NULL */
const char *vvi_wire_take_text_or_null(vvi_wire_in *in);
vv_channel vvi_wire_take_channel(vvi_wire_in *in);
/** Its codes, where it has any, go to `codes`. */
vv_label vvi_wire_take_label(vvi_wire_in *in, vv_code codes[VV_LABEL_CODES]);
/** Its arrays are NULL, but for textures, without pixels: yours to free(). */
vv_mesh_info vvi_wire_take_mesh(vvi_wire_in *in, unsigned *with_out);
/** Whether all was there and nothing is left. */
bool vvi_wire_taken(const vvi_wire_in *in);

/** Writes a message, with a descriptor if it is not negative; waits. False when the other side is gone (errno). */
bool vvi_wire_send(int socket, vvi_wire_kind kind, const vvi_text *body, int descriptor);
#endif
