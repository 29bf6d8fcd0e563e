/* What the tables cannot say of one property by itself. Nothing here compares two properties: the order in which they
 * are set must not matter. */
#include "core/status.h"
#include "model/classes.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static vv_status fail_property(const char *path, const char *name, const char *text)
{
    char where[512];
    snprintf(where, sizeof where, "%s%s%s", path, *path ? "." : "", name);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%s", text);
}

static bool ascending(const vv_numbers *rows, size_t columns)
{
    for (size_t i = columns; rows && i < rows->n; i += columns) {
        if (!(rows->v[i] >= rows->v[i - columns]))
            return false;
    }
    return true;
}

/* Whether columns first .. last of every row are within [0, max]. */
static bool within(const vv_numbers *rows, size_t columns, size_t first, size_t last, double max)
{
    for (size_t i = 0; rows && i < rows->n; i++) {
        const size_t column = i % columns;
        if (column >= first && column <= last && !(rows->v[i] >= 0 && rows->v[i] <= max))
            return false;
    }
    return true;
}

vv_status vvi_check_cut_plane(const vv_object *object, const char *path)
{
    const vv_cut_plane *plane = (const vv_cut_plane *)object;
    const vv_vec3 n = plane->normal;
    const double largest = fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z)));
    if (!(largest > 1e-150 && largest < 1e150)) /* its square is neither 0 nor infinite */
        return fail_property(path, "normal", "a normal needs a direction: expected finite numbers that are not all 0");
    return VV_OK;
}

vv_status vvi_check_transfer(const vv_object *object, const char *path)
{
    const vv_transfer *transfer = (const vv_transfer *)object;
    if (!ascending(transfer->opacity, 2))
        return fail_property(path, "opacity", "rows must be in ascending order of value");
    if (!within(transfer->opacity, 2, 1, 1, 1))
        return fail_property(path, "opacity", "an opacity is out of range: expected 0 to 1");
    if (!ascending(transfer->color, 4))
        return fail_property(path, "color", "rows must be in ascending order of value");
    if (!within(transfer->color, 4, 1, 3, 1e6))
        return fail_property(path, "color", "a colour is out of range: expected 0 to 1");
    return VV_OK;
}

vv_status vvi_check_paint(const vv_object *object, const char *path)
{
    const vv_volume_paint *paint = (const vv_volume_paint *)object;
    if (!ascending(paint->color, 4))
        return fail_property(path, "color", "rows must be in ascending order of value");
    if (!within(paint->color, 4, 1, 3, 1e6))
        return fail_property(path, "color", "a colour is out of range: expected 0 to 1");
    return VV_OK;
}

vv_status vvi_check_labels(const vv_object *object, const char *path)
{
    const vv_labels *labels = (const vv_labels *)object;
    if (!ascending(labels->table, 5))
        return fail_property(path, "table", "rows must be in ascending order of label");
    if (!within(labels->table, 5, 1, 3, 1e6))
        return fail_property(path, "table", "a colour is out of range: expected 0 to 1");
    if (!within(labels->table, 5, 4, 4, 1))
        return fail_property(path, "table", "an opacity is out of range: expected 0 to 1");
    return VV_OK;
}

vv_status vvi_check_frame(const vv_object *object, const char *path)
{
    const vv_frame *frame = (const vv_frame *)object;
    if (frame->scale.x == 0 || frame->scale.y == 0 || frame->scale.z == 0)
        return fail_property(path, "scale", "a factor of 0 leaves nothing to see");
    if (!frame->matrix)
        return VV_OK;
    const double *m = frame->matrix->v;
    if (frame->matrix->n != 12)
        return fail_property(path, "matrix", "expected 3 rows of 4 numbers");
    const vv_affine a = {{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[3], m[7], m[11]}};
    const double determinant = vv_affine_determinant(a);
    if (determinant == 0 || !isfinite(determinant))
        return fail_property(path, "matrix", "the matrix is singular: it leaves nothing to see");
    return VV_OK;
}

bool vvi_checksum_parse(uint32_t *out, const char *text)
{
    if (strncmp(text, "crc32:", 6) != 0 || strlen(text) != 14 || strspn(text + 6, "0123456789abcdefABCDEF") != 8)
        return false;
    *out = (uint32_t)strtoul(text + 6, NULL, 16);
    return true;
}

vv_status vvi_check_dataset(const vv_object *object, const char *path)
{
    const vv_dataset *dataset = (const vv_dataset *)object;
    uint32_t crc = 0;
    if (dataset->checksum && !vvi_checksum_parse(&crc, dataset->checksum))
        return fail_property(path, "checksum", "expected crc32: followed by eight hexadecimal digits");
    if (!dataset->on && (!dataset->operation || dataset->path))
        return fail_property(path, "on", "is of data that an operation makes; a file cannot be switched off");
    return VV_OK;
}
