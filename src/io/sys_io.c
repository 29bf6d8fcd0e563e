/* The public names of what formats of other programs need: volvis/sys/io.h. */
#include "core/units.h"
#include "io/notes.h"
#include "io/sink.h"
#include "io/source.h"
#include <stdio.h>
#include <volvis/sys/io.h>

const char *vv_source_name(const vv_source *source)
{
    return vvi_source_name(source);
}

uint64_t vv_source_left(vv_source *source, bool *exact)
{
    return vvi_source_left(source, exact);
}

uint64_t vv_source_tell(const vv_source *source)
{
    return vvi_source_tell(source);
}

vv_status vv_source_read(vv_source *source, void *out, size_t n, const char *what)
{
    return vvi_source_read(source, out, n, what);
}

vv_status vv_source_read_some(vv_source *source, void *out, size_t n, size_t *n_read)
{
    return vvi_source_read_some(source, out, n, n_read);
}

vv_status vv_source_seek(vv_source *source, uint64_t offset)
{
    return vvi_source_seek(source, offset);
}

const uint8_t *vv_source_peek(vv_source *source, size_t n, size_t *n_there)
{
    return vvi_source_peek(source, n, n_there);
}

vv_status vv_source_line(vv_source *source, const char **line_out, size_t most, bool *end)
{
    return vvi_source_line(source, line_out, most, end);
}

vv_status vv_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job)
{
    return vvi_source_open_beside(out, header, name, job);
}

void vv_source_close(vv_source *source)
{
    vvi_source_close(source);
}

const char *vv_sink_name(const vv_sink *sink)
{
    return vvi_sink_name(sink);
}

vv_status vv_sink_write(vv_sink *sink, const void *data, size_t n)
{
    return vvi_sink_write(sink, data, n);
}

vv_status vv_sink_printf(vv_sink *sink, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const vv_status st = vvi_sink_vprintf(sink, format, args);
    va_end(args);
    return st;
}

uint64_t vv_sink_tell(const vv_sink *sink)
{
    return vvi_sink_tell(sink);
}

vv_status vv_sink_beside(vv_sink **out, vv_sink *sink, const char *name)
{
    return vvi_sink_beside(out, sink, name);
}

vv_status vv_notes_add(vv_notes *notes, const char *key, const char *value)
{
    return vvi_notes_add(notes, key, value);
}

vv_status vv_notes_warn(vv_notes *notes, const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return vvi_notes_warn(notes, "%s", text);
}

vv_status vv_notes_channel(vv_notes *notes, const vv_channel *channel)
{
    return vvi_notes_channel(notes, channel);
}

vv_status vv_notes_label(vv_notes *notes, const vv_label *label)
{
    return vvi_notes_label(notes, label);
}

bool vv_number_scan(double *out, const char *text, const char **end)
{
    return vvi_scan_number(out, text, end);
}

void vv_number_print(char out[32], double value)
{
    vvi_print_number(out, value);
}
