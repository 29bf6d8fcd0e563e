/* A source is a window on a store (or on another source) and, when it is coded, a decoder with what it keeps ahead.
 * Positions that callers see count decoded bytes. Large reads are decoded straight into the caller's memory. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/crc.h"
#include "io/coding.h"
#include "io/mapping.h"
#include "io/source_impl.h"
#include <stdio.h>
#include <string.h>

#define KEEP_AFTER ((uint64_t)64 << 20)

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

/* With either wrapper or without. */
static bool is_deflate(const vv_source *s)
{
    return s->coding == VVI_CODING_GZIP || s->coding == VVI_CODING_ZLIB || s->coding == VVI_CODING_DEFLATE;
}

static uint64_t expansion(const vv_source *s)
{
    const vv_limits *limits = vvi_job_limits(s->job);
    return is_deflate(s) ? limits->expansion_gzip : limits->expansion_zstd;
}

const char *vvi_source_expansion(const vv_source *s)
{
    return !s->decoder ? NULL : is_deflate(s) ? "expansion_gzip" : "expansion_zstd";
}

static void end_early(vv_source *s, vv_status status, const char *why)
{
    s->ended = true;
    s->problem_status = status;
    const size_t n = strnlen(why, sizeof s->problem - 1);
    memcpy(s->problem, why, n);
    s->problem[n] = 0;
}

vv_status vvi_source_fail(const vv_source *s)
{
    return vv_fail_at(s->problem_status, s->name, NULL, "after %llu bytes of %s data: %s",
                      (unsigned long long)s->decoded, vvi_coding_name(s->coding), s->problem);
}

static vv_status refill(vv_source *s)
{
    s->coded_at = s->coded_end = 0;
    return fetch(s, s->coded, VVI_SOURCE_WINDOW, &s->coded_end);
}

/* Between two members: another one follows, or the rest (padding of a tape, say) does not matter. */
static void next_member(vv_source *s)
{
    s->between = true;
    const vvi_coding next = vvi_coding_of(s->coded + s->coded_at, s->coded_end - s->coded_at);
    if (next != s->coding)
        s->ended = true;
    else if (!vvi_decoder_reset(s->decoder))
        end_early(s, VV_E_MEMORY, "not enough memory to go on");
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
    vv_status st = fetch(s, s->coded + have, VVI_SOURCE_WINDOW - have, &got);
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
            end_early(s, VV_E_FORMAT, "the file is cut short; get a complete copy");
        s->cut = s->problem[0] != 0;
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
    } else if (s->decoded > vvi_job_limits(s->job)->expansion_after && s->decoded / expansion(s) > consumed(s)) {
        char why[sizeof s->problem];
        snprintf(why, sizeof why, "expands more than any valid data; if it is genuine, --limit %s=N allows more",
                 vvi_source_expansion(s));
        end_early(s, VV_E_FORMAT, why);
    } else if (member_end) {
        if ((st = gather_member_head(s)) != VV_OK)
            return st;
        next_member(s);
    }
    return VV_OK;
}

/* Takes n more decoded bytes, from where nothing has been left out, into the sum of a guarded section. */
static void sum_up(vv_source *s, const uint8_t *data, size_t n)
{
    if (!s->guarded || s->decoded - n != s->summed)
        return;
    s->sum = vvi_crc32(s->sum, data, n, vvi_crc_has_fold());
    s->summed += n;
}

/* Its end was reached: what was seen of it, if all, is what it should be. */
static void check_sum(vv_source *s)
{
    char why[sizeof s->problem];
    if (!s->guarded || s->problem[0] || s->summed != s->decoded || s->sum == s->crc)
        return;
    snprintf(why, sizeof why, "their CRC-32 is %08x, and the file says %08x: they are damaged; get a complete copy",
             (unsigned)s->sum, (unsigned)s->crc);
    end_early(s, VV_E_FORMAT, why);
}

/* The next bytes in order, past whatever is kept ahead. */
static vv_status produce(vv_source *s, uint8_t *out, size_t n, size_t *n_out)
{
    vv_status st = VV_OK;
    *n_out = 0;
    if (!s->decoder) {
        st = fetch(s, out, n, n_out);
        s->decoded += *n_out;
        sum_up(s, out, *n_out);
        if (st == VV_OK && s->decoded == s->n)
            check_sum(s);
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
        sum_up(s, out + *n_out, made);
        *n_out += made;
    }
    if (s->ended)
        check_sum(s);
    return VV_OK;
}

void vvi_source_use_job(vv_source *source, vv_job *job)
{
    source->job = job;
}

const vv_limits *vvi_source_limits(const vv_source *source)
{
    return vvi_job_limits(source->job);
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

uint64_t vvi_source_window_bytes(vv_source *s, bool *exact)
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
    uint64_t all = vvi_source_window_bytes(s, exact);
    if (s->decoder) {
        *exact = s->ended || vvi_source_seen(s);
        if (*exact)
            return vvi_source_end(s) > s->at ? vvi_source_end(s) - s->at : 0;
        /* A coded stream in a coded file may not expand further than one alone: the caps are the same for both. */
        bool root_exact;
        vv_source *root = s;
        while (root->parent)
            root = root->parent;
        const uint64_t bytes = vvi_source_window_bytes(root, &root_exact);
        all = bytes > UINT64_MAX / expansion(s) ? UINT64_MAX : bytes * expansion(s);
        const uint64_t after = vvi_job_limits(s->job)->expansion_after;
        if (all < after && !is_deflate(s))
            all = after;
    }
    if (all == UINT64_MAX)
        return all;
    return all > s->at ? all - s->at : 0;
}

uint64_t vvi_source_end(const vv_source *s)
{
    if (s->decoder || (!s->parent && !s->store->seekable))
        return vvi_source_seen(s) ? s->ends_at : s->decoded;
    const uint64_t all = s->parent ? vvi_source_end(s->parent) : s->store->size,
                   there = all > s->start ? all - s->start : 0;
    return there < s->n ? there : s->n;
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
    *n_read = 0;
    vv_status st = vvi_source_hand(s, n);
    if (st != VV_OK)
        return st;
    *n_read = take_ahead(s, out, n);
    while (*n_read < n && st == VV_OK) {
        size_t got = 0;
        uint8_t *to = (uint8_t *)out + *n_read;
        s->ahead_at = s->ahead_end = 0; /* what was handed out from there is no longer just behind us */
        if (n - *n_read >= VVI_SOURCE_WINDOW / 2) {
            st = produce(s, to, n - *n_read, &got);
            s->at += got;
        } else {
            st = produce(s, s->ahead, VVI_SOURCE_WINDOW, &s->ahead_end);
            got = take_ahead(s, to, n - *n_read);
        }
        *n_read += got;
        if (got == 0)
            break;
    }
    if (st == VV_OK && *n_read == 0 && n > 0 && s->problem[0])
        return vvi_source_fail(s);
    return st;
}

vv_status vvi_source_read_whole(vv_source *s, void *out, size_t n, size_t *n_read)
{
    vv_status st = VV_OK;
    *n_read = 0;
    for (size_t got = 1; *n_read < n && got > 0; *n_read += got) {
        got = 0;
        st = vvi_source_read_some(s, (uint8_t *)out + *n_read, n - *n_read, &got);
        if (st != VV_OK)
            return s->cut ? VV_OK : st;
    }
    return st;
}

vv_status vvi_source_read(vv_source *s, void *out, size_t n, const char *what)
{
    size_t got;
    vv_status st = vvi_source_read_some(s, out, n, &got);
    if (st != VV_OK || got == n)
        return st;
    if (s->problem[0])
        return vvi_source_fail(s);
    return vv_fail_at(VV_E_FORMAT, s->name, NULL,
                      "ends after %llu bytes; %llu were expected for %s; the file is cut short or its header wrong",
                      (unsigned long long)s->at, (unsigned long long)(s->at - got + n), what);
}

vv_status vvi_source_skip(vv_source *s, uint64_t n)
{
    vv_status st = VV_OK;
    const size_t have = s->ahead_end - s->ahead_at;
    n -= take_ahead(s, NULL, n < have ? (size_t)n : have);
    const bool for_sum = s->guarded && s->summed == s->decoded && n <= VVI_SOURCE_WINDOW; /* a header, say */
    if (n > 0 && !s->decoder && !s->parent && s->store->seekable && !for_sum) {
        s->ahead_at = s->ahead_end = 0;
        s->fetched += n;
        s->decoded += n;
        s->at += n;
        return VV_OK; /* past the end shows when it is read */
    }
    while (n > 0 && st == VV_OK) {
        s->ahead_at = s->ahead_end = 0;
        st = produce(s, s->ahead, VVI_SOURCE_WINDOW, &s->ahead_end);
        const size_t got = take_ahead(s, NULL, n < s->ahead_end ? (size_t)n : s->ahead_end);
        if (got == 0)
            break;
        n -= got;
    }
    return st;
}

vv_status vvi_source_rewind(vv_source *s)
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
    s->cut = false;
    s->sum = 0;
    s->summed = 0;
    return VV_OK;
}

/* Who goes back again and again through much coded data is served from a temporary file. Where there can be none, the
 * data are unpacked once more. */
static bool kept_in_file(vv_source *s)
{
    if (!s->decoder || s->restarts < 0)
        return false;
    s->again += s->at;
    if (++s->restarts < 3 || s->again < KEEP_AFTER)
        return false;
    s->restarts = -1; /* spooling goes back as well; and it is tried once */
    return vvi_source_spool(s, s->job) == VV_OK;
}

vv_status vvi_source_seek(vv_source *s, uint64_t offset)
{
    if (offset < s->at && s->at - offset <= s->ahead_at) { /* still there */
        s->ahead_at -= (size_t)(s->at - offset);
        s->at = offset;
    }
    if (offset < s->at && !kept_in_file(s)) {
        const vv_status st = vvi_source_rewind(s);
        if (st != VV_OK)
            return st;
    }
    return offset > s->at ? vvi_source_skip(s, offset - s->at) : VV_OK;
}

const uint8_t *vvi_source_peek(vv_source *s, size_t n, size_t *n_there)
{
    *n_there = 0;
    size_t have = s->ahead_end - s->ahead_at;
    if (n > VVI_SOURCE_PEEK_MOST)
        n = VVI_SOURCE_PEEK_MOST;
    if (have < n) {
        size_t got = 0;
        memmove(s->ahead, s->ahead + s->ahead_at, have);
        vv_status st = produce(s, s->ahead + have, VVI_SOURCE_WINDOW - have, &got);
        s->ahead_at = 0;
        s->ahead_end = have += got;
        if (st != VV_OK)
            return NULL;
    }
    *n_there = have < n ? have : n;
    return s->ahead + s->ahead_at;
}

/* Mapping ------------------------------------------------------------------------------------------------------- */

bool vvi_source_mappable(const vv_source *s, uint64_t offset, uint64_t n)
{
    if (s->decoder || s->parent || s->guarded || s->store->fd < 0 || !s->store->seekable)
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
    vv_status st = vvi_mapping_new(out, data_out, guard_out, s->store->fd, s->start + offset, n, s->name, s->job);
    s->mapped = st == VV_OK ? *data_out : NULL;
    s->mapped_at = s->start + offset;
    return st;
}

bool vvi_source_mapped_at(const vv_source *s, const void *data, uint64_t *offset_out)
{
    *offset_out = s->mapped_at;
    return data && s->mapped == data;
}
