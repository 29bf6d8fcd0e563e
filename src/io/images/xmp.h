/** @file
 * Texts of an image as an XMP packet (ISO 16684-1), which TIFF, WebP and PDF hold: "VolVis:Scene" is the property Scene
 * of the name space volvis, and any other key a property of the name space text.
 */
#ifndef VVI_IO_XMP_H
#define VVI_IO_XMP_H
#include "core/text.h"
#include "io/source.h"
#include <volvis/image.h>

/** Of a packet that is read. */
#define VVI_XMP_MOST ((size_t)16 << 20)

/** Nothing where there are no texts. Characters that XML has not become U+FFFD. */
void vvi_xmp_write(vvi_text *out, const vv_text *text, size_t n_text);
/** From where the source stands; texts are for vv_text_free(). Packets of other programs have none. */
vv_status vvi_xmp_read(vv_text **text_out, size_t *n_text_out, vv_source *packet, vv_job *job);
/** The same of a packet in memory; `name` stands in errors. */
vv_status vvi_xmp_read_memory(vv_text **text_out, size_t *n_text_out, const void *packet, size_t n, const char *name,
                              vv_job *job);
#endif
