/* OpenEXR: the row of the table, the names of channels, and the library's files in memory. */
#include "io/images/exr.h"

#include "core/memory.h"
#include "registry.h"

#include <stdio.h>
#include <string.h>

#define SIDE_MOST 65536

const vvi_exr_channel vvi_exr_channels[] = {
    {"R", -1, 0},       {"G", -1, 1},       {"B", -1, 2}, {"A", -1, 3},      {"Z", 0, 0},     {"normal.X", 1, 0},
    {"normal.Y", 1, 1}, {"normal.Z", 1, 2}, {"id", 2, 0}, {"samples", 3, 0}, {"value", 4, 0}, {NULL, 0, 0},
};

static int64_t read_at(exr_const_context_t context, void *user, void *buffer, uint64_t n, uint64_t offset,
                       exr_stream_error_func_ptr_t fail)
{
    const vvi_exr_file *file = user;
    (void)context;
    (void)fail;
    const uint64_t left = offset < file->n ? file->n - offset : 0;
    if (n > left)
        n = left;
    if (n > 0)
        memcpy(buffer, file->data + offset, n);
    return (int64_t)n;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const vvi_exr_file *)user)->n;
}

static int64_t write_at(exr_const_context_t context, void *user, const void *buffer, uint64_t n, uint64_t offset,
                        exr_stream_error_func_ptr_t fail)
{
    vvi_exr_file *file = user;
    (void)context;
    (void)fail;
    const size_t end = (size_t)(offset + n);
    if (end > file->room) {
        const size_t room = 2 * end + 4096;
        uint8_t *more = vvi_realloc(file->job, file->data, room, VVI_MEM_SCRATCH);
        if (!more) {
            file->status = vv_fail_memory(room);
            return -1;
        }
        file->data = more;
        file->room = room;
    }
    if (offset > file->n)
        memset(file->data + file->n, 0, (size_t)offset - file->n);
    memcpy(file->data + offset, buffer, n);
    file->n = end > file->n ? end : file->n;
    return (int64_t)n;
}

/* The library holds its lock while it tells of a failure, so that the context's user pointer cannot be asked for: each
 * thread knows the file that it is at. */
static _Thread_local vvi_exr_file *current;

static void keep_message(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    (void)code;
    if (current && current->text[0] == 0)
        snprintf(current->text, sizeof current->text, "%s", message);
}

static void *take(size_t n)
{
    void *memory = vvi_alloc(NULL, n, VVI_MEM_SCRATCH);
    if (!memory && current)
        current->refused = n;
    return memory;
}

exr_context_initializer_t vvi_exr_initializer(vvi_exr_file *file)
{
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    current = file;
    start.error_handler_fn = keep_message;
    start.alloc_fn = take;
    start.free_fn = vvi_free;
    start.user_data = file;
    start.read_fn = read_at;
    start.size_fn = size_of;
    start.write_fn = write_at;
    start.max_image_width = SIDE_MOST;
    start.max_image_height = SIDE_MOST;
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return start;
}

void vvi_exr_file_finish(vvi_exr_file *file)
{
    current = NULL;
    vvi_free(file->data);
    file->data = NULL;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    static const uint8_t magic[4] = {0x76, 0x2f, 0x31, 0x01};
    (void)path;
    return n >= sizeof magic && memcmp(head, magic, sizeof magic) == 0 ? 2 : 0;
}

static const char *const suffixes[] = {".exr", NULL};
static const int bits[] = {16, 32, 0};

const vv_image_format vvi_image_format_exr = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "exr",
    .doc = "OpenEXR with 16 or 32 bit floats, transparency, layers and text; linear, premultiplied",
    .suffixes = suffixes,
    .probe = probe,
    .write = vvi_exr_write,
    .read = vvi_exr_read,
    .read_text = vvi_exr_read_text,
    .bits = bits,
    .layers = (1u << VV_LAYER_COUNT) - 1,
};
