/* VTK image data, written as VTK 9 does: one piece, one array. */
#include "io/formats/vtk/vti_write.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/base64.h"
#include "io/numbers.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#define WORD VVI_VTI_WORD
#define BLOCK_BYTES ((size_t)256 << 10)
#define BATCH_BLOCKS ((size_t)16)

const char *const vvi_vti_encodings[] = {"raw", "zlib", "base64", "ascii", NULL};

static const char after_array[] = "\n        </DataArray>\n";
static const char end_of_grid[] = "      </PointData>\n    </Piece>\n  </ImageData>\n";

static void put_word(uint8_t out[WORD], uint64_t v, bool big_endian)
{
    for (int i = 0; i < WORD; i++)
        out[big_endian ? WORD - 1 - i : i] = (uint8_t)(v >> 8 * i);
}

/* Samples as text ---------------------------------------------------------------------------------------------------
 */

typedef struct coder {
    vv_sink *sink;
    vv_type type;
    bool swap;
    int column;
    vvi_base64 base64;
} coder;

static vv_status write_numbers(void *user, void *data, size_t n_bytes)
{
    coder *w = user;
    const size_t bytes = vv_type_bytes(w->type);
    vv_status st = VV_OK;
    for (size_t i = 0; i < n_bytes && st == VV_OK; i += bytes) {
        char number[32];
        vvi_sample_print(number, w->type, (const uint8_t *)data + i);
        st = vvi_sink_printf(w->sink, "%s%s", number, ++w->column % 10 ? " " : "\n");
    }
    return st;
}

static vv_status write_base64(void *user, void *data, size_t n_bytes)
{
    coder *w = user;
    if (w->swap)
        vvi_swap_bytes(data, vv_type_bytes(w->type), n_bytes / vv_type_bytes(w->type));
    return vvi_base64_write(&w->base64, w->sink, data, n_bytes);
}

static vv_status write_in_place(vv_sink *sink, const vv_field *field, const char *encoding, uint64_t bytes,
                                bool big_endian, vv_job *job)
{
    const vv_type type = vv_field_get_info(field)->type;
    coder w = {.sink = sink, .type = type, .swap = vv_type_bytes(type) > 1 && vvi_order_swapped(big_endian)};
    if (strcmp(encoding, "ascii") == 0)
        return vvi_samples_each(field, -1, write_numbers, &w, job);
    uint8_t word[WORD];
    put_word(word, bytes, big_endian);
    vv_status st = vvi_base64_write(&w.base64, sink, word, WORD);
    if (st == VV_OK)
        st = vvi_samples_each(field, -1, write_base64, &w, job);
    return st == VV_OK ? vvi_base64_end(&w.base64, sink) : st;
}

/* Blocks: sizes stand before them, so they are kept until all are packed ---------------------------------------------
 */

typedef struct packer {
    vv_job *job;
    size_t element;
    bool swap;
    int level;
    uint8_t *in, *out; /* a batch of blocks; each packed one has `room` bytes */
    size_t n_in, room;
    size_t packed[BATCH_BLOCKS];
    uint64_t *size; /* of each packed block */
    size_t n_blocks;
    uint8_t *all;
    size_t n_all, all_room;
} packer;

static vv_status pack_one(void *scratch, void *shared, size_t index)
{
    packer *p = shared;
    const size_t from = index * BLOCK_BYTES, n = p->n_in - from < BLOCK_BYTES ? p->n_in - from : BLOCK_BYTES;
    uLongf n_out = p->room;
    if (compress2(p->out + index * p->room, &n_out, p->in + from, n, p->level ? p->level : Z_DEFAULT_COMPRESSION) !=
        Z_OK)
        return vv_fail_memory(p->room);
    p->packed[index] = n_out;
    return VV_OK;
}

static vv_status keep(packer *p, const uint8_t *data, size_t n)
{
    if (p->n_all + n > p->all_room) {
        const size_t room = (p->n_all + n) + p->all_room / 2;
        uint8_t *bigger = vvi_realloc(p->job, p->all, room, VVI_MEM_SCRATCH);
        if (!bigger)
            return vv_fail_memory(room);
        p->all = bigger;
        p->all_room = room;
    }
    memcpy(p->all + p->n_all, data, n);
    p->n_all += n;
    return VV_OK;
}

static vv_status pack_batch(packer *p)
{
    static const vvi_work work = {.item = pack_one};
    const size_t n = (p->n_in + BLOCK_BYTES - 1) / BLOCK_BYTES;
    vv_status st = n ? vvi_parallel_for(p->job, &work, p, n) : VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        p->size[p->n_blocks++] = p->packed[i];
        st = keep(p, p->out + i * p->room, p->packed[i]);
    }
    p->n_in = 0;
    return st;
}

static vv_status take_samples(void *user, void *data, size_t n_bytes)
{
    packer *p = user;
    const uint8_t *in = data;
    vv_status st = VV_OK;
    if (p->swap)
        vvi_swap_bytes(data, p->element, n_bytes / p->element);
    while (n_bytes > 0 && st == VV_OK) {
        const size_t room = BATCH_BLOCKS * BLOCK_BYTES - p->n_in, n = n_bytes < room ? n_bytes : room;
        memcpy(p->in + p->n_in, in, n);
        p->n_in += n;
        in += n;
        n_bytes -= n;
        if (p->n_in == BATCH_BLOCKS * BLOCK_BYTES)
            st = pack_batch(p);
    }
    return st;
}

static vv_status write_packed(vv_sink *sink, const packer *p, uint64_t bytes, bool big_endian)
{
    uint8_t word[3 * WORD];
    put_word(word, p->n_blocks, big_endian);
    put_word(word + WORD, BLOCK_BYTES, big_endian);
    put_word(word + 2 * WORD, bytes % BLOCK_BYTES, big_endian);
    vv_status st = vvi_sink_write(sink, word, sizeof word);
    for (size_t b = 0; b < p->n_blocks && st == VV_OK; b++) {
        put_word(word, p->size[b], big_endian);
        st = vvi_sink_write(sink, word, WORD);
    }
    return st == VV_OK ? vvi_sink_write(sink, p->all, p->n_all) : st;
}

static vv_status write_blocks(vv_sink *sink, const vv_field *field, uint64_t bytes, const vv_write_options *options,
                              vv_job *job)
{
    const size_t n_blocks = (size_t)(bytes / BLOCK_BYTES + 1);
    packer p = {.job = job, .element = vv_type_bytes(vv_field_get_info(field)->type), .level = options->level};
    p.swap = p.element > 1 && vvi_order_swapped(options->big_endian);
    p.room = compressBound(BLOCK_BYTES);
    p.in = vvi_alloc(job, BATCH_BLOCKS * BLOCK_BYTES, VVI_MEM_SCRATCH);
    p.out = vvi_alloc(job, BATCH_BLOCKS * p.room, VVI_MEM_SCRATCH);
    p.size = vvi_alloc(job, n_blocks * sizeof *p.size, VVI_MEM_SCRATCH);
    vv_status st = p.in && p.out && p.size ? VV_OK : vv_fail_memory(BATCH_BLOCKS * p.room);
    if (st == VV_OK)
        st = vvi_samples_each(field, -1, take_samples, &p, job);
    if (st == VV_OK)
        st = pack_batch(&p);
    if (st == VV_OK)
        st = write_packed(sink, &p, bytes, options->big_endian);
    vvi_free(p.in);
    vvi_free(p.out);
    vvi_free(p.size);
    vvi_free(p.all);
    return st;
}

/* The file -----------------------------------------------------------------------------------------------------------
 */

static vv_status write_appended(vv_sink *sink, const vv_field *field, const char *encoding, uint64_t bytes,
                                const vv_write_options *options, vv_job *job)
{
    if (strcmp(encoding, "zlib") == 0)
        return write_blocks(sink, field, bytes, options, job);
    uint8_t word[WORD];
    put_word(word, bytes, options->big_endian);
    vv_status st = vvi_sink_write(sink, word, WORD);
    return st == VV_OK ? vvi_samples_write(sink, field, -1, options->big_endian, job) : st;
}

vv_status vvi_vti_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    const char *encoding = options->encoding ? options->encoding : vvi_vti_encodings[0];
    const bool in_place = strcmp(encoding, "ascii") == 0 || strcmp(encoding, "base64") == 0;
    vvi_text head = {0};
    uint64_t bytes;
    if (n_frames != 1)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_sink_name(sink), NULL,
                          "a .vti file holds one time step and there are %zu; write each to a file of its own "
                          "(FILE@N), or all to .nrrd",
                          n_frames);
    vvi_log_lost_names(sink, options, 0, "vti", job);
    vv_status st = vv_field_info_bytes(&bytes, info);
    if (st != VV_OK)
        return st;
    vvi_vti_add_head(&head, info, encoding, options->big_endian);
    if (!in_place) {
        vvi_text_add(&head, end_of_grid);
        vvi_vti_add_mark(&head);
    }
    st = head.bad ? vv_fail_memory(head.n) : vvi_sink_write(sink, head.s, head.n);
    vvi_text_free(&head);
    if (st == VV_OK)
        st = in_place ? write_in_place(sink, frames[0], encoding, bytes, options->big_endian, job)
                      : write_appended(sink, frames[0], encoding, bytes, options, job);
    if (st != VV_OK)
        return st;
    return in_place ? vvi_sink_printf(sink, "%s%s</VTKFile>\n", after_array, end_of_grid)
                    : vvi_sink_printf(sink, "\n  </AppendedData>\n</VTKFile>\n");
}
