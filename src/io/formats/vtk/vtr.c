/* VTK's XML rectilinear grids, .vtr: coordinates along each axis, resampled where they are uneven. */
#include "io/formats/vtk/vtk_xml.h"
#include "registry.h"
#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return memmem(head, n, "<VTKFile", 8) && memmem(head, n, "RectilinearGrid", 15) ? 2 : 0;
}

static vv_status parse(vvi_vtk_file *file, vv_source *source, vv_notes *notes, vv_job *job)
{
    return vvi_vtk_parse(file, "RectilinearGrid", source, job);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_vtk_read_header(info, plan_out, parse, source, options, notes, job);
}

static const char *const suffixes[] = {".vtr", NULL};

const vv_format vvi_format_vtr = {
    .api = VV_FORMAT_API,
    .name = "vtr",
    .doc = "VTK XML rectilinear grids, resampled where they are uneven; arrays are parts",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_vtk_free_plan,
    .read = vvi_vtk_read,
    .mappable = vvi_vtk_mappable,
};
