/* What ImageJ writes into the description of the first page: one "key=value" a line.
 * https://imagej.net/ij/developer/source/ij/io/TiffDecoder.java.html and FileInfo, FileOpener.getNextStack. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/formats/tiff/tiff.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define OWN "volvis_" /* keys of VolVis itself */

typedef struct imagej {
    int64_t images, channels, slices, frames;
    double spacing, interval, origin[3];
    char unit[16];
} imagej;

/* The value of a key at the start of a line; NULL when it is not there. */
static const char *find_line(const char *text, const char *key)
{
    const size_t n = strlen(key);
    for (const char *at = text; at; at = strchr(at, '\n')) {
        if (*at == '\n')
            at++;
        if (strncmp(at, key, n) == 0 && at[n] == '=')
            return at + n + 1;
    }
    return NULL;
}

static int64_t find_count(const char *text, const char *key, int64_t most)
{
    int64_t n;
    const char *end, *at = find_line(text, key);
    return at && vvi_scan_int(&n, at, &end) && n >= 1 && n <= most ? n : 1;
}

static double find_real(const char *text, const char *key)
{
    double v;
    const char *end, *at = find_line(text, key);
    return at && vvi_scan_real(&v, at, &end) && isfinite(v) ? v : 0;
}

/* "micron", "um", "\u00B5m" (as ImageJ escapes it), "pixel". */
static void find_unit(char out[16], const char *text)
{
    const char *at = find_line(text, "unit");
    const size_t n = at ? strcspn(at, "\r\n") : 0;
    if (n == 0)
        return;
    if ((n == 7 && strncmp(at, "\\u00B5m", 7) == 0) || (n == 2 && (uint8_t)at[0] == 0xb5 && at[1] == 'm'))
        snprintf(out, 16, "um");
    else
        vvi_unit_name(out, at, n);
    vvi_text_clean(out);
}

static void parse(imagej *j, const char *text, int64_t most)
{
    *j = (imagej){.images = find_count(text, "images", most),
                  .channels = find_count(text, "channels", most),
                  .slices = find_count(text, "slices", most),
                  .frames = find_count(text, "frames", most),
                  .spacing = fabs(find_real(text, "spacing")),
                  .interval = find_real(text, "finterval")};
    find_unit(j->unit, text);
    if (j->channels * j->slices * j->frames == 1)
        j->slices = j->images;
}

static vv_status copy_lines(const char *text, vv_notes *notes)
{
    vv_status st = VV_OK;
    while (*text && st == VV_OK) {
        char line[256];
        const size_t n = strcspn(text, "\r\n"), m = n < sizeof line - 1 ? n : sizeof line - 1;
        memcpy(line, text, m);
        line[m] = 0;
        vvi_text_clean(line);
        char *value = strchr(line, '=');
        if (value && value > line && strncmp(line, OWN, sizeof OWN - 1) != 0) {
            *value++ = 0;
            st = vvi_notes_add(notes, line, value);
        }
        text += n + strspn(text + n, "\r\n");
    }
    return st;
}

static void find_own(vvi_tiff_own *own, const char *text)
{
    for (int k = 0; k < VVI_TIFF_OWN_KEYS; k++) {
        char key[32];
        snprintf(key, sizeof key, OWN "%s", vvi_tiff_own_keys[k]);
        const char *at = find_line(text, key);
        if (at)
            vvi_tiff_own_add(own, k, at, strcspn(at, "\r\n"));
    }
}

/* Stacks beyond 4 GiB have one directory; the other pages follow the first without gaps. */
static vv_status add_pages(vvi_tiff *tiff, const imagej *j, const vvi_tiff_reader *r)
{
    const vvi_tiff_page first = tiff->pages[0];
    const uint64_t bytes = vvi_tiff_chunk_row_bytes(&first) * first.height, n = (uint64_t)j->images;
    if (tiff->n_pages != 1 || n == 1 || first.compression != VVI_TIFF_PLAIN || first.tiled || first.planar != 1 ||
        first.offsets.first > r->n_bytes || bytes < 1 || (r->n_bytes - first.offsets.first) / bytes < n / 2)
        return VV_OK;
    vvi_tiff_page *pages = vvi_realloc(r->job, tiff->pages, (size_t)n * sizeof *pages, VVI_MEM_MODEL);
    uint32_t *planes = pages ? vvi_realloc(r->job, tiff->planes, (size_t)n * sizeof *planes, VVI_MEM_MODEL) : NULL;
    tiff->pages = pages ? pages : tiff->pages;
    tiff->planes = planes ? planes : tiff->planes;
    if (!planes)
        return vv_fail_memory((size_t)n * sizeof *pages);
    for (uint64_t i = 0; i < n; i++) {
        pages[i] = first;
        pages[i].chunk_height = first.height;
        pages[i].offsets.n = 1;
        pages[i].offsets.first = first.offsets.first + i * bytes;
        pages[i].counts.n = 0;
        planes[i] = (uint32_t)i;
    }
    tiff->n_pages = tiff->room_pages = (size_t)n;
    tiff->slices = (int64_t)n;
    return VV_OK;
}

/* The description tells how many pages there should be where the chain of directories breaks off. */
static vv_status add_missing(vvi_tiff *tiff, const vvi_tiff_reader *r, int64_t there, int64_t told)
{
    if (there < told - there)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "is cut short or damaged: %lld of %lld pages are there, less than half", (long long)there,
                          (long long)told);
    uint32_t *planes = vvi_realloc(r->job, tiff->planes, (size_t)told * sizeof *planes, VVI_MEM_MODEL);
    if (!planes)
        return vv_fail_memory((size_t)told * sizeof *planes);
    tiff->planes = planes;
    for (int64_t i = there; i < told; i++)
        planes[i] = VVI_TIFF_NO_PAGE;
    tiff->cut = false; /* what is missing is told when it is read */
    return VV_OK;
}

static vv_status set_axes(vvi_tiff *tiff, const imagej *j, const vvi_tiff_reader *r, vv_notes *notes)
{
    const int64_t there = tiff->slices;
    const double product = (double)j->channels * (double)j->slices * (double)j->frames;
    const int64_t told = product < 1e9 ? j->channels * j->slices * j->frames : INT32_MAX;
    vv_status st = VV_OK;
    if (told > there && tiff->cut)
        st = add_missing(tiff, r, there, told);
    else if (told != there)
        return vvi_notes_warn(notes,
                              "ImageJ tells of %lld channels x %lld slices x %lld frames, but %lld pages are there; "
                              "they are read as slices",
                              (long long)j->channels, (long long)j->slices, (long long)j->frames, (long long)there);
    tiff->channels = j->channels;
    tiff->slices = j->slices;
    tiff->frames = j->frames;
    return st;
}

/* Pixels a unit along x and y, in the unit of the description, whatever ResolutionUnit says. */
static void set_spacing(vv_field_info *info, const imagej *j, const vvi_tiff_page *p)
{
    vv_affine *a = &info->grid.index_to_world;
    const bool pixels = j->unit[0] == 0 || strcmp(j->unit, "pixel") == 0 || strcmp(j->unit, "pixels") == 0;
    const bool known = p->resolution[0] > 0 && p->resolution[1] > 0 && !pixels;
    a->axis[0].x = known ? 1 / p->resolution[0] : 1;
    a->axis[1].y = known ? 1 / p->resolution[1] : 1;
    a->axis[2].z = j->spacing > 0 ? j->spacing : a->axis[0].x;
    if (!pixels)
        snprintf(info->grid.unit, sizeof info->grid.unit, "%s", j->unit);
    else if (j->spacing > 0 && j->spacing != 1)
        snprintf(info->grid.unit, sizeof info->grid.unit, "units");
}

/* Seconds, unless another unit is said. */
static void set_time(vv_field_info *info, const imagej *j, const char *text)
{
    const char *unit = find_line(text, "tunit");
    const size_t n = unit ? strcspn(unit, "\r\n") : 0;
    info->frame_step = j->interval > 0 ? j->interval : 0;
    if (info->frame_step > 0)
        vvi_unit_name(info->frame_unit, n > 0 ? unit : "s", n > 0 ? n : 1);
    vvi_text_clean(info->frame_unit);
}

/* The value of a key, as much as fits; nothing where it is not there. */
static void copy_line(char *out, size_t room, const char *text, const char *key)
{
    const char *at = find_line(text, key);
    const size_t n = at ? strcspn(at, "\r\n") : 0;
    snprintf(out, room, "%.*s", (int)vvi_utf8_cut(at ? at : "", n, room - 1), at ? at : "");
    vvi_text_clean(out);
}

/* Values on a straight line (cf=0): c0 + c1 * sample. */
static void set_values(vv_field_info *info, const char *text)
{
    const char *kind = find_line(text, "cf");
    const double scale = find_real(text, "c1");
    if (kind && *kind == '0' && scale != 0) {
        info->value_scale = scale;
        info->value_offset = find_real(text, "c0");
    }
    copy_line(info->value_unit, sizeof info->value_unit, text, "vunit");
    if (strncasecmp(info->value_unit, "Gray Value", 10) == 0)
        info->value_unit[0] = 0;
}

vv_status vvi_tiff_imagej(bool *is_out, vv_field_info *info, vvi_tiff *tiff, const vvi_tiff_reader *r, vv_notes *notes,
                          vv_job *job)
{
    char *text;
    imagej j;
    const vvi_tiff_page page = tiff->pages[tiff->planes[0]];
    vv_status st = vvi_tiff_text(&text, r, &page.description, vvi_job_limits(job)->string_bytes);
    (void)job;
    *is_out = st == VV_OK && text && strncmp(text, "ImageJ=", 7) == 0;
    if (*is_out) {
        parse(&j, text, (int64_t)vvi_job_limits(job)->dim);
        set_spacing(info, &j, &page);
        set_time(info, &j, text);
        set_values(info, text);
        find_own(&tiff->own, text);
        copy_line(info->name, sizeof info->name, text, "name"); /* our own: ImageJ has the file's */
        if ((st = copy_lines(text, notes)) == VV_OK && (st = add_pages(tiff, &j, r)) == VV_OK)
            st = set_axes(tiff, &j, r, notes);
        if (st == VV_OK)
            st = vvi_tiff_imagej_extras(info, tiff, &page, r, notes);
    }
    vvi_free(text);
    return st;
}
