/* MetaImage says where samples are in ITK's axes: x to the left, y to the back, z up. A row of its matrix is the
 * direction of one index axis. Three letters may say the same once more, each the side that an axis comes from. */
#include "core/units.h"
#include "io/formats/metaimage/metaimage.h"
#include "io/placement.h"
#include "io/scan.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static const char *const matrix_names[] = {"TransformMatrix", "Rotation", "Orientation", NULL};
static const char *const origin_names[] = {"Offset", "Position", "Origin", NULL};
static const char *const spacing_names[] = {"ElementSpacing", "ElementSize", NULL};

/* Directions by letters; false when they are none. */
static bool directions_of_letters(vv_affine *out, const char *letters)
{
    static const char from[] = "RLAPIS";
    unsigned seen = 0;
    *out = vv_affine_identity();
    if (strlen(letters) != 3)
        return false;
    for (int a = 0; a < 3; a++) {
        const char *at = strchr(from, toupper((unsigned char)letters[a]));
        if (!at)
            return false;
        const int which = (int)(at - from), axis = which / 2;
        const double sign = which % 2 ? -1 : 1;
        out->axis[a] = (vv_vec3){axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
        seen |= 1u << axis;
    }
    return seen == 7;
}

void vvi_metaimage_letters(char out[4], const vv_affine *lps)
{
    static const char from[] = "RLAPIS";
    for (int a = 0; a < 3; a++) {
        const double v[3] = {lps->axis[a].x, lps->axis[a].y, lps->axis[a].z};
        int most = 0;
        for (int i = 1; i < 3; i++)
            if (fabs(v[i]) > fabs(v[most]))
                most = i;
        out[a] = from[2 * most + (v[most] < 0)];
    }
    out[3] = 0;
}

static vv_status read_matrix(vv_affine *out, vvi_keys *keys, const char *name, int n)
{
    double m[VVI_METAIMAGE_AXES * VVI_METAIMAGE_AXES];
    vv_status st = vvi_keys_reals(m, n * n, keys, name);
    const int k = n < 3 ? n : 3;
    if (st != VV_OK)
        return st;
    *out = vv_affine_identity();
    for (int a = 0; a < k; a++)
        out->axis[a] = (vv_vec3){m[a * n], k > 1 ? m[a * n + 1] : 0, k > 2 ? m[a * n + 2] : 0};
    return VV_OK;
}

/* The matrix, which may be missing, and what letters say of it, which may be nothing. */
static vv_status find_directions(vv_affine *out, bool *anatomical, vvi_keys *keys, int n, vv_notes *notes)
{
    vv_affine said;
    char ours[4];
    const char *matrix = vvi_keys_first(keys, matrix_names);
    const char *letters = vvi_keys_get(keys, "AnatomicalOrientation");
    const bool known = n >= 3 && letters && directions_of_letters(&said, letters);
    vv_status st = VV_OK;
    *out = vv_affine_identity();
    if (matrix && (st = read_matrix(out, keys, matrix, n)) != VV_OK)
        return st;
    if (!matrix && known)
        *out = said;
    /* Letters of "???" are how a program says that it does not know; then only a matrix that turns speaks of a body. */
    *anatomical = n >= 3 && (known || (matrix && !(letters && vvi_is_identity(out))));
    if (!matrix || !known)
        return VV_OK;
    vvi_metaimage_letters(ours, out);
    return strcasecmp(ours, letters) == 0
               ? VV_OK
               : vvi_notes_warn(notes, "its AnatomicalOrientation is %s, but its %s runs %s; the matrix is used",
                                letters, matrix, ours);
}

/* What came in a unit that the format has not is written in one that it has, beside our own key. */
static void choose_unit(vv_grid *grid, vvi_keys *keys, bool anatomical, bool placed)
{
    const char *own = vvi_keys_get(keys, VVI_METAIMAGE_UNIT), *unit = vvi_keys_get(keys, "DistanceUnits");
    char *out = grid->unit, own_unit[16];
    if (unit && unit[0] && unit[0] != '?')
        vvi_unit_name(out, unit, strlen(unit));
    else
        snprintf(out, 16, "%s", anatomical ? "mm" : placed ? "units" : "voxels");
    if (!own || !own[0])
        return;
    vvi_unit_name(own_unit, own, strlen(own));
    const double from = unit && unit[0] ? vvi_length_unit_metres(out) : 0, to = vvi_length_unit_metres(own_unit);
    if (from > 0 && to > 0)
        vvi_grid_scale(grid, from / to, own_unit);
    else
        memcpy(out, own_unit, sizeof own_unit);
}

static vv_vec3 to_ras(vv_vec3 v)
{
    return (vv_vec3){0.0 - v.x, 0.0 - v.y, v.z};
}

/* Spacings into the columns; a file of fewer axes gets the others. */
static void scale_axes(vv_affine *place, const double spacing[3], int n, bool placed)
{
    for (int a = 0; a < 3 && a < n; a++) {
        vv_vec3 *v = &place->axis[a];
        *v = (vv_vec3){v->x * spacing[a] + 0.0, v->y * spacing[a] + 0.0, v->z * spacing[a] + 0.0}; /* no -0 */
    }
    if (n < 3 && placed)
        vvi_complete_axes(place, n);
}

/* How the format's own tools turn about a centre is not what ITK does with it, which is nothing. */
static vv_status note_centre(vvi_keys *keys, const vv_affine *directions, int n, vv_notes *notes)
{
    double centre[VVI_METAIMAGE_AXES] = {0};
    const char *text = vvi_keys_get(keys, "CenterOfRotation");
    vv_status st = vvi_keys_reals(centre, n, keys, "CenterOfRotation");
    bool away = false;
    for (int a = 0; a < n && st == VV_OK; a++)
        away |= centre[a] != 0;
    if (st != VV_OK || !text || !away)
        return st;
    if (!vvi_is_identity(directions))
        st = vvi_notes_warn(notes, "its CenterOfRotation is not 0 and is left out, as ITK does");
    return st == VV_OK ? vvi_notes_add(notes, "CenterOfRotation", text) : st;
}

vv_status vvi_metaimage_place(vv_field_info *info, vvi_keys *keys, int n, vv_notes *notes)
{
    double spacing[VVI_METAIMAGE_AXES] = {1, 1, 1, 1}, origin[VVI_METAIMAGE_AXES] = {0};
    bool anatomical = false;
    vv_grid *grid = &info->grid;
    vv_affine place;
    vv_status st = find_directions(&place, &anatomical, keys, n, notes);
    if (st != VV_OK || (st = note_centre(keys, &place, n, notes)) != VV_OK)
        return st;
    const char *spacings = vvi_keys_first(keys, spacing_names), *origins = vvi_keys_first(keys, origin_names);
    const char *space = vvi_keys_get(keys, VVI_METAIMAGE_SPACE);
    if ((spacings && (st = vvi_keys_reals(spacing, n, keys, spacings)) != VV_OK) ||
        (origins && (st = vvi_keys_reals(origin, n, keys, origins)) != VV_OK))
        return st;
    if (space && strcasecmp(space, "plain") == 0)
        anatomical = false;
    const bool placed = spacings || origins || !vvi_is_identity(&place);
    scale_axes(&place, spacing, n, placed);
    place.origin = (vv_vec3){origin[0], origin[1], n > 2 ? origin[2] : 0};
    if (anatomical)
        place =
            (vv_affine){{to_ras(place.axis[0]), to_ras(place.axis[1]), to_ras(place.axis[2])}, to_ras(place.origin)};
    if (!vvi_affine_finite(&place) || vv_affine_determinant(place) == 0)
        return vv_fail_at(VV_E_FORMAT, keys->file, NULL,
                          "its spacing is 0 or out of range, or its axes lie in one plane; correct the header");
    grid->index_to_world = place;
    grid->space = anatomical ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    choose_unit(grid, keys, anatomical, placed);
    if (n > 3 && spacings)
        info->frame_step = spacing[3];
    return VV_OK;
}
