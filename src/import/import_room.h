/** @file
 * Memory for samples that the import program fills: shared, and then nobody else's.
 */
#ifndef VVI_IMPORT_ROOM_H
#define VVI_IMPORT_ROOM_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_import_room {
    void *data; /* NULL until it is sealed */
    size_t bytes;
    bool counted;
    vv_runtime *counted_in;
} vvi_import_room;

/** The parent alone says how large it is, and the size is sealed before anybody else has it. Nothing of it is counted
 * yet: pages are there when they are written. */
vv_status vvi_import_room_new(vvi_import_room **out, int *fd_out, uint64_t bytes);
/** Counts it as memory of the job's runtime, once. */
vv_status vvi_import_room_count(vvi_import_room *room, vv_job *job);
/** From here on nobody can write there: the seal is refused as long as anybody could. Mapped for reading then. */
bool vvi_import_room_seal(vvi_import_room *room, int fd);
void vvi_import_room_free(void *room);
#endif
