/* Whether coded data are what was written: checksums stand at their end, and what is read of them may lie before. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/source_impl.h"
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* What data may cost before they are known to be whole is 64 MiB and twice the file. Windows and states are in it; of
 * bzip2 and zstd there are two of up to 8 MiB. */
#define UNPROVEN_BYTES ((uint64_t)55 << 20)
#define UNPROVEN_BYTES_ANEW ((uint64_t)40 << 20)
#define UNPROVEN_TIMES 2
/* Unpacked in half a second, with zlib in two. */
#define REST_MOST ((uint64_t)512 << 20)

/* The one with the decoder; NULL: the bytes come as they lie. */
static vv_source *coded(vv_source *s)
{
    while (!s->decoder && s->parent)
        s = s->parent;
    return s->decoder ? s : NULL;
}

void vvi_source_follow(vv_source *source, unsigned follow)
{
    source->follow = follow;
}

/* Proving -------------------------------------------------------------------------------------------------------- */

/* With buffers and a decoder of its own. Where that cannot begin where the other stands, it begins at the start. */
static vv_status stand_aside(vv_source *s)
{
    const vv_source was = *s;
    s->ahead = s->coded = NULL;
    s->decoder = NULL;
    s->restarts = -1; /* no temporary file takes the place of what both read */
    s->ahead = vvi_alloc(s->job, VVI_SOURCE_WINDOW, VVI_MEM_SCRATCH);
    if (!s->ahead)
        return vv_fail_memory(VVI_SOURCE_WINDOW);
    memcpy(s->ahead, was.ahead, VVI_SOURCE_WINDOW);
    if (!was.decoder)
        return VV_OK;
    s->coded = vvi_alloc(s->job, VVI_SOURCE_WINDOW, VVI_MEM_SCRATCH);
    if (!s->coded)
        return vv_fail_memory(VVI_SOURCE_WINDOW);
    memcpy(s->coded, was.coded, VVI_SOURCE_WINDOW);
    vv_status st = vvi_decoder_copy(&s->decoder, was.decoder, s->job);
    if (st != VV_OK || s->decoder)
        return st;
    st = vvi_decoder_new(&s->decoder, s->coding, s->job);
    return st == VV_OK ? vvi_source_rewind(s) : st;
}

typedef struct proof {
    vv_source *source;
    uint64_t ends_at;
    bool cut;
} proof;

/* At its end. */
static vv_status judge(proof *p)
{
    const vv_source *s = p->source;
    if (s->problem[0] && !s->cut)
        return vvi_source_fail(s);
    p->ends_at = s->decoded;
    p->cut = s->cut;
    return VV_OK;
}

static vv_status go_to_end(proof *p)
{
    const vv_status st = vvi_source_skip(p->source, UINT64_MAX - p->source->at);
    return st == VV_OK ? judge(p) : st;
}

/* Goes there with `s`, one of those that the source stands on, and with those below it, and leaves all as they were. */
static vv_status go_aside(vv_source *s, proof *p)
{
    const vv_source was = *s;
    vv_status st = stand_aside(s);
    if (st == VV_OK)
        st = s->parent ? go_aside(s->parent, p) : go_to_end(p);
    vvi_free(s->ahead);
    vvi_free(s->coded);
    vvi_decoder_free(s->decoder);
    *s = was;
    return st;
}

/* What is proven of a file need not be proven again when it is opened anew ----------------------------------------- */

/* Not by anybody who may write to it: the system alone sets the time of the last change. */
static bool identify(vvi_cache_key *out, const vv_source *s)
{
    struct stat about;
    if (s->parent || s->store->fd < 0 || !s->store->seekable || fstat(s->store->fd, &about) != 0)
        return false;
    const int64_t parts[] = {(int64_t)about.st_dev, (int64_t)about.st_ino, about.st_size, about.st_ctim.tv_sec,
                             about.st_ctim.tv_nsec, (int64_t)s->start,     (int64_t)s->n, s->coding};
    *out = (vvi_cache_key){"proven", 0, vvi_hash(parts, sizeof parts, 0)};
    return true;
}

static vv_status prove(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    proof *p = user;
    (void)job;
    *value_out = NULL;
    *bytes_out = 0;
    const vv_status st = go_aside(p->source, p);
    if (st != VV_OK || p->cut)
        return st != VV_OK ? st : VV_E_FORMAT; /* told by who asked, and not to be remembered */
    uint64_t *ends_at = vvi_alloc(NULL, sizeof *ends_at, VVI_MEM_DERIVED); /* counted by nobody, and never shed */
    if (!ends_at)
        return vv_fail_memory(sizeof *ends_at);
    *ends_at = p->ends_at;
    *value_out = ends_at;
    return VV_OK;
}

/* VV_OK also where it is cut. */
static vv_status prove_once(vv_source *s)
{
    vvi_cache_key key;
    vvi_cached *entry = NULL;
    proof p = {s, 0, false};
    const vv_status st = s->ended            ? judge(&p)
                         : identify(&key, s) ? vvi_cache_get(&entry, &key, prove, vvi_free, &p, s->job)
                                             : go_aside(s, &p);
    s->ends_at = entry ? *(const uint64_t *)vvi_cached_value(entry) : p.ends_at;
    vvi_cache_release(entry);
    s->proven_cut = p.cut;
    s->proven |= st == VV_OK && !p.cut;
    return p.cut ? VV_OK : st;
}

/* What is not there ------------------------------------------------------------------------------------------------ */

void vvi_source_bear(vv_source *source, vvi_lack *lack)
{
    source->lack = lack;
}

vv_status vvi_source_lacks(const vv_source *source, vv_status checked)
{
    if (checked != VV_E_FORMAT || !source->lack)
        return checked;
    if (!source->lack->sentence[0])
        snprintf(source->lack->sentence, sizeof source->lack->sentence, "%s", vv_error_last()->message);
    return VV_OK;
}

/* Before and after samples are read -------------------------------------------------------------------------------- */

/* How much may be held of it before it is proven. */
static uint64_t unproven_most(vv_source *s)
{
    bool exact;
    const vv_source *c = s;
    while (s->parent) /* packed twice: what the file has of it */
        s = s->parent;
    const uint64_t packed = vvi_source_window_bytes(s, &exact);
    const bool copies = vvi_coding_copies(c->coding);
    const uint64_t least = copies ? UNPROVEN_BYTES : UNPROVEN_BYTES_ANEW;
    return packed < (UINT64_MAX - least) / UNPROVEN_TIMES ? least + UNPROVEN_TIMES * packed : UINT64_MAX;
}

static vv_status prove_before(vv_source *s, uint64_t bytes)
{
    const bool known = vvi_source_seen(s) || (s->ended && !s->problem[0]) || !s->store->seekable;
    return bytes <= UNPROVEN_BYTES_ANEW || known || bytes <= unproven_most(s) ? VV_OK : prove_once(s);
}

vv_status vvi_source_hold(vv_source *source, uint64_t bytes, bool *seen_out)
{
    vv_source *s = coded(source);
    *seen_out = false;
    if (!s)
        return VV_OK;
    s->told = true;
    const vv_status st = prove_before(s, bytes);
    *seen_out = vvi_source_seen(s);
    return st;
}

static vv_status count(vv_source *s, uint64_t n)
{
    s->handed = n > UINT64_MAX - s->handed ? UINT64_MAX : s->handed + n;
    return prove_before(s, s->handed);
}

vv_status vvi_source_hand(vv_source *s, uint64_t n)
{
    return !s->decoder || s->told ? VV_OK : count(s, n);
}

void vvi_source_need(vv_source *source, uint64_t bytes)
{
    source->needed = bytes < UINT64_MAX - source->at ? source->at + bytes : UINT64_MAX;
}

vv_status vvi_source_grow(vv_source *source, uint64_t bytes)
{
    vv_source *s = coded(source);
    if (!s)
        return VV_OK;
    s->told = true;
    const vv_status st = count(s, bytes);
    const bool short_of = s->proven_cut || (s->proven && s == source && s->ends_at < s->needed);
    return st != VV_OK || !short_of
               ? st
               : vv_fail_at(VV_E_FORMAT, s->name, NULL,
                            "after %llu bytes of %s data: the file is cut short; get a complete copy",
                            (unsigned long long)s->ends_at, vvi_coding_name(s->coding));
}

vv_status vvi_source_check_end(vv_source *s)
{
    uint8_t more;
    size_t n;
    if (s->problem[0])
        return vvi_source_fail(s);
    if (!s->decoder)
        return s->parent ? vvi_source_check_end(s->parent) : VV_OK;
    vv_status st = vvi_source_read_some(s, &more, 1, &n);
    if (st == VV_OK && n > 0 && !s->ended && s->store->seekable) /* something else lies between */
        st = vvi_source_skip(s, REST_MOST);
    return st == VV_OK && s->problem[0] ? vvi_source_fail(s) : st;
}

vv_status vvi_source_check_tail(vv_source *s)
{
    while (!s->decoder && s->parent)
        s = s->parent;
    const vv_status st = vvi_source_check_end(s);
    if (st == VV_OK || !s->cut)
        return st;
    vvi_job_damage(s->job, "io", "%s: is cut short: all numbers are there, but not the checksum after them", s->name);
    return VV_OK;
}

static void warn_unproven(const vv_source *s)
{
    vvi_job_warn(s->job, "io",
                 "%s: was read up to byte %llu of its %s data; the checksum comes later and was not looked at: 'volvis "
                 "convert' checks all of it",
                 s->name, (unsigned long long)s->at, vvi_coding_name(s->coding));
}

vv_status vvi_source_check_rest(vv_source *s, bool frame_ends, uint64_t rest)
{
    if (s->follow & (frame_ends ? VVI_FOLLOW_FRAMES : VVI_FOLLOW_SLABS))
        return VV_OK;
    if (!(s = coded(s)) || s->proven)
        return VV_OK;
    const bool short_way = s->ended || rest <= REST_MOST;
    const vv_status st = !short_way || !s->store->seekable ? VV_OK : prove_once(s);
    if (st != VV_OK)
        return st;
    if (s->cut || s->proven_cut)
        vvi_job_damage(
            s->job, "io",
            "%s: is cut short: what was read of it is there, but not the checksum at its end, which would tell "
            "whether that is right",
            s->name);
    else if (!s->proven)
        warn_unproven(s);
    return VV_OK;
}

void vvi_source_tell_unproven(vv_source *s, vv_job *job)
{
    s = coded(s->kept ? s->kept : s);
    if (!s || s->proven || s->ended || s->decoded == 0)
        return;
    s->job = job;
    warn_unproven(s);
}
