/* Whether coded data are what was written: checksums stand at their end, and what is read of them may lie before. */
#include "core/cache.h"
#include "core/job.h"
#include "io/source_impl.h"
#include <stdio.h>
#include <sys/stat.h>

/* What strangers' files may cost before they are known to be whole: this much, and twice their size. Others, which are
 * read twice in hardly more time than once where they unpack to so many times their size. */
#define UNPROVEN_BYTES ((uint64_t)64 << 20)
#define UNPROVEN_TIMES_STRANGE 2
#define UNPROVEN_TIMES 32
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

void vvi_source_distrust(vv_source *source)
{
    source->strange = true;
}

/* All of it, once, from where it stands. */
static vv_status go_to_end(vv_source *s)
{
    const vv_status st = vvi_source_skip(s, UINT64_MAX - s->at);
    if (st != VV_OK)
        return st;
    if (s->problem[0] && !s->cut)
        return vvi_source_fail(s);
    s->proven = !s->cut;
    return VV_OK;
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
    vv_source *s = user;
    (void)job;
    *value_out = NULL;
    *bytes_out = 0;
    const vv_status st = go_to_end(s);
    return st == VV_OK && s->cut ? VV_E_FORMAT : st; /* told by who asked, and not to be remembered */
}

/* VV_OK also where it is cut. */
static vv_status prove_once(vv_source *s)
{
    vvi_cache_key key;
    vvi_cached *entry;
    if (!identify(&key, s))
        return go_to_end(s);
    const vv_status st = vvi_cache_get(&entry, &key, prove, NULL, s, s->job);
    vvi_cache_release(entry);
    s->proven |= st == VV_OK;
    return s->cut ? VV_OK : st;
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

vv_status vvi_source_prove(vv_source *s, uint64_t bytes)
{
    bool exact;
    if (!(s = coded(s)) || (s->parent && !s->strange) || s->proven || !s->store->seekable)
        return VV_OK;
    vv_source *root = s; /* packed twice: what the file has of it */
    while (root->parent)
        root = root->parent;
    const uint64_t packed = vvi_source_window_bytes(root, &exact), at = s->at;
    const uint64_t times = s->strange ? UNPROVEN_TIMES_STRANGE : UNPROVEN_TIMES;
    if (bytes <= UNPROVEN_BYTES || (bytes - UNPROVEN_BYTES) / times <= packed)
        return VV_OK;
    const vv_status st = prove_once(s);
    return st == VV_OK ? vvi_source_seek(s, at) : st;
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
    if (s->cut)
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
