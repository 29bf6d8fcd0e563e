/* VTK's XML image data, .vti: regular grids with any number of arrays. */
#include "io/formats/vtk/vti_write.h"
#include "io/formats/vtk/vtk_xml.h"
#include "registry.h"
#include <string.h>

/* Other kinds of VTK's files come here too, to be refused with what to do. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    const bool vtk = memmem(head, n, "<VTKFile", 8) != NULL;
    return vtk && !memmem(head, n, "RectilinearGrid", 15) ? 2 : 0;
}

static vv_status parse(vvi_vtk_file *file, vv_source *source, vv_notes *notes, vv_job *job)
{
    return vvi_vtk_parse(file, "ImageData", source, job);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_vtk_read_header(info, plan_out, parse, source, options, notes, job);
}

static const char *const suffixes[] = {".vti", NULL};

const vv_format vvi_format_vti = {
    .api = VV_FORMAT_API,
    .name = "vti",
    .doc = "VTK XML image data: text, base64 or raw; zlib, LZ4 and LZMA blocks; arrays are parts",
    .suffixes = suffixes,
    .encodings = vvi_vti_encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_vtk_free_plan,
    .read = vvi_vtk_read,
    .mappable = vvi_vtk_mappable,
    .write = vvi_vti_write,
};
