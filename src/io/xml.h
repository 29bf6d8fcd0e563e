/** @file
 * XML read from a source, tag by tag, with the place of each tag in the file: data between tags are read later, where
 * they lie. Document types are refused: nothing that is read needs entities, and they can grow without end.
 */
#ifndef VVI_IO_XML_H
#define VVI_IO_XML_H
#include "io/source.h"

typedef struct vvi_xml vvi_xml;

/** What is called for each tag, in order; a function may be NULL. A failure ends the parse with it. */
typedef struct vvi_xml_events {
    vv_status (*open)(void *user, vvi_xml *xml, const char *name, const char *const *attributes);
    vv_status (*close)(void *user, vvi_xml *xml, const char *name);
    /** Text between tags, in pieces; not what is in comments. */
    vv_status (*text)(void *user, vvi_xml *xml, const char *text, size_t n);
} vvi_xml_events;

/** From where the source stands. *cut_out: the file ends inside an element; what came before was told all the same.
 * Errors: VV_E_FORMAT with the line, VV_E_UNSUPPORTED when this build has no expat, what an event fails with. */
vv_status vvi_xml_parse(bool *cut_out, vv_source *source, const vvi_xml_events *events, void *user, vv_job *job);
/** The first byte of the tag or text that an event is about, and the first byte after it; counted as the source does.
 */
uint64_t vvi_xml_begin(const vvi_xml *xml);
uint64_t vvi_xml_end(const vvi_xml *xml);
/** How many elements are open, the one of the event included. */
int vvi_xml_depth(const vvi_xml *xml);
/** The line of the event, for errors. */
unsigned long vvi_xml_line(const vvi_xml *xml);
/** Inside an event: read no further. The parse is a success. */
void vvi_xml_stop(vvi_xml *xml);
/** The value of an attribute of an open event; NULL when it has none of that name. */
const char *vvi_xml_attribute(const char *const *attributes, const char *name);
#endif
