/* What OME-XML says beside planes: spacing, time, channels. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/formats/tiff/tiff_ome.h"
#include "io/placement.h"
#include "io/scan.h"
#include <stdio.h>
#include <string.h>

/* Steps in the unit of x; in y and z others may be said. */
static void set_spacing(vv_field_info *info, const vvi_ome *ome)
{
    vv_affine *a = &info->grid.index_to_world;
    const double x = vvi_length_unit_metres(ome->unit[0]);
    double step[3];
    if (!(ome->step[0] > 0) || strcmp(ome->unit[0], "pixel") == 0)
        return;
    for (int i = 0; i < 3; i++) {
        const double metres = vvi_length_unit_metres(ome->unit[i]);
        step[i] = ome->step[i] * (x > 0 && metres > 0 ? metres / x : 1);
        if (!(step[i] > 0))
            step[i] = step[0];
    }
    a->axis[0].x = step[0];
    a->axis[1].y = step[1];
    a->axis[2].z = step[2];
    snprintf(info->grid.unit, sizeof info->grid.unit, "%s", x > 0 ? ome->unit[0] : "units"); /* "reference frame" */
}

static vv_status tell_channels(const vvi_ome *ome, const vvi_tiff *t, vv_notes *notes)
{
    vv_status st = VV_OK;
    bool known = false;
    for (size_t i = 0; i < ome->n_channels; i++)
        known = known || ome->channels[i].name[0] || ome->channels[i].has_color;
    if (!known || ome->n_channels != (size_t)t->channels || t->pages[0].samples > 1)
        return VV_OK;
    for (size_t i = 0; i < ome->n_channels && st == VV_OK; i++)
        st = vvi_notes_channel(notes, &ome->channels[i]);
    return st;
}

static vv_status tell(vv_field_info *info, const vvi_ome *ome, const vvi_tiff *t, vv_notes *notes)
{
    vv_status st = VV_OK;
    set_spacing(info, ome);
    if (ome->time_step > 0 && t->frames > 1) {
        info->frame_step = ome->time_step;
        memcpy(info->frame_unit, ome->time_unit, sizeof info->frame_unit);
    }
    snprintf(info->name, sizeof info->name, "%.*s",
             (int)vvi_utf8_cut(ome->name, strlen(ome->name), sizeof info->name - 1), ome->name);
    if (st == VV_OK && ome->bits[0])
        st = vvi_notes_add(notes, "significant bits", ome->bits);
    return st == VV_OK ? tell_channels(ome, t, notes) : st;
}

/* The document lies in a file of its own, which all files of the set name. */
static vv_status parse_companion(vvi_ome *ome, vv_source *beside_of, const char *part, vv_notes *notes, vv_job *job)
{
    vv_source *source;
    char name[256];
    size_t n = 0;
    bool exact;
    memcpy(name, ome->companion, sizeof name);
    vv_status st = vvi_source_open_beside(&source, beside_of, name, job);
    if (st != VV_OK)
        return vv_fail_in(st, "the OME-XML of '%.200s'", vvi_source_name(beside_of));
    const uint64_t left = vvi_source_left(source, &exact), most = vvi_job_limits(job)->header_bytes;
    char *text = vvi_alloc(job, (size_t)(left < most ? left : most) + 1, VVI_MEM_SCRATCH);
    if (!text)
        st = vv_fail_memory((size_t)(left < most ? left : most));
    else if ((st = vvi_source_read_some(source, text, (size_t)(left < most ? left : most), &n)) == VV_OK) {
        vvi_ome_free(ome);
        st = vvi_ome_parse(ome, text, n, part, notes, name, job);
        snprintf(ome->companion, sizeof ome->companion, "%s", name);
    }
    vvi_free(text);
    vvi_source_close(source);
    return st;
}

static bool is_ome(const char *text, size_t n)
{
    const size_t look = n < 4096 ? n : 4096;
    return memmem(text, look, "<OME", 4) || memmem(text, look, ":OME ", 5);
}

/* By the name that OME asks for, or by the program that writes little else. */
static vv_status was_ome(bool *out, const vvi_tiff *t, const vvi_tiff_reader *r, vv_job *job)
{
    char *software = NULL;
    const vv_status st = vvi_tiff_text(&software, r, &t->pages[0].software, vvi_job_limits(job)->string_bytes);
    *out = strcasestr(vvi_source_name(r->source), ".ome.tif") || (software && strstr(software, "OME Bio-Formats"));
    vvi_free(software);
    return st;
}

/* Whoever wrote a text that is lost: it may say how the pages make a volume. Of OME it certainly did: pages by
 * themselves would be another volume. */
static vv_status tell_lost(const vvi_tiff *t, const vvi_tiff_reader *r, uint64_t lacks, vv_job *job)
{
    bool ome = false;
    const vv_status st = was_ome(&ome, t, r, job);
    if (st != VV_OK)
        return st;
    if (ome && t->n_pages > 1)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "is cut short: %llu bytes of its OME-XML are missing, which says how its %zu pages make "
                          "slices, channels and time steps; copy or download the file again",
                          (unsigned long long)lacks, t->n_pages);
    vvi_job_damage(job, "io",
                   "%s: is cut short: %llu bytes of its description are missing, and with them what it may say of "
                   "its channels, slices and time steps",
                   vvi_source_name(r->source), (unsigned long long)lacks);
    return VV_OK;
}

vv_status vvi_tiff_ome(bool *is_out, vv_field_info *info, vvi_tiff *t, const vvi_tiff_reader *r, const char *part,
                       vv_notes *notes, vv_job *job)
{
    char *text;
    uint64_t lacks;
    vvi_ome ome = {0};
    *is_out = false;
    vv_status st = vvi_tiff_text_there(&text, &lacks, r, &t->pages[0].description, vvi_job_limits(job)->header_bytes);
    const bool here = st == VV_OK && text && is_ome(text, strlen(text));
    if (st == VV_OK && !here && lacks > 1) /* more than its end */
        st = tell_lost(t, r, lacks, job);
    if (!here) {
        vvi_free(text);
        return st;
    }
    st = vvi_ome_parse(&ome, text, strlen(text), part, notes, vvi_source_name(r->source), job);
    vvi_free(text);
    if (st == VV_OK && ome.companion[0])
        st = parse_companion(&ome, r->source, part, notes, job);
    if (st == VV_OK && ome.cut && !ome.has_pixels)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                        "its OME-XML ends before it says what the samples are; copy or download the file again");
    *is_out = st == VV_OK && ome.n_images > 0;
    if (*is_out && (st = vvi_ome_planes(t, &ome, r->source, notes, job)) == VV_OK)
        st = tell(info, &ome, t, notes);
    if (ome.n_images == 1)
        t->own = ome.own;
    vvi_ome_free(&ome);
    return st;
}
