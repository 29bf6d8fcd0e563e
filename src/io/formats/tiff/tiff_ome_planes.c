/* From OME-XML's directories of files to planes of the volume. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff_ome.h"
#include <stdio.h>
#include <string.h>

/* A file that holds planes: its pages are [first, first + n) of the plan's. */
typedef struct ome_file {
    char name[256];
    size_t first, n;
    bool missing;
} ome_file;

typedef struct mapping {
    vvi_tiff *tiff;
    const vvi_ome *ome;
    vv_source *source;
    vv_notes *notes;
    vv_job *job;
    ome_file *files;
    size_t n_files, n_missing;
    int64_t size[3]; /* c z t */
    int order[3];    /* which of them goes fastest */
} mapping;

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static vv_status copy_name(char **out, const char *name, vv_job *job)
{
    const size_t n = strlen(name) + 1;
    *out = vvi_alloc(job, n, VVI_MEM_MODEL);
    if (!*out)
        return vv_fail_memory(n);
    memcpy(*out, name, n);
    return VV_OK;
}

/* The plan's table of names has one entry a file; the source itself has none (NULL). */
static vv_status add_file(mapping *m, const char *name)
{
    vvi_tiff *t = m->tiff;
    const size_t room = m->n_files + 1;
    ome_file *files = vvi_realloc(m->job, m->files, room * sizeof *files, VVI_MEM_SCRATCH);
    char **names = files ? vvi_realloc(m->job, t->files, room * sizeof *names, VVI_MEM_MODEL) : NULL;
    m->files = files ? files : m->files;
    t->files = names ? names : t->files;
    if (!names)
        return vv_fail_memory(room * sizeof *files);
    ome_file *f = &files[m->n_files];
    *f = (ome_file){.first = t->n_pages};
    snprintf(f->name, sizeof f->name, "%s", name);
    names[m->n_files] = NULL;
    t->n_files = ++m->n_files;
    return *name ? copy_name(&names[m->n_files - 1], name, m->job) : VV_OK;
}

static vv_status open_file(mapping *m, ome_file *f)
{
    vvi_tiff_reader r;
    vv_source *source;
    const bool cut = m->tiff->cut;
    if (m->n_files > vvi_job_limits(m->job)->files)
        return vv_fail_at(VV_E_LIMIT, vvi_source_name(m->source), NULL,
                          "names more than %llu files; --limit files=N allows more",
                          (unsigned long long)vvi_job_limits(m->job)->files);
    vv_status st = vvi_source_open_beside(&source, m->source, f->name, m->job);
    if (st == VV_OK && (st = vvi_source_spool(source, m->job)) == VV_OK)
        st = vvi_tiff_read_pages(m->tiff, &r, source, (uint32_t)(m->n_files - 1), m->job);
    vvi_source_close(source);
    m->tiff->cut = cut;
    f->n = m->tiff->n_pages - f->first;
    if (st != VV_E_READ && st != VV_E_FORMAT)
        return st;
    f->missing = true;
    f->n = 0;
    m->tiff->n_pages = f->first;
    if (++m->n_missing > 256)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(m->source), NULL,
                          "hundreds of files that its OME-XML names are not beside it");
    return m->n_missing > 8 ? VV_OK : vvi_notes_warn(m->notes, "planes are missing: %s", vv_error_last()->message);
}

static bool is_self(const mapping *m, const vvi_ome_run *run)
{
    return !run->file[0] || strcmp(run->file, base_name(vvi_source_name(m->source))) == 0 ||
           (run->uuid[0] && strcmp(run->uuid, m->ome->uuid) == 0);
}

/* The only file that is named is the file itself, under an older name. */
static bool is_renamed(const mapping *m)
{
    for (size_t i = 0; i < m->ome->n_runs; i++)
        if (strcmp(m->ome->runs[i].file, m->ome->runs[0].file) != 0 || is_self(m, &m->ome->runs[i]))
            return false;
    return !m->ome->companion[0];
}

static vv_status find_file(const ome_file **out, mapping *m, const vvi_ome_run *run, bool renamed)
{
    *out = &m->files[0];
    if (renamed || is_self(m, run))
        return VV_OK;
    for (size_t i = m->n_files; i-- > 1;)
        if (strcmp(m->files[i].name, run->file) == 0) {
            *out = &m->files[i];
            return VV_OK;
        }
    vv_status st = add_file(m, run->file);
    if (st == VV_OK)
        st = open_file(m, &m->files[m->n_files - 1]);
    *out = &m->files[m->n_files - 1];
    return st;
}

/* Planes go on as DimensionOrder says from the first of a run. */
static vv_status place_run(mapping *m, const vvi_ome_run *run, const ome_file *f)
{
    const int64_t *n = m->size;
    const int *o = m->order;
    int64_t at[3], first = run->ifd > 0 ? run->ifd : 0;
    int64_t count = run->n >= 0 ? run->n : (int64_t)f->n - first;
    memcpy(at, run->first, sizeof at);
    for (int a = 0; a < 3; a++)
        if (at[a] < 0 || at[a] >= n[a])
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(m->source), NULL,
                              "its OME-XML places a plane at %c = %lld of %lld", "CZT"[a], (long long)at[a],
                              (long long)n[a]);
    for (int64_t i = 0; i < count && first + i < (int64_t)f->n; i++) {
        m->tiff->planes[(at[2] * n[1] + at[1]) * n[0] + at[0]] = (uint32_t)(f->first + (size_t)(first + i));
        int a = 0;
        while (a < 3 && ++at[o[a]] == n[o[a]])
            at[o[a++]] = 0;
        if (a == 3)
            break;
    }
    return VV_OK;
}

static vv_status find_axes(mapping *m)
{
    const vvi_ome *ome = m->ome;
    const char *name = vvi_source_name(m->source);
    static const char letters[] = "CZT";
    if (strlen(ome->order) != 5 || strncmp(ome->order, "XY", 2) != 0 || !strchr(ome->order, 'Z') ||
        !strchr(ome->order, 'C') || !strchr(ome->order, 'T'))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "its OME-XML has the DimensionOrder '%s'; 'XYZCT' or the like was "
                          "expected",
                          ome->order);
    for (int a = 0; a < 3; a++)
        m->order[a] = (int)(strchr(letters, ome->order[2 + a]) - letters);
    const int64_t most = (int64_t)vvi_job_limits(m->job)->dim;
    for (int a = 0; a < 5; a++)
        if (ome->size[a] < 1 || ome->size[a] > most)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "its OME-XML gives Size%c as %lld; 1 to %lld are allowed (--limit dim=N allows more)",
                              "XYZCT"[a], (long long)ome -> size[a], (long long)most);
    const int64_t samples = m->tiff->pages[0].samples;
    m->size[0] = samples > 1 && ome->size[3] % samples == 0 ? ome->size[3] / samples : ome->size[3];
    m->size[1] = ome->size[2];
    m->size[2] = ome->size[4];
    return VV_OK;
}

static vv_status map_runs(mapping *m)
{
    const vvi_ome_run whole = {.ifd = -1, .n = -1};
    const bool renamed = m->ome->n_runs > 0 && is_renamed(m);
    vv_status st = VV_OK;
    if (m->ome->n_runs == 0)
        return place_run(m, &whole, &m->files[0]);
    for (size_t i = 0; i < m->ome->n_runs && st == VV_OK; i++) {
        const ome_file *f = NULL;
        if ((st = find_file(&f, m, &m->ome->runs[i], renamed)) == VV_OK)
            st = place_run(m, &m->ome->runs[i], f);
        if (st == VV_OK && i % 256 == 0)
            st = vvi_job_poll(m->job);
    }
    return st;
}

/* Pages of other sizes cannot be planes of this image. */
static vv_status check_planes(mapping *m, size_t n)
{
    vvi_tiff *t = m->tiff;
    const vvi_tiff_page *first = NULL;
    size_t others = 0, missing = 0;
    for (size_t i = 0; i < n; i++) {
        const vvi_tiff_page *p = t->planes[i] == VVI_TIFF_NO_PAGE ? NULL : &t->pages[t->planes[i]];
        if (p && !first && p->width == m->ome->size[0] && p->height == m->ome->size[1]) {
            vv_status st = vvi_tiff_check_page(p, m->source);
            if (st != VV_OK)
                return st;
            first = p;
        }
        if (p && (!first || !vvi_tiff_same_kind(p, first) || vvi_tiff_check_page(p, m->source) != VV_OK)) {
            others++;
            t->planes[i] = VVI_TIFF_NO_PAGE;
        }
        missing += t->planes[i] == VVI_TIFF_NO_PAGE;
    }
    if (!first || missing > n / 2)
        return vv_fail_at(
            VV_E_FORMAT, vvi_source_name(m->source), NULL,
            "%zu of the %zu planes that its OME-XML promises are there, with %lld x %lld pixels, less than "
            "half%s",
            n - missing, n, (long long)m->ome->size[0], (long long)m->ome->size[1],
            m->n_missing > 0 ? "; other files of the set should be next to it" : "");
    return others > 0
               ? vvi_notes_warn(m->notes, "%zu pages have another size or type than the image and are left out", others)
               : VV_OK;
}

vv_status vvi_ome_planes(vvi_tiff *t, const vvi_ome *ome, vv_source *source, vv_notes *notes, vv_job *job)
{
    mapping m = {.tiff = t, .ome = ome, .source = source, .notes = notes, .job = job};
    vv_status st = find_axes(&m);
    if (st != VV_OK)
        return st;
    const uint64_t cz = (uint64_t)m.size[0] * (uint64_t)m.size[1], most = vvi_job_limits(job)->voxels;
    if (cz > ((uint64_t)32 << 20) / (uint64_t)m.size[2] || cz * (uint64_t)m.size[2] > most)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "its OME-XML promises too many planes");
    const size_t n = (size_t)cz * (size_t)m.size[2];
    t->planes = vvi_alloc(job, n * sizeof *t->planes, VVI_MEM_MODEL);
    if (!t->planes)
        return vv_fail_memory(n * sizeof *t->planes);
    for (size_t i = 0; i < n; i++)
        t->planes[i] = VVI_TIFF_NO_PAGE;
    if ((st = add_file(&m, "")) == VV_OK) {
        m.files[0].first = 0;
        m.files[0].n = t->n_pages;
        st = map_runs(&m);
    }
    t->channels = m.size[0];
    t->slices = m.size[1];
    t->frames = m.size[2];
    if (st == VV_OK)
        st = check_planes(&m, n);
    vvi_free(m.files);
    return st;
}
