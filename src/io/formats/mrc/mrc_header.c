#include "core/text.h"
#include "core/units.h"
#include "io/formats/mrc/mrc.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* IMOD's mark, and its flags: bytes are signed; the origin has the sign of MRC2014. */
#define IMOD_STAMP 1146047817
#define IMOD_SIGNED 1
#define IMOD_ORIGIN 4

static int32_t word(const uint8_t *head, int at, bool big)
{
    const uint8_t *b = head + at;
    const uint32_t v = big ? (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3]
                           : (uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | b[0];
    int32_t out;
    memcpy(&out, &v, 4);
    return out;
}

static float real(const uint8_t *head, int at, bool big)
{
    const int32_t v = word(head, at, big);
    float out;
    memcpy(&out, &v, 4);
    return out;
}

static bool is_permutation(const int32_t map[3])
{
    return map[0] >= 1 && map[0] <= 3 && map[1] >= 1 && map[1] <= 3 && map[2] >= 1 && map[2] <= 3 && map[0] != map[1] &&
           map[1] != map[2] && map[0] != map[2];
}

bool vvi_mrc_plausible(const uint8_t *head, bool big)
{
    const int32_t mode = word(head, 12, big), skip = word(head, 92, big);
    const int32_t map[3] = {word(head, 64, big), word(head, 68, big), word(head, 72, big)};
    for (int a = 0; a < 3; a++)
        if (word(head, 4 * a, big) < 1 || word(head, 4 * a, big) > 1 << 20)
            return false;
    return ((mode >= 0 && mode <= 16) || mode == 101) && skip >= 0 &&
           (is_permutation(map) || (map[0] == 0 && map[1] == 0 && map[2] == 0));
}

/* The machine stamp says it, but some writers put anything there: then it is the order that makes sense. */
static vv_status find_order(vvi_mrc *h, const uint8_t *head, const char *name, vv_notes *notes)
{
    const bool little_good = vvi_mrc_plausible(head, false), big_good = vvi_mrc_plausible(head, true);
    const bool stamped = head[212] == 0x11 || head[212] == 0x44;
    h->big_endian = stamped ? head[212] == 0x11 : !little_good;
    if (!little_good && !big_good)
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "its header is not an MRC header in either byte order: dims %d x %d x %d, mode %d",
                          word(head, 0, h->big_endian), word(head, 4, h->big_endian), word(head, 8, h->big_endian),
                          word(head, 12, h->big_endian));
    if (h->big_endian ? big_good : little_good)
        return VV_OK;
    h->big_endian = !h->big_endian;
    return vvi_notes_warn(notes, "its machine stamp says %s-endian, but its header is %s-endian",
                          h->big_endian ? "little" : "big", h->big_endian ? "big" : "little");
}

static vv_status add_texts(const uint8_t *head, vvi_mrc *h, vv_notes *notes)
{
    char key[16], text[81];
    int n = word(head, 220, h->big_endian);
    vv_status st = VV_OK;
    for (int i = 0; i < n && i < 10 && st == VV_OK; i++) {
        memcpy(text, head + 224 + 80 * i, 80);
        text[80] = 0;
        for (size_t end = strlen(text); end > 0 && text[end - 1] == ' '; end--)
            text[end - 1] = 0;
        vvi_text_clean(text);
        snprintf(key, sizeof key, "label %d", i + 1);
        if (strncmp(text, VVI_MRC_OWN, sizeof VVI_MRC_OWN - 1) == 0)
            memcpy(h->own, text, sizeof text);
        if (text[0])
            st = vvi_notes_add(notes, key, text);
    }
    if (st == VV_OK && h->n_extended > 0) {
        snprintf(text, sizeof text, "%d bytes of type '%.4s'", h->n_extended, (const char *)head + 104);
        vvi_text_clean(text);
        st = vvi_notes_add(notes, "extended header", text);
    }
    if (st == VV_OK) {
        snprintf(text, sizeof text, "%d", h->space_group);
        st = vvi_notes_add(notes, "space group", text);
    }
    return st;
}

vv_status vvi_mrc_read_header(vvi_mrc *h, vv_source *source, vv_notes *notes)
{
    uint8_t head[VVI_MRC_BYTES];
    vv_status st = vvi_source_read(source, head, sizeof head, "the MRC header");
    if (st != VV_OK || (st = find_order(h, head, vvi_source_name(source), notes)) != VV_OK)
        return st;
    const bool big = h->big_endian;
    for (int a = 0; a < 3; a++) {
        h->n[a] = word(head, 4 * a, big);
        h->start[a] = word(head, 16 + 4 * a, big);
        h->m[a] = word(head, 28 + 4 * a, big);
        h->cell[a] = real(head, 40 + 4 * a, big);
        h->angle[a] = real(head, 52 + 4 * a, big);
        h->map[a] = word(head, 64 + 4 * a, big);
        h->origin[a] = real(head, 196 + 4 * a, big);
    }
    h->mode = word(head, 12, big);
    h->lowest = real(head, 76, big);
    h->highest = real(head, 80, big);
    h->space_group = word(head, 88, big);
    h->n_extended = word(head, 92, big);
    h->imod = word(head, 152, big) == IMOD_STAMP;
    h->imod_flags = h->imod ? word(head, 156, big) : 0;
    h->has_map = memcmp(head + 208, "MAP", 3) == 0;
    h->offset = VVI_MRC_BYTES + (uint64_t)h->n_extended;
    if (!is_permutation(h->map))
        for (int a = 0; a < 3; a++)
            h->map[a] = a + 1;
    return add_texts(head, h, notes);
}

/* What samples are --------------------------------------------------------------------------------------------------
 */

/* MRC2014 says that bytes are signed. IMOD says it for each file; others wrote unsigned ones, which their largest value
 * tells. */
static vv_status choose_bytes(vvi_mrc *h, vv_notes *notes)
{
    if (h->imod) {
        h->layout.type = h->imod_flags & IMOD_SIGNED ? VV_TYPE_I8 : VV_TYPE_U8;
        return VV_OK;
    }
    h->layout.type = h->highest > 127 && h->lowest >= 0 ? VV_TYPE_U8 : VV_TYPE_I8;
    if (h->layout.type == VV_TYPE_I8)
        return VV_OK;
    return vvi_notes_warn(notes, "its bytes are read as unsigned, because its header gives %g as their largest value",
                          h->highest);
}

static vv_status choose_type(vv_field_info *info, vvi_mrc *h, const char *name, vv_notes *notes)
{
    vv_status st = VV_OK;
    vvi_layout *layout = &h->layout;
    switch (h->mode) {
    case 0:
        st = choose_bytes(h, notes);
        break;
    case 1:
        layout->type = VV_TYPE_I16;
        break;
    case 2:
        layout->type = VV_TYPE_F32;
        break;
    case 6:
        layout->type = VV_TYPE_U16;
        break;
    case 12:
        layout->type = VV_TYPE_F32;
        layout->half = true;
        break;
    case 16:
        layout->type = VV_TYPE_U8;
        info->components = 3;
        info->meaning = VV_MEANING_RGB;
        break;
    case 3:
    case 4:
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "holds complex numbers (mode %d), a transform; save its amplitudes or the map itself",
                          h->mode);
    case 101:
        layout->type = VV_TYPE_U8;
        h->nibbles = true;
        break;
    default:
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "is of mode %d; 0, 1, 2, 6, 12, 16 and 101 can be read",
                          h->mode);
    }
    info->type = layout->type;
    layout->swap = vvi_layout_element_bytes(layout) > 1 && vvi_order_swapped(h->big_endian);
    return st;
}

/* Placement -------------------------------------------------------------------------------------------------------- */

static double radians(float degrees)
{
    return degrees > 0 && degrees < 180 ? degrees * (3.14159265358979323846 / 180) : 3.14159265358979323846 / 2;
}

/* Edges of the unit cell: a along X, b in the plane of X and Y. */
static bool find_edges(vv_vec3 edge[3], const float angle[3])
{
    const bool right = angle[0] == 90 && angle[1] == 90 && angle[2] == 90;
    const double ca = right ? 0 : cos(radians(angle[0])), cb = right ? 0 : cos(radians(angle[1]));
    const double cg = right ? 0 : cos(radians(angle[2])), sg = right ? 1 : sin(radians(angle[2]));
    const double x = fabs(cb) < 1e-12 ? 0 : cb, y = (ca - cb * cg) / sg, z = 1 - x * x - y * y;
    edge[0] = (vv_vec3){1, 0, 0};
    edge[1] = (vv_vec3){fabs(cg) < 1e-12 ? 0 : cg, sg, 0};
    edge[2] = (vv_vec3){x, fabs(y) < 1e-12 ? 0 : y, z > 0 ? sqrt(z) : 0};
    return z > 1e-6 && sg > 1e-6;
}

static vv_vec3 along(vv_vec3 v, double by)
{
    return (vv_vec3){v.x * by, v.y * by, v.z * by};
}

static vv_vec3 divided(vv_vec3 v, double by)
{
    return (vv_vec3){v.x / by, v.y / by, v.z / by};
}

static vv_vec3 sum(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static vv_status place(vv_grid *grid, const vvi_mrc *h, vv_notes *notes)
{
    vv_vec3 edge[3];
    bool known = true, moved = false;
    vv_affine *a = &grid->index_to_world;
    const bool cell = find_edges(edge, h->angle);
    for (int i = 0; i < 3; i++)
        known = known && isfinite(h->cell[i]) && h->cell[i] > 0 && h->cell[i] < 1e12f && h->m[i] > 0;
    if (!cell)
        find_edges(edge, (const float[3]){90, 90, 90});
    a->origin = (vv_vec3){0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const int w = h->map[i] - 1;
        a->axis[i] = along(edge[w], known ? (double)h->cell[w] / h->m[w] : 1);
        a->origin = sum(a->origin, along(a->axis[i], h->start[i]));
        moved = moved || (isfinite(h->origin[i]) && h->origin[i] != 0);
    }
    /* an origin of its own goes before the starts, as other programs do; only headers with a mark have one */
    if (h->has_map && moved && isfinite(h->origin[0]) && isfinite(h->origin[1]) && isfinite(h->origin[2])) {
        const double sign = h->imod && !(h->imod_flags & IMOD_ORIGIN) ? -1 : 1;
        a->origin = (vv_vec3){sign * h->origin[0] + 0.0, sign * h->origin[1] + 0.0, sign * h->origin[2] + 0.0};
    }
    snprintf(grid->unit, sizeof grid->unit, known ? "A" : "voxels");
    return cell ? VV_OK
                : vvi_notes_warn(notes, "the angles of its cell (%g, %g, %g) are not possible; 90 is taken",
                                 h->angle[0], h->angle[1], h->angle[2]);
}

/* What our own label says: the header has angstrom alone. A label that is not just like ours says nothing. */
static void apply_own(vv_grid *grid, const char *own)
{
    static const char ras[] = "RAS, ";
    if (!*own)
        return;
    const char *unit = own + sizeof VVI_MRC_OWN - 1;
    const bool anatomical = strncmp(unit, ras, sizeof ras - 1) == 0;
    unit += anatomical ? sizeof ras - 1 : 0;
    const double metres = vvi_length_unit_metres(unit), angstrom = metres > 0 ? metres / 1e-10 : 1;
    const bool measured = strcmp(unit, "voxels") != 0;
    if (!*unit || strlen(unit) >= sizeof grid->unit || strpbrk(unit, " ,") ||
        strcmp(grid->unit, measured ? "A" : "voxels") != 0)
        return;
    for (int i = 0; i < 3; i++)
        grid->index_to_world.axis[i] = divided(grid->index_to_world.axis[i], angstrom);
    grid->index_to_world.origin = divided(grid->index_to_world.origin, angstrom);
    grid->space = anatomical ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    snprintf(grid->unit, sizeof grid->unit, "%s", unit);
}

vv_status vvi_mrc_describe(vv_field_info *info, vvi_mrc *h, const char *name, vv_notes *notes)
{
    vvi_layout *layout = &h->layout;
    const int32_t each = h->m[h->map[2] - 1]; /* sections of one volume, in stacks of them */
    vv_status st = choose_type(info, h, name, notes);
    if (st != VV_OK || (st = place(&info->grid, h, notes)) != VV_OK)
        return st;
    apply_own(&info->grid, h->own);
    for (int a = 0; a < 3; a++)
        info->grid.dims[a] = h->n[a];
    if (h->space_group >= 401 && h->space_group <= 630 && each > 0 && h->n[2] > each) {
        if (h->n[2] % each != 0)
            return vv_fail_at(
                VV_E_FORMAT, name, NULL,
                "is a stack of volumes of %d sections each, but its %d sections are not a multiple of that", each,
                h->n[2]);
        info->grid.dims[2] = each;
        info->n_frames = h->n[2] / each;
    }
    if (info->components > 1)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){info->components, VVI_ROLE_COMPONENT};
    for (int a = 0; a < 3; a++)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){info->grid.dims[a], VVI_ROLE_X + (vvi_role)a};
    layout->axis[layout->n_axes++] = (vvi_layout_axis){info->n_frames, VVI_ROLE_FRAME};
    return VV_OK;
}
