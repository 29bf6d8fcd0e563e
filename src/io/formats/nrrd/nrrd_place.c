/* What the axes of a NRRD are (space, time, components), and where its samples lie in our world. */
#include "io/formats/nrrd/nrrd.h"
#include "io/placement.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef enum axis_class { UNKNOWN, SPACE, TIME, COMPONENT, MATRIX } axis_class;

typedef struct kind {
    const char *name;
    axis_class class;
    int size; /* that the kind demands; 0: any */
    vv_meaning meaning;
} kind;

static const kind kinds[] = {
    {"domain", SPACE, 0, VV_MEANING_SCALAR},
    {"space", SPACE, 0, VV_MEANING_SCALAR},
    {"time", TIME, 0, VV_MEANING_SCALAR},
    {"list", COMPONENT, 0, VV_MEANING_SCALAR},
    {"point", COMPONENT, 0, VV_MEANING_SCALAR},
    {"vector", COMPONENT, 0, VV_MEANING_VECTOR},
    {"covariantvector", COMPONENT, 0, VV_MEANING_VECTOR},
    {"normal", COMPONENT, 0, VV_MEANING_VECTOR},
    {"stub", COMPONENT, 1, VV_MEANING_SCALAR},
    {"scalar", COMPONENT, 1, VV_MEANING_SCALAR},
    {"complex", COMPONENT, 2, VV_MEANING_SCALAR},
    {"2vector", COMPONENT, 2, VV_MEANING_VECTOR},
    {"3color", COMPONENT, 3, VV_MEANING_RGB},
    {"rgb", COMPONENT, 3, VV_MEANING_RGB},
    {"rgbcolor", COMPONENT, 3, VV_MEANING_RGB},
    {"hsvcolor", COMPONENT, 3, VV_MEANING_SCALAR},
    {"xyzcolor", COMPONENT, 3, VV_MEANING_SCALAR},
    {"4color", COMPONENT, 4, VV_MEANING_RGBA},
    {"rgba", COMPONENT, 4, VV_MEANING_RGBA},
    {"rgbacolor", COMPONENT, 4, VV_MEANING_RGBA},
    {"3vector", COMPONENT, 3, VV_MEANING_VECTOR},
    {"3gradient", COMPONENT, 3, VV_MEANING_VECTOR},
    {"3normal", COMPONENT, 3, VV_MEANING_VECTOR},
    {"4vector", COMPONENT, 4, VV_MEANING_SCALAR},
    {"quaternion", COMPONENT, 4, VV_MEANING_SCALAR},
    {"2dsymmetricmatrix", MATRIX, 3, VV_MEANING_SCALAR},
    {"2dmaskedsymmetricmatrix", MATRIX, 4, VV_MEANING_SCALAR},
    {"2dmatrix", MATRIX, 4, VV_MEANING_SCALAR},
    {"2dmaskedmatrix", MATRIX, 5, VV_MEANING_SCALAR},
    {"3dsymmetricmatrix", MATRIX, 6, VV_MEANING_SCALAR},
    {"3dmaskedsymmetricmatrix", MATRIX, 7, VV_MEANING_SCALAR},
    {"3dmatrix", MATRIX, 9, VV_MEANING_SCALAR},
    {"3dmaskedmatrix", MATRIX, 10, VV_MEANING_SCALAR},
    {"", UNKNOWN, 0, VV_MEANING_SCALAR},
    {"none", UNKNOWN, 0, VV_MEANING_SCALAR},
};

typedef struct roles {
    axis_class class[VVI_NRRD_AXES];
    vv_meaning meaning;
} roles;

static const kind *find_kind(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].name, name) == 0)
            return &kinds[i];
    return NULL;
}

static int count(const roles *r, int dimension, axis_class class)
{
    int n = 0;
    for (int a = 0; a < dimension; a++)
        n += r->class[a] == class;
    return n;
}

/* From the kinds alone. */
static vv_status classify_by_kind(roles *r, const vvi_nrrd *h, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (int a = 0; a < h->dimension && st == VV_OK; a++) {
        const vvi_nrrd_axis *axis = &h->axis[a];
        const kind *k = find_kind(axis->kind);
        if (!k) {
            st = vvi_notes_warn(notes, "the kind '%s' of axis %d is not known and is ignored", axis->kind, a + 1);
            continue;
        }
        if (k->class == MATRIX)
            return vv_fail_at(
                VV_E_UNSUPPORTED, h->name, NULL,
                "its samples are matrices (axis %d is a %s); only scalars, colours and vectors can be shown", a + 1,
                axis->kind);
        if (k->size && axis->size != k->size)
            return vv_fail_at(VV_E_FORMAT, h->name, NULL,
                              "axis %d is of kind '%s', which has %d entries, but its size is %lld", a + 1, axis->kind,
                              k->size, (long long)axis->size);
        r->class[a] = k->class;
        if (k->class == COMPONENT)
            r->meaning = k->meaning;
    }
    return st;
}

/* Whether something says that an axis does not lie in space: no direction where others have one; NaN as its spacing
 * where others have numbers, if it could be the components of a sample or there are more axes than space has. */
static bool off_space(const vvi_nrrd *h, int a)
{
    if (h->has_directions)
        return !h->axis[a].has_direction;
    bool any = false;
    for (int b = 0; b < h->dimension; b++)
        any |= !isnan(h->axis[b].spacing);
    const bool spare = h->dimension > 3 || (a == 0 && h->axis[0].size <= 4);
    return any && spare && isnan(h->axis[a].spacing) && isnan(h->axis[a].min);
}

/* An axis of four without a kind: time when it is the slowest, unless the fastest has the few entries of a sample. */
static void guess_unknown(roles *r, const vvi_nrrd *h)
{
    const int last = h->dimension - 1;
    for (int a = 0; a < h->dimension; a++)
        if (h->has_directions && h->axis[a].has_direction)
            r->class[a] = SPACE;
    for (int a = 0; a < h->dimension; a++)
        if (r->class[a] == UNKNOWN && off_space(h, a))
            r->class[a] = a == last && count(r, h->dimension, TIME) == 0 ? TIME : COMPONENT;
    int over = count(r, h->dimension, SPACE) + count(r, h->dimension, UNKNOWN) - 3;
    if (over > 0 && r->class[0] == UNKNOWN && h->axis[0].size <= 4 && count(r, h->dimension, COMPONENT) == 0 &&
        (h->axis[last].size > 4 || over > 1)) {
        r->class[0] = COMPONENT;
        over--;
    }
    if (over > 0 && r->class[last] == UNKNOWN && count(r, h->dimension, TIME) == 0)
        r->class[last] = TIME;
    for (int a = 0; a < h->dimension; a++)
        if (r->class[a] == UNKNOWN)
            r->class[a] = SPACE;
}

static vv_status check_roles(const roles *r, const vvi_nrrd *h)
{
    const int space = count(r, h->dimension, SPACE), time = count(r, h->dimension, TIME);
    const int component = count(r, h->dimension, COMPONENT);
    if (space >= 1 && space <= 3 && time <= 1 && component <= 1)
        return VV_OK;
    return vv_fail_at(
        VV_E_UNSUPPORTED, h->name, NULL,
        "its %d axes are %d of space, %d of time and %d of components; 1 to 3 of space, one of time and one "
        "of components can be shown; set 'kinds' if they are something else",
        h->dimension, space, time, component);
}

static void fill_layout(vv_field_info *info, vvi_nrrd *h, const roles *r, vvi_role role[VVI_NRRD_AXES])
{
    int n_space = 0;
    h->layout = (vvi_layout){.n_axes = h->dimension, .type = h->type};
    for (int a = 0; a < h->dimension; a++) {
        vvi_layout_axis *to = &h->layout.axis[a];
        to->n = h->axis[a].size;
        if (r->class[a] == SPACE) {
            info->grid.dims[n_space] = to->n;
            to->role = (vvi_role)(VVI_ROLE_X + n_space++);
        } else if (r->class[a] == TIME) {
            info->n_frames = to->n;
            to->role = VVI_ROLE_FRAME;
        } else {
            info->components = (int)to->n;
            to->role = VVI_ROLE_COMPONENT;
        }
        role[a] = to->role;
    }
    const uint16_t one = 1;
    const bool machine_big = *(const uint8_t *)&one == 0;
    h->layout.swap = vv_type_bytes(h->type) > 1 && h->big_endian != machine_big && h->encoding != VVI_NRRD_TEXT;
}

/* Placement ------------------------------------------------------------------------------------------------------ */

static vv_vec3 to_our_space(const vvi_nrrd *h, const double v[4])
{
    return (vv_vec3){v[0] * h->flip[0] + 0.0, v[1] * h->flip[1] + 0.0, v[2] * h->flip[2] + 0.0}; /* no -0 */
}

/* A step and an origin along one axis from spacing, min and max; false when the file says nothing. */
static bool axis_step(double *step, double *origin, const vvi_nrrd_axis *axis)
{
    const bool node = axis->centering == 'n';
    const double n = (double)axis->size, span = axis->max - axis->min;
    *step = 1;
    *origin = 0;
    if (!isnan(axis->spacing))
        *step = axis->spacing;
    else if (isfinite(span) && (!node || n > 1))
        *step = span / (node ? n - 1 : n);
    if (isfinite(axis->min))
        *origin = axis->min + (node ? 0 : *step / 2);
    else if (isfinite(axis->max))
        *origin = axis->max - *step * (n - 1) - (node ? 0 : *step / 2);
    return !isnan(axis->spacing) || isfinite(axis->min) || isfinite(axis->max);
}

static bool place_by_spacing(vv_affine *place, const vvi_nrrd *h, const roles *r)
{
    bool said = false;
    int n = 0;
    double step[3] = {1, 1, 1}, origin[3] = {0, 0, 0};
    for (int a = 0; a < h->dimension; a++)
        if (r->class[a] == SPACE) {
            said |= axis_step(&step[n], &origin[n], &h->axis[a]);
            n++;
        }
    if (h->has_origin)
        memcpy(origin, h->origin, sizeof origin);
    const double x[4] = {step[0]}, y[4] = {0, step[1]}, z[4] = {0, 0, step[2]};
    const double from[4] = {origin[0], origin[1], origin[2]};
    *place = (vv_affine){{to_our_space(h, x), to_our_space(h, y), to_our_space(h, z)}, to_our_space(h, from)};
    if (n < 3 && said)
        vvi_complete_axes(place, n);
    return said || h->has_origin;
}

static void place_by_direction(vv_affine *place, const vvi_nrrd *h, const roles *r)
{
    int n = 0;
    *place = vv_affine_identity();
    for (int a = 0; a < h->dimension; a++)
        if (r->class[a] == SPACE)
            place->axis[n++] = to_our_space(h, h->axis[a].direction);
    place->origin = to_our_space(h, h->origin);
    if (n < 3)
        vvi_complete_axes(place, n);
}

/* The first unit that is said; another one on another axis cannot be kept. */
static vv_status choose_unit(char out[16], const vvi_nrrd *h, const roles *r, bool placed, vv_notes *notes)
{
    const char *first = "";
    bool mixed = false;
    for (int a = 0; a < h->dimension; a++) {
        const char *unit = h->axis[a].unit;
        if (r->class[a] != SPACE || !unit[0])
            continue;
        mixed |= first[0] && strcmp(first, unit) != 0;
        first = first[0] ? first : unit;
    }
    for (int i = 0; i < h->space_dimension && i < 3; i++) {
        const char *unit = h->space_unit[i];
        if (!unit[0])
            continue;
        mixed |= i > 0 && h->space_unit[0][0] && strcmp(h->space_unit[0], unit) != 0;
        first = i == 0 || !first[0] ? unit : first;
    }
    if (!first[0])
        first = !placed ? "voxels" : h->anatomical ? "mm" : "units";
    snprintf(out, 16, "%.15s", first);
    return mixed ? vvi_notes_warn(notes, "its axes have different units; all lengths are taken as %s", first) : VV_OK;
}

static vv_status place(vv_field_info *info, const vvi_nrrd *h, const roles *r, vv_notes *notes)
{
    vv_grid *grid = &info->grid;
    bool placed = true;
    if (h->has_directions)
        place_by_direction(&grid->index_to_world, h, r);
    else
        placed = place_by_spacing(&grid->index_to_world, h, r);
    if (!vvi_affine_finite(&grid->index_to_world) || vv_affine_determinant(grid->index_to_world) == 0)
        return vv_fail_at(VV_E_FORMAT, h->name, NULL,
                          "its spacings or space directions are not finite or lie in one plane; correct the header");
    grid->space = h->anatomical ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    return choose_unit(grid->unit, h, r, placed, notes);
}

/* Of one time step, what its series said. */
static vv_status place_time(vv_field_info *info, const vvi_nrrd *h, const roles *r)
{
    info->frame_step = h->frame_step;
    memcpy(info->frame_unit, h->frame_unit, sizeof info->frame_unit);
    for (int a = 0; a < h->dimension; a++) {
        const vvi_nrrd_axis *axis = &h->axis[a];
        if (r->class[a] != TIME)
            continue;
        const double step = isfinite(axis->spacing) ? axis->spacing : axis->has_direction ? axis->direction[3] : 0;
        info->frame_step = isfinite(step) ? step : 0;
        memcpy(info->frame_unit, axis->unit, sizeof info->frame_unit);
    }
    return VV_OK;
}

/* Meaning --------------------------------------------------------------------------------------------------------- */

static vv_status choose_meaning(vv_field_info *info, vvi_nrrd *h, const roles *r, vv_notes *notes)
{
    vv_status st = VV_OK;
    const bool whole = !vv_type_is_float(info->type);
    info->meaning = info->components > 1 ? r->meaning : VV_MEANING_SCALAR;
    if (info->components == 1 && whole && (h->is_segmentation || strcmp(h->meaning, "label") == 0))
        info->meaning = VV_MEANING_LABEL;
    if (strcmp(h->meaning, "vector") == 0)
        info->meaning = VV_MEANING_VECTOR;
    const bool flipped = h->flip[0] < 0 || h->flip[1] < 0 || h->flip[2] < 0;
    if (info->meaning == VV_MEANING_VECTOR && info->components == 3 && flipped) {
        if (vvi_type_min(info->type) < 0)
            for (int c = 0; c < 3; c++)
                h->layout.negate |= h->flip[c] < 0 ? 1u << c : 0;
        else
            st = vvi_notes_warn(notes, "its vectors are unsigned and stay in the file's space, which is not ours");
    }
    if (st == VV_OK && h->has_measurement_frame && info->meaning == VV_MEANING_VECTOR)
        st = vvi_notes_warn(notes, "its measurement frame is ignored: vectors are taken in the axes of its space");
    return st;
}

/* Slicer keeps overlapping segments in a list of label volumes: one of them is read. */
static vv_status take_layer(vv_field_info *info, vvi_nrrd *h, const char *part, vv_notes *notes)
{
    vvi_layout *l = &h->layout;
    if (!h->is_segmentation || info->components < 2 || vv_type_is_float(info->type))
        return VV_OK;
    h->layer_step = 1;
    int a = 0;
    for (; l->axis[a].role != VVI_ROLE_COMPONENT; a++)
        h->layer_step *= (uint64_t)l->axis[a].n;
    if (l->axis[a].n > VVI_NRRD_NAMES_MOST)
        return vv_fail_at(VV_E_FORMAT, h->name, NULL, "has %lld layers of segments; at most %d are possible",
                          (long long)l->axis[a].n, VVI_NRRD_NAMES_MOST);
    h->n_layers = (int)l->axis[a].n;
    l->n_axes--;
    memmove(&l->axis[a], &l->axis[a + 1], (size_t)(l->n_axes - a) * sizeof l->axis[0]);
    info->components = 1;
    return vvi_nrrd_choose_layer(h, h->n_layers, part, notes);
}

vv_status vvi_nrrd_place(vv_field_info *info, vvi_nrrd *h, const char *part, vv_notes *notes)
{
    roles r = {.meaning = VV_MEANING_SCALAR};
    h->is_segmentation = h->is_segmentation && !h->is_fractional;
    vvi_role role[VVI_NRRD_AXES];
    vv_status st = classify_by_kind(&r, h, notes);
    if (st != VV_OK)
        return st;
    guess_unknown(&r, h);
    if ((st = check_roles(&r, h)) != VV_OK)
        return st;
    info->type = h->type;
    fill_layout(info, h, &r, role);
    if ((st = place(info, h, &r, notes)) != VV_OK || (st = place_time(info, h, &r)) != VV_OK)
        return st;
    info->value_scale = h->value_scale;
    info->value_offset = h->value_offset;
    memcpy(info->value_unit, h->sample_unit, sizeof info->value_unit);
    memcpy(info->name, h->content, sizeof info->name);
    if ((st = take_layer(info, h, part, notes)) != VV_OK || (st = choose_meaning(info, h, &r, notes)) != VV_OK)
        return st;
    st = vvi_nrrd_note_names(h, info, notes);
    return st == VV_OK ? vvi_nrrd_keep(h, role, notes) : st;
}
