/* The differential code of PVM files ("DDS v3d", "DDS v3e"): a stream of bits, the highest of a byte first.
 *
 *   2 bits   bytes of a sample less 1: those of several are stored apart, all first ones before all second ones
 *   16 bits  length of a row less 1
 *   then runs of 7 bits, how many bytes (0: the end), 3 bits c, and as many differences of c + 1 bits (0: of none),
 *   counted from the middle of their range
 *
 * A byte is the difference plus the one before it, or, from the second row on, plus that and the change between its two
 * neighbours in the row before. v3e takes bytes of samples apart in pieces of 2^24 samples instead of in the whole. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/pvm/pvm.h"
#include <string.h>

#define MAGIC_BYTES 8
#define INPUT_ROOM ((size_t)64 << 10)
#define PIECE_SAMPLES ((size_t)1 << 24)

int vvi_pvm_dds_version(const uint8_t *head, size_t n)
{
    if (n < MAGIC_BYTES)
        return 0;
    return memcmp(head, "DDS v3d\n", MAGIC_BYTES) == 0 ? 1 : memcmp(head, "DDS v3e\n", MAGIC_BYTES) == 0 ? 2 : 0;
}

/* Bits ---------------------------------------------------------------------------------------------------------------
 */

typedef struct bits {
    vv_source *source;
    uint8_t *input;
    size_t at, n;
    uint32_t held; /* the lowest n_held bits */
    int n_held;
    bool end; /* fewer bits than were asked for */
    vv_status status;
} bits;

static unsigned take(bits *b, int n)
{
    while (b->n_held < n && !b->end) {
        if (b->at == b->n) {
            b->at = 0;
            b->status = vvi_source_read_some(b->source, b->input, INPUT_ROOM, &b->n);
            b->end = b->status != VV_OK || b->n == 0;
            if (b->end)
                return 0;
        }
        b->held = b->held << 8 | b->input[b->at++];
        b->n_held += 8;
    }
    if (b->n_held < n)
        return 0; /* it had ended before */
    b->n_held -= n;
    return b->held >> b->n_held & ((1u << n) - 1);
}

/* Bytes --------------------------------------------------------------------------------------------------------------
 */

typedef struct output {
    uint8_t *bytes;
    size_t n, room;
    vv_job *job;
} output;

static vv_status make_room(output *o)
{
    if (o->n < o->room)
        return VV_OK;
    const size_t room = o->room ? o->room * 2 : INPUT_ROOM;
    uint8_t *grown = vvi_realloc(o->job, o->bytes, room, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(room);
    o->bytes = grown;
    o->room = room;
    return vvi_job_poll(o->job);
}

static uint8_t predicted(const output *o, size_t row)
{
    if (o->n == 0)
        return 0;
    const uint8_t before = o->bytes[o->n - 1];
    if (row == 1 || o->n <= row)
        return before;
    return (uint8_t)(before + o->bytes[o->n - row] - o->bytes[o->n - row - 1]);
}

static vv_status decode_runs(output *o, bits *b, size_t row)
{
    vv_status st = VV_OK;
    for (;;) {
        unsigned count = take(b, 7);
        if (b->end || count == 0)
            return b->status;
        const unsigned code = take(b, 3);
        const int width = code ? (int)code + 1 : 0;
        for (; count > 0; count--) {
            const unsigned stored = take(b, width), middle = width ? 1u << (width - 1) : 0;
            if (b->end)
                return b->status;
            if ((st = make_room(o)) != VV_OK)
                return st;
            o->bytes[o->n] = (uint8_t)(predicted(o, row) + stored - middle);
            o->n++;
        }
    }
}

/* From all first bytes, then all second ones, to samples. */
static void join(uint8_t *to, const uint8_t *from, size_t n, size_t sample_bytes)
{
    for (size_t part = 0; part < sample_bytes; part++)
        for (size_t at = part; at < n; at += sample_bytes)
            to[at] = *from++;
}

static vv_status join_samples(output *o, size_t sample_bytes, int version)
{
    const size_t piece = version == 1 ? o->n : PIECE_SAMPLES * sample_bytes;
    if (sample_bytes == 1 || o->n == 0)
        return VV_OK;
    uint8_t *joined = vvi_alloc(o->job, o->n, VVI_MEM_SCRATCH);
    if (!joined)
        return vv_fail_memory(o->n);
    for (size_t at = 0; at < o->n; at += piece)
        join(joined + at, o->bytes + at, o->n - at < piece ? o->n - at : piece, sample_bytes);
    vvi_free(o->bytes);
    o->bytes = joined;
    return VV_OK;
}

vv_status vvi_pvm_decode_dds(uint8_t **out, size_t *n_out, vv_source *source, int version, vv_job *job)
{
    bits b = {.source = source};
    output o = {.job = job};
    *out = NULL;
    *n_out = 0;
    vv_status st = vvi_source_seek(source, MAGIC_BYTES);
    if (st != VV_OK)
        return st;
    b.input = vvi_alloc(job, INPUT_ROOM, VVI_MEM_SCRATCH);
    if (!b.input)
        return vv_fail_memory(INPUT_ROOM);
    const size_t sample_bytes = take(&b, 2) + 1, row = take(&b, 16) + 1;
    st = decode_runs(&o, &b, row);
    if (st == VV_OK)
        st = join_samples(&o, sample_bytes, version);
    vvi_free(b.input);
    if (st != VV_OK) {
        vvi_free(o.bytes);
        return st;
    }
    *out = o.bytes;
    *n_out = o.n;
    return VV_OK;
}
