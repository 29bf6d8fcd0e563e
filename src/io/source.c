/* A source is a window on a store (or on another source) and, when it is coded, a decoder with what it keeps ahead.
 * Positions that callers see count decoded bytes. Large reads are decoded straight into the caller's memory. */
#include "io/source.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/coding.h"
#include "io/mapping.h"
#include "io/store.h"
#include <string.h>

const vvi_limits vvi_limits_default = {
    .dim = 1u << 20,
    .voxels = (uint64_t)1 << 40,
    .header_bytes = 16u << 20,
    .metadata_keys = 65536,
    .string_bytes = 1u << 20,
    .files = 65536,
    .expansion_gzip = 1100,
    .expansion_zstd = 20000,
};

/* Small expansions are never a bomb, however small the file is. */
#define EXPANSION_GRACE ((uint64_t)64 << 20)
#define WINDOW ((size_t)256 << 10)
#define PEEK_MOST 4096

struct vv_source {
    vvi_store *store;
    vv_source *parent; /* instead of reading the store; borrowed */
    vv_job *job;
    char *name;
    vvi_coding coding;
    vvi_decoder *decoder; /* NULL: uncoded */
    uint64_t start, n;    /* the window, in bytes of the store or of the parent; n UINT64_MAX: all */
    uint64_t fetched;     /* bytes taken from the window */
    uint64_t at;          /* the next byte handed out */
    uint64_t decoded;     /* bytes that the decoder has made */
    uint8_t *ahead;       /* decoded, not handed out: ahead[ahead_at .. ahead_end) */
    size_t ahead_at, ahead_end;
    uint8_t *coded; /* fetched, not decoded */
    size_t coded_at, coded_end;
    bool between;      /* at the start of the data or between two coded members */
    bool ended;        /* nothing more will be decoded */
    char problem[160]; /* why it ended too early; "" when it did not */
    vv_status problem_status;
    char *line;
    size_t line_room;
};

void vvi_source_close(vv_source *s)
{
    if (!s)
        return;
    vvi_decoder_free(s->decoder);
    vvi_store_release(s->store);
    vvi_free(s->name);
    vvi_free(s->ahead);
    vvi_free(s->coded);
    vvi_free(s->line);
    vvi_free(s);
}

/* Takes the store, also when it fails. */
static vv_status source_new(vv_source **out, vvi_store *store, const char *name, vv_job *job)
{
    *out = NULL;
    vv_source *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s) {
        vv_status st = vv_fail_memory(sizeof *s);
        vvi_store_release(store);
        return st;
    }
    const size_t n_name = strlen(name) + 1;
    s->store = store;
    s->job = job;
    s->n = UINT64_MAX;
    s->between = true;
    s->name = vvi_alloc(job, n_name, VVI_MEM_SCRATCH);
    s->ahead = vvi_alloc(job, WINDOW, VVI_MEM_SCRATCH);
    if (!s->name || !s->ahead) {
        vv_status st = vv_fail_memory(WINDOW);
        vvi_source_close(s);
        return st;
    }
    memcpy(s->name, name, n_name);
    *out = s;
    return VV_OK;
}

static vv_status use_coding(vv_source *s, vvi_coding coding)
{
    s->coding = coding;
    if (coding == VVI_CODING_NONE)
        return VV_OK;
    s->coded = vvi_alloc(s->job, WINDOW, VVI_MEM_SCRATCH);
    return s->coded ? vvi_decoder_new(&s->decoder, coding, s->job) : vv_fail_memory(WINDOW);
}

/* Bytes of the window, undecoded; *n_got less than n only at its end. */
static vv_status fetch(vv_source *s, void *out, size_t n, size_t *n_got)
{
    vv_status st;
    const uint64_t left = s->n - s->fetched;
    if (left < n)
        n = (size_t)left;
    if (!s->parent) {
        st = vvi_store_read(s->store, s->start + s->fetched, out, n, n_got, s->job);
    } else {
        *n_got = 0;
        st = vvi_source_seek(s->parent, s->start + s->fetched);
        if (st == VV_OK)
            st = vvi_source_read_some(s->parent, out, n, n_got);
    }
    s->fetched += *n_got;
    return st;
}

/* Undecoded bytes of the outermost store that were needed so far, for the ratio that tells a bomb. */
static uint64_t consumed(const vv_source *s)
{
    while (s->parent)
        s = s->parent;
    return s->fetched - (s->coded_end - s->coded_at);
}

static uint64_t expansion(const vv_source *s)
{
    return s->coding == VVI_CODING_GZIP ? vvi_limits_default.expansion_gzip : vvi_limits_default.expansion_zstd;
}

static void end_early(vv_source *s, vv_status status, const char *why)
{
    s->ended = true;
    s->problem_status = status;
    const size_t n = strnlen(why, sizeof s->problem - 1);
    memcpy(s->problem, why, n);
    s->problem[n] = 0;
}

static vv_status fail_with_problem(const vv_source *s)
{
    return vv_fail_at(s->problem_status, s->name, NULL, "after %llu bytes of %s data: %s",
                      (unsigned long long)s->decoded, vvi_coding_name(s->coding), s->problem);
}

static vv_status refill(vv_source *s)
{
    s->coded_at = s->coded_end = 0;
    return fetch(s, s->coded, WINDOW, &s->coded_end);
}

/* Between two members: another one follows, or the rest (padding of a tape, say) does not matter. */
static void next_member(vv_source *s)
{
    s->between = true;
    const vvi_coding next = vvi_coding_of(s->coded + s->coded_at, s->coded_end - s->coded_at);
    if (next != s->coding)
        s->ended = true;
    else if (!vvi_decoder_reset(s->decoder))
        end_early(s, VV_E_MEMORY, "no memory to go on");
}

/* A member may begin at the very end of what was fetched: its first bytes are wanted together. */
static vv_status gather_member_head(vv_source *s)
{
    const size_t have = s->coded_end - s->coded_at;
    if (have >= 10)
        return VV_OK;
    memmove(s->coded, s->coded + s->coded_at, have);
    s->coded_at = 0;
    size_t got;
    vv_status st = fetch(s, s->coded + have, WINDOW - have, &got);
    s->coded_end = have + got;
    return st;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the decoder writes there */
static vv_status decode_step(vv_source *s, uint8_t *out, size_t n, size_t *n_out)
{
    vv_status st;
    bool member_end;
    if (s->coded_at == s->coded_end && (st = refill(s)) != VV_OK)
        return st;
    if (s->coded_at == s->coded_end) {
        if (s->between)
            s->ended = true;
        else
            end_early(s, VV_E_FORMAT, "the file is cut short; get a whole copy");
        return VV_OK;
    }
    vvi_coding_step step = {s->coded + s->coded_at, s->coded_end - s->coded_at, out, n};
    const size_t had = step.n_in;
    const char *wrong = vvi_decoder_run(s->decoder, &step, &member_end);
    s->coded_at += had - step.n_in;
    s->between = false;
    *n_out = n - step.n_out;
    s->decoded += *n_out;
    if (wrong) {
        end_early(s, VV_E_FORMAT, wrong);
    } else if (s->decoded > EXPANSION_GRACE && s->decoded / expansion(s) > consumed(s)) {
        end_early(s, VV_E_FORMAT, "expands more than any honest data; if it is honest, decompress it first");
    } else if (member_end) {
        if ((st = gather_member_head(s)) != VV_OK)
            return st;
        next_member(s);
    }
    return VV_OK;
}

/* The next bytes in order, past whatever is kept ahead. */
static vv_status produce(vv_source *s, uint8_t *out, size_t n, size_t *n_out)
{
    vv_status st = VV_OK;
    *n_out = 0;
    if (!s->decoder) {
        st = fetch(s, out, n, n_out);
        s->decoded += *n_out;
        return st;
    }
    while (*n_out < n && !s->ended) {
        size_t made = 0;
        if ((st = vvi_job_poll(s->job)) != VV_OK)
            return st;
        /* Steps of a bounded size: cancel is seen, and a bomb is stopped soon after it shows. */
        const size_t most = n - *n_out < (size_t)4 << 20 ? n - *n_out : (size_t)4 << 20;
        if ((st = decode_step(s, out + *n_out, most, &made)) != VV_OK)
            return st;
        *n_out += made;
    }
    return VV_OK;
}

/* Opening ------------------------------------------------------------------------------------------------------- */

/* What was read to look at becomes the decoder's input. */
static vv_status decode_from_here(vv_source *s, vvi_coding coding)
{
    vv_status st = use_coding(s, coding);
    if (st != VV_OK)
        return st;
    s->coded_end = s->ahead_end;
    memcpy(s->coded, s->ahead, s->ahead_end);
    s->ahead_end = 0;
    s->decoded = 0;
    return VV_OK;
}

vv_status vvi_source_open(vv_source **out, const char *path, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    vv_status st = vvi_store_open(&store, path, job);
    if (st != VV_OK)
        return st;
    vv_source *s;
    if ((st = source_new(&s, store, store->name, job)) != VV_OK)
        return st;
    size_t n;
    const uint8_t *head = vvi_source_peek(s, 16, &n);
    const vvi_coding coding = head ? vvi_coding_of(head, n) : VVI_CODING_NONE;
    if (!head)
        st = vv_error_last()->status;
    else if (coding != VVI_CODING_NONE)
        st = decode_from_here(s, coding);
    if (st != VV_OK) {
        vvi_source_close(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

vv_status vvi_source_memory(vv_source **out, const void *data, size_t n, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    vv_status st = vvi_store_memory(&store, data, n, name, job);
    return st == VV_OK ? source_new(out, store, name, job) : st;
}

vv_status vvi_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    vv_status st = vvi_store_beside(&store, header->store, name, job);
    return st == VV_OK ? source_new(out, store, store->name, job) : st;
}

vv_status vvi_source_section(vv_source **out, vv_source *source, uint64_t offset, uint64_t n, vvi_coding coding,
                             vv_job *job)
{
    vv_source *s;
    *out = NULL;
    vv_status st = source_new(&s, vvi_store_retain(source->store), source->name, job);
    if (st != VV_OK)
        return st;
    const bool direct = !source->decoder && !source->parent && source->store->seekable;
    s->parent = direct ? NULL : source;
    s->start = direct ? source->start + offset : offset;
    if (s->start < offset || (direct && offset > source->n)) {
        vvi_source_close(s);
        return vv_fail_at(VV_E_FORMAT, source->name, NULL, "data should begin at byte %llu, past its end",
                          (unsigned long long)offset);
    }
    s->n = direct && source->n != UINT64_MAX && source->n - offset < n ? source->n - offset : n;
    if ((st = use_coding(s, coding)) != VV_OK) {
        vvi_source_close(s);
        return st;
    }
    *out = s;
    return VV_OK;
}

void vvi_source_use_job(vv_source *source, vv_job *job)
{
    source->job = job;
}

const char *vvi_source_name(const vv_source *source)
{
    return source->name;
}

uint64_t vvi_source_tell(const vv_source *source)
{
    return source->at;
}

/* How much there is ----------------------------------------------------------------------------------------------- */

/* Undecoded bytes of the window, from its start; an upper bound. */
static uint64_t window_bytes(vv_source *s, bool *exact)
{
    uint64_t there = s->store->size;
    *exact = !s->parent;
    if (s->parent) {
        const uint64_t left = vvi_source_left(s->parent, exact);
        there = left > UINT64_MAX - s->parent->at ? UINT64_MAX : left + s->parent->at;
    }
    if (there == UINT64_MAX) {
        *exact = false;
        return s->n;
    }
    there = there > s->start ? there - s->start : 0;
    return there < s->n ? there : s->n;
}

uint64_t vvi_source_left(vv_source *s, bool *exact)
{
    uint64_t all = window_bytes(s, exact);
    if (s->decoder) {
        *exact = s->ended;
        if (s->ended)
            return s->decoded - s->at;
        /* A coded stream in a coded file may not expand further than one alone: the caps are the same for both. */
        bool root_exact;
        vv_source *root = s;
        while (root->parent)
            root = root->parent;
        const uint64_t bytes = window_bytes(root, &root_exact);
        all = bytes > UINT64_MAX / expansion(s) ? UINT64_MAX : bytes * expansion(s);
        if (all < EXPANSION_GRACE && s->coding != VVI_CODING_GZIP)
            all = EXPANSION_GRACE;
    }
    if (all == UINT64_MAX)
        return all;
    return all > s->at ? all - s->at : 0;
}

/* Reading ------------------------------------------------------------------------------------------------------- */

static size_t take_ahead(vv_source *s, void *out, size_t n)
{
    const size_t have = s->ahead_end - s->ahead_at;
    if (n > have)
        n = have;
    if (n > 0 && out)
        memcpy(out, s->ahead + s->ahead_at, n);
    s->ahead_at += n;
    s->at += n;
    return n;
}

vv_status vvi_source_read_some(vv_source *s, void *out, size_t n, size_t *n_read)
{
    vv_status st = VV_OK;
    *n_read = take_ahead(s, out, n);
    while (*n_read < n && st == VV_OK) {
        size_t got = 0;
        uint8_t *to = (uint8_t *)out + *n_read;
        s->ahead_at = s->ahead_end = 0; /* what was handed out from there is no longer just behind us */
        if (n - *n_read >= WINDOW / 2) {
            st = produce(s, to, n - *n_read, &got);
            s->at += got;
        } else {
            st = produce(s, s->ahead, WINDOW, &s->ahead_end);
            got = take_ahead(s, to, n - *n_read);
        }
        *n_read += got;
        if (got == 0)
            break;
    }
    if (st == VV_OK && *n_read == 0 && n > 0 && s->problem[0])
        return fail_with_problem(s);
    return st;
}

vv_status vvi_source_read(vv_source *s, void *out, size_t n, const char *what)
{
    size_t got;
    vv_status st = vvi_source_read_some(s, out, n, &got);
    if (st != VV_OK || got == n)
        return st;
    if (s->problem[0])
        return fail_with_problem(s);
    return vv_fail_at(VV_E_FORMAT, s->name, NULL,
                      "ends after %llu bytes; %llu were expected for %s; the file is cut short or its header wrong",
                      (unsigned long long)s->at, (unsigned long long)(s->at - got + n), what);
}

vv_status vvi_source_skip(vv_source *s, uint64_t n)
{
    vv_status st = VV_OK;
    const size_t have = s->ahead_end - s->ahead_at;
    n -= take_ahead(s, NULL, n < have ? (size_t)n : have);
    if (n > 0 && !s->decoder && !s->parent && s->store->seekable) {
        s->ahead_at = s->ahead_end = 0;
        s->fetched += n;
        s->decoded += n;
        s->at += n;
        return VV_OK; /* past the end shows when it is read */
    }
    while (n > 0 && st == VV_OK) {
        s->ahead_at = s->ahead_end = 0;
        st = produce(s, s->ahead, WINDOW, &s->ahead_end);
        const size_t got = take_ahead(s, NULL, n < s->ahead_end ? (size_t)n : s->ahead_end);
        if (got == 0)
            break;
        n -= got;
    }
    return st;
}

static vv_status rewind_to_start(vv_source *s)
{
    if (!s->store->seekable)
        return vv_fail_at(VV_E_UNSUPPORTED, s->name, NULL,
                          "is a stream and cannot be read twice; save it to a file first");
    if (s->decoder && !vvi_decoder_reset(s->decoder))
        return vv_fail_memory(sizeof *s);
    s->fetched = s->at = s->decoded = 0;
    s->ahead_at = s->ahead_end = s->coded_at = s->coded_end = 0;
    s->between = true;
    s->ended = false;
    s->problem[0] = 0;
    return VV_OK;
}

vv_status vvi_source_seek(vv_source *s, uint64_t offset)
{
    if (offset < s->at && s->at - offset <= s->ahead_at) { /* still there */
        s->ahead_at -= (size_t)(s->at - offset);
        s->at = offset;
    }
    if (offset < s->at) {
        vv_status st = rewind_to_start(s);
        if (st != VV_OK)
            return st;
    }
    return offset > s->at ? vvi_source_skip(s, offset - s->at) : VV_OK;
}

const uint8_t *vvi_source_peek(vv_source *s, size_t n, size_t *n_there)
{
    *n_there = 0;
    size_t have = s->ahead_end - s->ahead_at;
    if (n > PEEK_MOST)
        n = PEEK_MOST;
    if (have < n) {
        size_t got = 0;
        memmove(s->ahead, s->ahead + s->ahead_at, have);
        vv_status st = produce(s, s->ahead + have, WINDOW - have, &got);
        s->ahead_at = 0;
        s->ahead_end = have += got;
        if (st != VV_OK)
            return NULL;
    }
    *n_there = have < n ? have : n;
    return s->ahead + s->ahead_at;
}

vvi_coding vvi_source_sniff(vv_source *source)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 16, &n);
    return head ? vvi_coding_of(head, n) : VVI_CODING_NONE;
}

vv_status vvi_source_check_end(vv_source *s)
{
    uint8_t more;
    size_t n;
    if (!s->decoder)
        return s->parent ? vvi_source_check_end(s->parent) : VV_OK;
    vv_status st = vvi_source_read_some(s, &more, 1, &n);
    return st == VV_OK && s->problem[0] ? fail_with_problem(s) : st;
}

/* Lines --------------------------------------------------------------------------------------------------------- */

static vv_status line_add(vv_source *s, size_t used, const uint8_t *from, size_t n)
{
    if (used + n + 1 > s->line_room) {
        const size_t room = (used + n + 1) * 2;
        char *grown = vvi_realloc(s->job, s->line, room, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room);
        s->line = grown;
        s->line_room = room;
    }
    if (n > 0)
        memcpy(s->line + used, from, n);
    s->line[used + n] = 0;
    return VV_OK;
}

vv_status vvi_source_line(vv_source *s, const char **line_out, size_t most, bool *end)
{
    vv_status st;
    size_t used = 0, there;
    *line_out = NULL;
    *end = false;
    for (bool whole = false; !whole;) {
        const uint8_t *head = vvi_source_peek(s, PEEK_MOST, &there);
        if (!head)
            return vv_error_last()->status;
        const uint8_t *stop = memchr(head, '\n', there);
        const size_t n = stop ? (size_t)(stop - head) : there;
        if (used + n > most)
            return vv_fail_at(VV_E_FORMAT, s->name, NULL, "a line has more than %zu bytes; this is no text header",
                              most);
        if ((st = line_add(s, used, head, n)) != VV_OK)
            return st;
        used += n;
        whole = stop || there == 0;
        *end = !stop && there == 0 && used == 0;
        if ((st = vvi_source_skip(s, n + (stop != NULL))) != VV_OK)
            return st;
    }
    if (*end && s->problem[0])
        return fail_with_problem(s);
    if (used > 0 && s->line[used - 1] == '\r')
        s->line[--used] = 0;
    *line_out = s->line;
    return VV_OK;
}

/* Mapping ------------------------------------------------------------------------------------------------------- */

bool vvi_source_mappable(const vv_source *s, uint64_t offset, uint64_t n)
{
    if (s->decoder || s->parent || s->store->fd < 0 || !s->store->seekable)
        return false;
    if (offset > s->n || n > s->n - offset || offset > UINT64_MAX - s->start)
        return false;
    const uint64_t at = s->start + offset;
    return at <= s->store->size && n <= s->store->size - at;
}

vv_status vvi_source_map(vvi_mapping **out, const void **data_out, size_t *guard_out, vv_source *s, uint64_t offset,
                         uint64_t n)
{
    *out = NULL;
    if (!vvi_source_mappable(s, offset, n))
        return vv_fail_at(VV_E_UNSUPPORTED, s->name, NULL, "bytes %llu to %llu are not plain bytes of a file",
                          (unsigned long long)offset, (unsigned long long)(offset + n));
    return vvi_mapping_new(out, data_out, guard_out, s->store->fd, s->start + offset, n, s->name, s->job);
}
