#include "io/xml.h"
#include "config.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include <string.h>

#if VV_HAVE_EXPAT
#include <expat.h>
#include <stdio.h>
#include <stdlib.h>

#define PIECE_BYTES (64 << 10)

struct vvi_xml {
    XML_Parser parser;
    const vvi_xml_events *events;
    void *user;
    vv_source *source;
    uint64_t start; /* of the document in the source */
    uint64_t told;  /* byte of the last event: a tag that never ends would be kept in memory */
    int depth;
    bool stopped;
    vv_status status;
};

static vv_status fail_here(const vvi_xml *xml, vv_status status, const char *text)
{
    char line[32];
    snprintf(line, sizeof line, "%lu", vvi_xml_line(xml));
    return vv_fail_at(status, vvi_source_name(xml->source), line, "%s", text);
}

static void take(vvi_xml *xml, vv_status st)
{
    xml->told = vvi_xml_end(xml);
    if (st != VV_OK && xml->status == VV_OK)
        xml->status = st;
    if (xml->status != VV_OK || xml->stopped)
        XML_StopParser(xml->parser, XML_FALSE);
}

/* expat may still tell the end of an empty element after it was stopped. */
static bool is_over(const vvi_xml *xml)
{
    return xml->stopped || xml->status != VV_OK;
}

static void XMLCALL on_open(void *user, const char *name, const char **attributes)
{
    vvi_xml *xml = user;
    vv_status st = VV_OK;
    if (is_over(xml))
        return;
    if ((uint64_t)++xml->depth > vvi_source_limits(xml->source)->nesting)
        st = fail_here(xml, VV_E_FORMAT, "its elements are nested too deeply; --limit nesting=N allows more");
    else if (xml->events->open)
        st = xml->events->open(xml->user, xml, name, (const char *const *)attributes);
    take(xml, st);
}

static void XMLCALL on_close(void *user, const char *name)
{
    vvi_xml *xml = user;
    if (is_over(xml))
        return;
    const vv_status st = xml->events->close ? xml->events->close(xml->user, xml, name) : VV_OK;
    xml->depth--;
    take(xml, st);
}

static void XMLCALL on_text(void *user, const char *text, int n)
{
    vvi_xml *xml = user;
    if (!is_over(xml))
        take(xml, xml->events->text ? xml->events->text(xml->user, xml, text, (size_t)n) : VV_OK);
}

static void XMLCALL on_doctype(void *user, const char *name, const char *system, const char *public, int internal)
{
    vvi_xml *xml = user;
    take(xml, fail_here(xml, VV_E_UNSUPPORTED, "declares a document type, which is never read; remove <!DOCTYPE"));
}

static void *small_alloc(size_t n)
{
    return vvi_calloc(1, n);
}

static void small_free(void *memory)
{
    free(memory);
}

uint64_t vvi_xml_begin(const vvi_xml *xml)
{
    return xml->start + (uint64_t)XML_GetCurrentByteIndex(xml->parser);
}

uint64_t vvi_xml_end(const vvi_xml *xml)
{
    return vvi_xml_begin(xml) + (uint64_t)XML_GetCurrentByteCount(xml->parser);
}

int vvi_xml_depth(const vvi_xml *xml)
{
    return xml->depth;
}

unsigned long vvi_xml_line(const vvi_xml *xml)
{
    return (unsigned long)XML_GetCurrentLineNumber(xml->parser);
}

void vvi_xml_stop(vvi_xml *xml)
{
    xml->stopped = true;
}

static bool ends_too_early(enum XML_Error code)
{
    return code == XML_ERROR_NO_ELEMENTS || code == XML_ERROR_UNCLOSED_TOKEN ||
           code == XML_ERROR_UNCLOSED_CDATA_SECTION || code == XML_ERROR_PARTIAL_CHAR;
}

static vv_status fail_broken(const vvi_xml *xml, enum XML_Error code)
{
    char text[160];
    snprintf(text, sizeof text, xml->depth > 0 ? "its XML is damaged here: %s" : "is not XML: %s",
             XML_ErrorString(code));
    return fail_here(xml, VV_E_FORMAT, text);
}

/* One piece of the file; *last when it was the last. */
static vv_status parse_piece(vvi_xml *xml, bool *cut_out, bool *last, vv_job *job)
{
    size_t n;
    void *room = XML_GetBuffer(xml->parser, PIECE_BYTES);
    if (!room)
        return vv_fail_memory(PIECE_BYTES);
    vv_status st = vvi_source_read_whole(xml->source, room, PIECE_BYTES, &n);
    if (st != VV_OK)
        return st;
    *last = n < PIECE_BYTES;
    const enum XML_Status parsed = XML_ParseBuffer(xml->parser, (int)n, *last);
    if (is_over(xml))
        return xml->status;
    if (parsed == XML_STATUS_ERROR) {
        const enum XML_Error code = XML_GetErrorCode(xml->parser);
        if (code == XML_ERROR_NO_MEMORY)
            return vv_fail_memory(PIECE_BYTES);
        if (!*last || !ends_too_early(code) || xml->depth == 0)
            return fail_broken(xml, code);
        *cut_out = true;
    }
    if (vvi_source_tell(xml->source) - xml->told > vvi_job_limits(job)->string_bytes + PIECE_BYTES)
        return fail_here(xml, VV_E_FORMAT,
                         "has a tag or comment that is too long to be read; --limit string_bytes=N allows more");
    return VV_OK;
}

vv_status vvi_xml_parse(bool *cut_out, vv_source *source, const vvi_xml_events *events, void *user, vv_job *job)
{
    static const XML_Memory_Handling_Suite memory = {small_alloc, vvi_realloc_plain, small_free};
    const uint64_t start = vvi_source_tell(source);
    vvi_xml xml = {.events = events, .user = user, .source = source, .start = start, .told = start};
    bool last = false;
    *cut_out = false;
    xml.parser = XML_ParserCreate_MM(NULL, &memory, NULL);
    if (!xml.parser)
        return vv_fail_memory(PIECE_BYTES);
    XML_SetUserData(xml.parser, &xml);
    XML_SetElementHandler(xml.parser, on_open, on_close);
    XML_SetCharacterDataHandler(xml.parser, on_text);
    XML_SetStartDoctypeDeclHandler(xml.parser, on_doctype);
    vv_status st = VV_OK;
    while (st == VV_OK && !last && !xml.stopped)
        if ((st = vvi_job_poll(job)) == VV_OK)
            st = parse_piece(&xml, cut_out, &last, job);
    XML_ParserFree(xml.parser);
    return st;
}

#else

vv_status vvi_xml_parse(bool *cut_out, vv_source *source, const vvi_xml_events *events, void *user, vv_job *job)
{
    *cut_out = false;
    return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL,
                      "is XML, which this build does not read; build it with expat (libexpat1-dev)");
}

uint64_t vvi_xml_begin(const vvi_xml *xml)
{
    return 0;
}

uint64_t vvi_xml_end(const vvi_xml *xml)
{
    return 0;
}

int vvi_xml_depth(const vvi_xml *xml)
{
    return 0;
}

unsigned long vvi_xml_line(const vvi_xml *xml)
{
    return 0;
}

void vvi_xml_stop(vvi_xml *xml)
{
}
#endif

const char *vvi_xml_attribute(const char *const *attributes, const char *name)
{
    for (; *attributes; attributes += 2)
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    return NULL;
}
