/** @file
 * Headers that name a file as theirs: what it holds is not to be replaced by something else.
 */
#ifndef VVI_IO_SINK_HEADERS_H
#define VVI_IO_SINK_HEADERS_H

/** The name of a header in the file's folder that names it as its data, yours to free(); NULL: none was found. `except`
 * is the path of a header that does not count; NULL: none. */
char *vvi_header_that_names(const char *path, const char *except);
#endif
