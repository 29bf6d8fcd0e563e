/* Opening sources: by path, of memory, beside a header, a part of another, from a temporary copy. */
#include "core/job.h"
#include "core/memory.h"
#include "io/source_impl.h"
#include "io/spool.h"
#include <string.h>

void vvi_source_close(vv_source *s)
{
    if (!s)
        return;
    vvi_source_close(s->kept);
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
    s->ahead = vvi_alloc(job, VVI_SOURCE_WINDOW, VVI_MEM_SCRATCH);
    if (!s->name || !s->ahead) {
        vv_status st = vv_fail_memory(VVI_SOURCE_WINDOW);
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
    s->coded = vvi_alloc(s->job, VVI_SOURCE_WINDOW, VVI_MEM_SCRATCH);
    return s->coded ? vvi_decoder_new(&s->decoder, coding, s->job) : vv_fail_memory(VVI_SOURCE_WINDOW);
}

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

/* Takes the store, also when it fails. */
static vv_status open_store(vv_source **out, vvi_store *store, vv_job *job)
{
    vv_source *s;
    vv_status st = source_new(&s, store, store->name, job);
    if (st != VV_OK)
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

vv_status vvi_source_open_input(vv_source **out, const char *path, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    const vv_status st = vvi_store_open(&store, path, job);
    return st == VV_OK ? open_store(out, store, job) : st;
}

vv_status vvi_source_open(vv_source **out, const char *path, vv_job *job)
{
    vv_status st = vvi_source_open_input(out, path, job);
    if (st == VV_OK && (*out)->store->folder) {
        vvi_source_close(*out);
        *out = NULL;
        st = vv_fail_at(VV_E_READ, path, NULL, "is a folder; name a file in it");
    }
    return st;
}

vv_status vvi_source_memory(vv_source **out, const void *data, size_t n, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    vv_status st = vvi_store_memory(&store, data, n, name, job);
    return st == VV_OK ? source_new(out, store, name, job) : st;
}

static void inherit(vv_source *s, const vv_source *from)
{
    s->follow = from->follow;
    s->lack = from->lack;
}

static vv_status of_header(vv_status st, vv_source **out, const vv_source *header)
{
    if (st == VV_OK)
        inherit(*out, header);
    return st;
}

vv_status vvi_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    const vv_status st = vvi_store_beside(&store, header->store, name, job);
    return st == VV_OK ? of_header(source_new(out, store, store->name, job), out, header) : st;
}

vv_status vvi_source_open_input_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    const vv_status st = vvi_store_beside(&store, header->store, name, job);
    return st == VV_OK ? of_header(open_store(out, store, job), out, header) : st;
}

vv_status vvi_source_find_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    const vv_status st = vvi_store_find_beside(&store, header->store, name, job);
    return st == VV_OK && store ? of_header(source_new(out, store, store->name, job), out, header) : st;
}

vv_status vvi_source_open_folder_of(vv_source **out, const vv_source *file, vv_job *job)
{
    vvi_store *store;
    *out = NULL;
    const vv_status st = vvi_store_folder_of(&store, file->store, job);
    return st == VV_OK && store ? source_new(out, store, store->name, job) : st;
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
        return vv_fail_at(VV_E_FORMAT, source->name, NULL, "data should begin at byte %llu, past the end of the file",
                          (unsigned long long)offset);
    }
    inherit(s, source);
    s->n = direct && source->n != UINT64_MAX && source->n - offset < n ? source->n - offset : n;
    if ((st = use_coding(s, coding)) != VV_OK) {
        vvi_source_close(s);
        return st;
    }
    source->told |= coding != VVI_CODING_NONE; /* what it hands out is unpacked again and not kept */
    *out = s;
    return VV_OK;
}

void vvi_source_guard(vv_source *section, uint32_t crc)
{
    section->guarded = true;
    section->crc = crc;
}

void vvi_source_keep(vv_source *source, vv_source *section)
{
    vvi_source_close(source->kept);
    source->kept = section;
}

vv_source *vvi_source_kept(vv_source *source, vv_job *job)
{
    vv_source *kept = source->kept;
    source->kept = NULL;
    if (kept)
        kept->job = job;
    return kept;
}

vvi_coding vvi_source_sniff(vv_source *source)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 16, &n);
    return head ? vvi_coding_of(head, n) : VVI_CODING_NONE;
}

const char *vvi_source_path(const vv_source *source)
{
    if (source->decoder || source->parent || source->start > 0 || !source->store->seekable)
        return NULL;
    return source->store->open_path;
}

static vv_status next_of_source(void *source, void *out, size_t room, size_t *n, vv_job *job)
{
    (void)job; /* the source has its own */
    return vvi_source_read_some(source, out, room, n);
}

static void become(vv_source *s, vvi_store *store)
{
    vvi_decoder_free(s->decoder);
    vvi_store_release(s->store);
    vvi_free(s->coded);
    s->store = store;
    s->parent = NULL;
    s->coding = VVI_CODING_NONE;
    s->decoder = NULL;
    s->coded = NULL;
    s->start = s->fetched = s->at = s->decoded = 0;
    s->n = UINT64_MAX;
    s->ahead_at = s->ahead_end = s->coded_at = s->coded_end = 0;
    s->between = true;
    s->ended = false;
    s->guarded = false; /* all of it has gone through its sum */
    s->proven_cut = false;
}

vv_status vvi_source_spool(vv_source *s, vv_job *job)
{
    vvi_spool spool;
    if (vvi_source_path(s) || (s->store->memory && !s->decoder && !s->parent))
        return vvi_source_seek(s, 0);
    vv_status st = vvi_source_seek(s, 0);
    if (st != VV_OK || (st = vvi_spool_begin(&spool, s->name, job)) != VV_OK)
        return st;
    if ((st = vvi_spool_fill(&spool, next_of_source, s, job)) == VV_OK && s->problem[0])
        st = vvi_source_fail(s);
    if (st == VV_OK)
        st = vvi_store_measure(spool.store);
    if (st != VV_OK) {
        vvi_store_release(spool.store);
        return st;
    }
    become(s, spool.store);
    return VV_OK;
}

vv_status vvi_source_make_repeatable(vv_source *source, vv_job *job)
{
    return vvi_store_make_repeatable(source->store, job);
}

void vvi_source_begin_samples(vv_source *source)
{
    vvi_store_forget_head(source->store);
}

bool vvi_source_is_folder(const vv_source *source)
{
    return source->store->folder;
}

vv_status vvi_source_list(vvi_names *out, const vv_source *folder, const char *below, bool deep, vv_job *job)
{
    return vvi_store_list(out, folder->store, below, deep, job);
}

vv_status vvi_source_list_folders(vvi_names *out, const vv_source *folder, const char *below, vv_job *job)
{
    return vvi_store_list_folders(out, folder->store, below, job);
}
