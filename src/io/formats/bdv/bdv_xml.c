/* The .xml of BigDataViewer (SpimData): names, spacing and channels of the views, and the file of their samples. */
#include "config.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/formats/bdv/bdv.h"
#include "io/scan.h"
#include <stdio.h>
#include <string.h>
#if VV_HAVE_EXPAT
#include <expat.h>

#define DEPTH_MOST 32
#define TEXT_MOST 512

typedef struct reading {
    XML_Parser parser;
    vvi_bdv_views *views;
    char name[DEPTH_MOST][24]; /* of the elements around */
    int depth;
    char text[TEXT_MOST];
    size_t n_text;
} reading;

static bool is_in(const reading *r, int up, const char *name)
{
    return r->depth > up && strcmp(r->name[r->depth - 1 - up], name) == 0;
}

static void begin(void *user, const XML_Char *name, const XML_Char **attributes)
{
    reading *r = user;
    if (r->depth == DEPTH_MOST) {
        XML_StopParser(r->parser, XML_FALSE);
        return;
    }
    snprintf(r->name[r->depth++], sizeof r->name[0], "%.23s", name);
    r->n_text = 0;
    if (is_in(r, 0, "ViewSetup") && is_in(r, 1, "ViewSetups") && r->views->n < VVI_BDV_SETUPS)
        r->views->setup[r->views->n++] = (vvi_bdv_setup){.channel = -1};
    if (is_in(r, 0, "Channel") && is_in(r, 1, "Attributes") && r->views->n_channels < VVI_BDV_SETUPS)
        r->views->channel[r->views->n_channels++] = (vvi_bdv_channel){.id = -1};
    if (is_in(r, 0, "ImageLoader"))
        for (; *attributes; attributes += 2)
            if (strcmp(attributes[0], "format") == 0)
                snprintf(r->views->loader, sizeof r->views->loader, "%.31s", attributes[1]);
}

static void add_text(void *user, const XML_Char *text, int n)
{
    reading *r = user;
    for (int i = 0; i < n && r->n_text + 1 < TEXT_MOST; i++)
        r->text[r->n_text++] = text[i];
}

static void take_attribute(vvi_bdv_setup *setup, const char *name, const char *text)
{
    int64_t value;
    const char *end;
    if (!vvi_scan_int(&value, text, &end))
        return;
    if (strcmp(name, "channel") == 0)
        setup->channel = value;
    else if (strcmp(name, "angle") == 0 || strcmp(name, "tile") == 0 || strcmp(name, "illumination") == 0)
        setup->others += (value & 0xffff) << (name[0] == 'a' ? 0 : name[0] == 't' ? 16 : 32);
}

static void take_setup(vvi_bdv_setup *setup, const reading *r)
{
    const char *text = r->text, *end;
    double v[3];
    if (is_in(r, 1, "ViewSetup") && is_in(r, 0, "id"))
        vvi_scan_int(&setup->id, text, &end);
    else if (is_in(r, 1, "ViewSetup") && is_in(r, 0, "name"))
        snprintf(setup->name, sizeof setup->name, "%.63s", text);
    else if (is_in(r, 1, "attributes"))
        take_attribute(setup, r->name[r->depth - 1], text);
    else if (is_in(r, 1, "voxelSize") && is_in(r, 0, "unit"))
        vvi_unit_name(setup->unit, text, strlen(text));
    else if (is_in(r, 1, "voxelSize") && is_in(r, 0, "size") && vvi_scan_number(&v[0], text, &text) &&
             vvi_scan_number(&v[1], text, &text) && vvi_scan_number(&v[2], text, &text))
        memcpy(setup->voxel, v, sizeof v);
}

/* A name that is the number alone names nothing. */
static void take_channel(vvi_bdv_channel *channel, const reading *r)
{
    const char *end;
    if (is_in(r, 0, "id"))
        vvi_scan_int(&channel->id, r->text, &end);
    else if (is_in(r, 0, "name") && r->text[strspn(r->text, "0123456789")])
        snprintf(channel->name, sizeof channel->name, "%.63s", r->text + strspn(r->text, " \t\r\n"));
}

/* Setups are named as their channels are, where these have names. */
static void name_setups(vvi_bdv_views *views)
{
    for (int i = 0; i < views->n; i++)
        for (int c = 0; c < views->n_channels; c++)
            if (views->channel[c].id == views->setup[i].channel && views->channel[c].name[0])
                memcpy(views->setup[i].name, views->channel[c].name, sizeof views->setup[i].name);
}

static void end(void *user, const XML_Char *name)
{
    reading *r = user;
    (void)name;
    while (r->n_text > 0 && strchr(" \t\r\n", r->text[r->n_text - 1]))
        r->n_text--;
    r->text[r->n_text] = 0;
    if (is_in(r, 0, "hdf5") && is_in(r, 1, "ImageLoader"))
        snprintf(r->views->file, sizeof r->views->file, "%.255s", r->text + strspn(r->text, " \t\r\n"));
    if (is_in(r, 1, "Channel") && is_in(r, 2, "Attributes") && r->views->n_channels > 0)
        take_channel(&r->views->channel[r->views->n_channels - 1], r);
    for (int up = 1; up < r->depth && r->views->n > 0; up++)
        if (is_in(r, up, "ViewSetup"))
            take_setup(&r->views->setup[r->views->n - 1], r);
    r->depth--;
    r->n_text = 0;
}

/* Files of this kind declare none; those that do mean to grow. */
static void refuse_entity(void *user, const XML_Char *name, int is_parameter, const XML_Char *value, int n,
                          const XML_Char *base, const XML_Char *system, const XML_Char *public,
                          const XML_Char *notation)
{
    (void)name;
    (void)is_parameter;
    (void)value;
    (void)n;
    (void)base;
    (void)system;
    (void)public;
    (void)notation;
    XML_StopParser(((reading *)user)->parser, XML_FALSE);
}

static vv_status parse(reading *r, vv_source *xml, vv_job *job)
{
    uint64_t total = 0;
    for (;;) {
        char piece[4096];
        size_t n;
        vv_status st = vvi_source_read_some(xml, piece, sizeof piece, &n);
        if (st != VV_OK)
            return st;
        if ((total += n) > vvi_job_limits(job)->header_bytes)
            return vv_fail_at(VV_E_LIMIT, vvi_source_name(xml), NULL,
                              "is too long for an .xml of views; --limit header_bytes=N allows more");
        if (XML_Parse(r->parser, piece, (int)n, n == 0) != XML_STATUS_OK)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(xml), NULL, "line %lu is not BigDataViewer XML: %s",
                              (unsigned long)XML_GetCurrentLineNumber(r->parser),
                              XML_ErrorString(XML_GetErrorCode(r->parser)));
        if (n == 0)
            return VV_OK;
    }
}

vv_status vvi_bdv_read_views(vvi_bdv_views *out, vv_source *xml, vv_job *job)
{
    reading r = {.views = out, .parser = XML_ParserCreate(NULL)};
    *out = (vvi_bdv_views){0};
    if (!r.parser)
        return vv_fail_memory(1);
    XML_SetUserData(r.parser, &r);
    XML_SetElementHandler(r.parser, begin, end);
    XML_SetCharacterDataHandler(r.parser, add_text);
    XML_SetEntityDeclHandler(r.parser, refuse_entity);
    vv_status st = parse(&r, xml, job);
    XML_ParserFree(r.parser);
    name_setups(out);
    vvi_text_clean(out->loader);
    return st;
}
#else
vv_status vvi_bdv_read_views(vvi_bdv_views *out, vv_source *xml, vv_job *job)
{
    (void)job;
    *out = (vvi_bdv_views){0};
    return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(xml), NULL, "is XML; this build has no expat to read it");
}
#endif
