#include "io/formats/tiff/tiff_ome.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/scan.h"
#include "io/xml.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

typedef struct parsing {
    vvi_ome *ome;
    const char *part, *file_name;
    vv_notes *notes;
    vv_job *job;
    bool here, found; /* inside the image that is read; it was there */
    bool in_uuid;
    bool in_own;            /* annotations of VolVis itself */
    int own_key;            /* whose text is read; -1: none */
    char id[64], name[128]; /* of the image that is open */
    bool listed;            /* it is among the parts */
    size_t n_listed;
    char first_id[64], first_about[320];
    bool first_chosen;
} parsing;

static void copy(char *out, size_t room, const char *text)
{
    snprintf(out, room, "%s", text ? text : "");
    out[vvi_utf8_cut(out, strlen(out), room - 1)] = 0;
    vvi_text_clean(out);
}

static int64_t whole(const char *const *attributes, const char *name, int64_t otherwise)
{
    int64_t v;
    const char *end, *text = vvi_xml_attribute(attributes, name);
    return text && vvi_scan_int(&v, text, &end) ? v : otherwise;
}

static double real(const char *const *attributes, const char *name)
{
    double v;
    const char *end, *text = vvi_xml_attribute(attributes, name);
    return text && vvi_scan_real(&v, text, &end) && isfinite(v) && v > 0 ? v : 0;
}

/* Room for one more of items that double at powers of two. */
static vv_status grow(void **items, size_t n, size_t bytes, vv_job *job)
{
    if (n > 0 && (n & (n - 1)) != 0)
        return VV_OK;
    void *grown = vvi_realloc(job, *items, (n ? n * 2 : 1) * bytes, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory((n ? n * 2 : 1) * bytes);
    *items = grown;
    return VV_OK;
}

/* Elements ----------------------------------------------------------------------------------------------------------
 */

static void open_image(parsing *p, const char *const *attributes)
{
    copy(p->id, sizeof p->id, vvi_xml_attribute(attributes, "ID"));
    copy(p->name, sizeof p->name, vvi_xml_attribute(attributes, "Name"));
    p->listed = false;
    p->here = !p->found && (!p->part || strcmp(p->part, p->id) == 0 || strcmp(p->part, p->name) == 0);
    if (p->here) {
        p->found = true;
        memcpy(p->ome->id, p->id, sizeof p->id);
        memcpy(p->ome->name, p->name, sizeof p->name);
    }
    p->ome->n_images++;
}

/* A single image is no choice: it is listed when a second one comes. */
static vv_status list_part(parsing *p, const char *const *attributes)
{
    char about[320];
    const char *type = vvi_xml_attribute(attributes, "Type");
    vv_status st = VV_OK;
    snprintf(about, sizeof about,
             "%s%s%" PRId64 " x %" PRId64 " x %" PRId64 ", %" PRId64 " channels, %" PRId64 " frames, %.16s", p->name,
             p->name[0] ? ", " : "", whole(attributes, "SizeX", 0), whole(attributes, "SizeY", 0),
             whole(attributes, "SizeZ", 0), whole(attributes, "SizeC", 0), whole(attributes, "SizeT", 0),
             type ? type : "?");
    p->listed = true;
    if (p->n_listed++ == 0) {
        memcpy(p->first_id, p->id, sizeof p->id);
        memcpy(p->first_about, about, sizeof about);
        p->first_chosen = p->here;
        return VV_OK;
    }
    if (p->n_listed == 2)
        st = vvi_notes_part(p->notes, p->first_id, p->first_about, p->first_chosen);
    return st == VV_OK ? vvi_notes_part(p->notes, p->id, about, p->here) : st;
}

static void open_pixels(vvi_ome *ome, const char *const *attributes)
{
    static const char *const sizes[5] = {"SizeX", "SizeY", "SizeZ", "SizeC", "SizeT"};
    static const char *const steps[3] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    static const char *const units[3] = {"PhysicalSizeXUnit", "PhysicalSizeYUnit", "PhysicalSizeZUnit"};
    copy(ome->order, sizeof ome->order, vvi_xml_attribute(attributes, "DimensionOrder"));
    copy(ome->bits, sizeof ome->bits, vvi_xml_attribute(attributes, "SignificantBits"));
    for (int a = 0; a < 5; a++)
        ome->size[a] = whole(attributes, sizes[a], 1);
    for (int a = 0; a < 3; a++) {
        const char *unit = vvi_xml_attribute(attributes, units[a]);
        ome->step[a] = real(attributes, steps[a]);
        if (!unit)
            unit = "um";
        vvi_unit_name(ome->unit[a], unit, strlen(unit));
        vvi_text_clean(ome->unit[a]);
    }
    const char *unit = vvi_xml_attribute(attributes, "TimeIncrementUnit");
    ome->time_step = real(attributes, "TimeIncrement");
    vvi_unit_name(ome->time_unit, unit ? unit : "s", unit ? strlen(unit) : 1);
    vvi_text_clean(ome->time_unit);
}

/* Colours are R, G, B and alpha in one signed number, red highest. */
static vv_status open_channel(parsing *p, const char *const *attributes)
{
    vvi_ome *ome = p->ome;
    vv_status st = grow((void **)&ome->channels, ome->n_channels, sizeof *ome->channels, p->job);
    if (st != VV_OK)
        return st;
    vv_channel c = {.name = ""};
    copy(c.name, sizeof c.name, vvi_xml_attribute(attributes, "Name"));
    if (vvi_xml_attribute(attributes, "Color")) {
        const uint32_t v = (uint32_t)whole(attributes, "Color", -1);
        c.has_color = true;
        c.color = (vv_color){vv_srgb_decode((v >> 24) / 255.0), vv_srgb_decode((v >> 16 & 255) / 255.0),
                             vv_srgb_decode((v >> 8 & 255) / 255.0), 1};
    }
    ome->channels[ome->n_channels++] = c;
    return VV_OK;
}

static vv_status open_run(parsing *p, const char *const *attributes)
{
    vvi_ome *ome = p->ome;
    vv_status st = grow((void **)&ome->runs, ome->n_runs, sizeof *ome->runs, p->job);
    if (st != VV_OK)
        return st;
    const int64_t ifd = whole(attributes, "IFD", -1);
    ome->runs[ome->n_runs++] = (vvi_ome_run){
        .ifd = ifd,
        .first = {whole(attributes, "FirstC", 0), whole(attributes, "FirstZ", 0), whole(attributes, "FirstT", 0)},
        .n = whole(attributes, "PlaneCount", ifd >= 0 ? 1 : -1)};
    return VV_OK;
}

/* Names without the prefix of a name space. */
static const char *local(const char *name)
{
    const char *colon = strchr(name, ':');
    return colon ? colon + 1 : name;
}

static bool is_own(const char *name_space)
{
    return name_space && strcmp(name_space, "volvis") == 0;
}

static int own_key(const char *name)
{
    return name ? vvi_tiff_own_key(name) : -1;
}

static vv_status on_open(void *user, vvi_xml *xml, const char *name, const char *const *attributes)
{
    parsing *p = user;
    name = local(name);
    if (vvi_xml_depth(xml) > 16)
        return vv_fail_at(VV_E_FORMAT, p->file_name, NULL, "its OME-XML is nested too deeply");
    if (strcmp(name, "OME") == 0)
        copy(p->ome->uuid, sizeof p->ome->uuid, vvi_xml_attribute(attributes, "UUID"));
    else if (strcmp(name, "MapAnnotation") == 0)
        p->in_own = is_own(vvi_xml_attribute(attributes, "Namespace"));
    else if (p->in_own && strcmp(name, "M") == 0)
        p->own_key = own_key(vvi_xml_attribute(attributes, "K"));
    else if (strcmp(name, "BinaryOnly") == 0)
        copy(p->ome->companion, sizeof p->ome->companion, vvi_xml_attribute(attributes, "MetadataFile"));
    else if (strcmp(name, "Image") == 0)
        open_image(p, attributes);
    else if (strcmp(name, "Pixels") == 0 && !p->listed) {
        p->ome->has_pixels = true;
        if (p->here)
            open_pixels(p->ome, attributes);
        return list_part(p, attributes);
    } else if (p->here && strcmp(name, "Channel") == 0)
        return open_channel(p, attributes);
    else if (p->here && strcmp(name, "TiffData") == 0)
        return open_run(p, attributes);
    else if (p->here && strcmp(name, "UUID") == 0 && p->ome->n_runs > 0) {
        vvi_ome_run *run = &p->ome->runs[p->ome->n_runs - 1];
        snprintf(run->file, sizeof run->file, "%s",
                 vvi_xml_attribute(attributes, "FileName") ? vvi_xml_attribute(attributes, "FileName") : "");
        p->in_uuid = true;
    }
    return VV_OK;
}

static vv_status on_text(void *user, vvi_xml *xml, const char *text, size_t n)
{
    parsing *p = user;
    (void)xml;
    if (p->own_key >= 0)
        vvi_tiff_own_add(&p->ome->own, p->own_key, text, n);
    if (!p->in_uuid)
        return VV_OK;
    vvi_ome_run *run = &p->ome->runs[p->ome->n_runs - 1];
    const size_t at = strlen(run->uuid);
    for (size_t i = 0, to = at; i < n && to + 1 < sizeof run->uuid; i++)
        if ((unsigned char)text[i] > ' ')
            run->uuid[to++] = text[i];
    return VV_OK;
}

static vv_status on_close(void *user, vvi_xml *xml, const char *name)
{
    parsing *p = user;
    (void)xml;
    if (strcmp(local(name), "UUID") == 0)
        p->in_uuid = false;
    else if (strcmp(local(name), "M") == 0)
        p->own_key = -1;
    else if (strcmp(local(name), "MapAnnotation") == 0)
        p->in_own = false;
    else if (strcmp(local(name), "Image") == 0)
        p->here = false;
    return VV_OK;
}

void vvi_ome_free(vvi_ome *ome)
{
    vvi_free(ome->channels);
    vvi_free(ome->runs);
    *ome = (vvi_ome){0};
}

vv_status vvi_ome_parse(vvi_ome *ome, const char *text, size_t n, const char *part, vv_notes *notes,
                        const char *file_name, vv_job *job)
{
    static const vvi_xml_events events = {.open = on_open, .close = on_close, .text = on_text};
    parsing p = {.ome = ome, .part = part, .file_name = file_name, .notes = notes, .job = job, .own_key = -1};
    vv_source *source;
    bool cut;
    vv_status st = vvi_source_memory(&source, text, n, file_name, job);
    if (st != VV_OK)
        return st;
    st = vvi_xml_parse(&cut, source, &events, &p, job);
    vvi_source_close(source);
    ome->cut = cut;
    if (st == VV_OK && cut)
        vvi_job_damage(job, "io", "%s: its OME-XML is cut short: what it says after that is missing", file_name);
    if (st == VV_OK && part && !p.found && !ome->companion[0])
        return vvi_notes_fail_part(notes, VV_E_ARGUMENT, file_name, "image", part);
    return st;
}
