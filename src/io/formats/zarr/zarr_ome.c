/* OME-Zarr images: axes, levels and the transformations of each, versions 0.1 to 0.5, and of 0.6 its coordinate
 * systems: https://ngff.openmicroscopy.org */
#include "core/memory.h"
#include "io/formats/zarr/zarr.h"
#include "io/placement.h"
#include "io/scan.h"
#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#define SEQUENCE_DEPTH 8

typedef double map[VVI_ZARR_AXES][VVI_ZARR_AXES + 1]; /* n rows of n factors and an offset */

static void identity(map m)
{
    memset(m, 0, sizeof(map));
    for (int i = 0; i < VVI_ZARR_AXES; i++)
        m[i][i] = 1;
}

/* m = first m, then t. */
static void then(map m, map t)
{
    map out = {{0}};
    const int last = VVI_ZARR_AXES;
    for (int i = 0; i < last; i++) {
        out[i][last] = t[i][last];
        for (int k = 0; k < last; k++) {
            for (int j = 0; j < last; j++)
                out[i][j] += t[i][k] * m[k][j];
            out[i][last] += t[i][k] * m[k][last];
        }
    }
    memcpy(m, out, sizeof out);
}

/* Transformations ------------------------------------------------------------------------------------------------ */

static bool numbers(double *out, const json_t *list, int n)
{
    if (!json_is_array(list) || json_array_size(list) != (size_t)n)
        return false;
    for (int i = 0; i < n; i++)
        if (!vvi_json_real(&out[i], json_array_get(list, (size_t)i)))
            return false;
    return true;
}

/* Rows of n or n + 1 numbers. */
static bool matrix(map t, const json_t *rows, int n, int columns)
{
    double row[VVI_ZARR_AXES + 1] = {0};
    if (json_array_size(rows) != (size_t)n)
        return false;
    for (int i = 0; i < n; i++) {
        if (!numbers(row, json_array_get(rows, (size_t)i), columns))
            return false;
        memcpy(t[i], row, (size_t)n * sizeof *row);
        t[i][VVI_ZARR_AXES] = columns > n ? row[n] : 0;
    }
    return true;
}

/* Transformations of n axes as they are applied; `failed` gets the type of the first that cannot be. */
typedef struct applying {
    int n;
    char failed[24];
} applying;

static bool apply(map m, applying *a, const json_t *transformation, int depth);

static bool apply_list(map m, applying *a, const json_t *list, int depth)
{
    for (size_t i = 0; i < json_array_size(list); i++)
        if (!apply(m, a, json_array_get(list, i), depth))
            return false;
    return json_is_array(list);
}

static bool map_axes(map t, const json_t *order, int n)
{
    double from[VVI_ZARR_AXES];
    if (!numbers(from, order, n))
        return false;
    for (int i = 0; i < n; i++) {
        if (!(from[i] >= 0 && from[i] < n))
            return false;
        memset(t[i], 0, sizeof t[i]);
        t[i][(int)from[i]] = 1;
    }
    return true;
}

/* One transformation that is neither a list of others nor made of others. */
static bool read_single(map t, const json_t *transformation, const char *type, int n)
{
    double v[VVI_ZARR_AXES];
    if (strcmp(type, "affine") == 0)
        return matrix(t, json_object_get(transformation, type), n, n + 1);
    if (strcmp(type, "rotation") == 0)
        return matrix(t, json_object_get(transformation, type), n, n);
    if (strcmp(type, "mapAxis") == 0)
        return map_axes(t, json_object_get(transformation, type), n);
    const bool scale = strcmp(type, "scale") == 0;
    if ((!scale && strcmp(type, "translation") != 0) || !numbers(v, json_object_get(transformation, type), n))
        return false;
    for (int i = 0; i < n; i++)
        t[i][scale ? i : VVI_ZARR_AXES] = v[i];
    return true;
}

/* False when it is not understood: displacements, for one, or numbers that lie in an array of their own. */
static bool apply(map m, applying *a, const json_t *transformation, int depth)
{
    map t;
    const char *type = vvi_json_text(transformation, "type");
    vvi_json_copy_text(a->failed, sizeof a->failed, type ? type : "");
    if (!type || depth > SEQUENCE_DEPTH)
        return false;
    if (strcmp(type, "identity") == 0)
        return true;
    if (strcmp(type, "sequence") == 0)
        return apply_list(m, a, json_object_get(transformation, "transformations"), depth + 1);
    if (strcmp(type, "bijection") == 0)
        return apply(m, a, json_object_get(transformation, "forward"), depth + 1);
    identity(t);
    if (!read_single(t, transformation, type, a->n))
        return false;
    then(m, t);
    return true;
}

/* Axes ----------------------------------------------------------------------------------------------------------- */

/* The world that anatomical axes of RFC 4 run to. */
static char direction(const json_t *axis)
{
    static const struct {
        const char *value;
        char towards;
    } known[] = {{"left-to-right", 'R'},         {"right-to-left", 'L'},        {"posterior-to-anterior", 'A'},
                 {"anterior-to-posterior", 'P'}, {"inferior-to-superior", 'S'}, {"superior-to-inferior", 'I'}};
    const json_t *orientation = json_object_get(axis, "orientation");
    const char *type = vvi_json_text(orientation, "type"), *value = vvi_json_text(orientation, "value");
    for (size_t i = 0; type && value && strcmp(type, "anatomical") == 0 && i < sizeof known / sizeof *known; i++)
        if (strcmp(value, known[i].value) == 0)
            return known[i].towards;
    return 0;
}

static int role_of_name(const char *name)
{
    static const struct {
        const char *name;
        int role;
    } names[] = {{"x", VVI_ROLE_X},
                 {"y", VVI_ROLE_Y},
                 {"z", VVI_ROLE_Z},
                 {"t", VVI_ROLE_FRAME},
                 {"time", VVI_ROLE_FRAME},
                 {"c", VVI_ROLE_COMPONENT},
                 {"channel", VVI_ROLE_COMPONENT}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcasecmp(name, names[i].name) == 0)
            return names[i].role;
    return -1;
}

static void read_axis(vvi_zarr_axis *out, const json_t *axis)
{
    const char *name = json_is_string(axis) ? json_string_value(axis) : vvi_json_text(axis, "name");
    const char *type = vvi_json_text(axis, "type"), *unit = vvi_json_text(axis, "unit");
    char clean[32];
    *out = (vvi_zarr_axis){.towards = direction(axis)};
    vvi_json_copy_text(out->name, sizeof out->name, name);
    vvi_json_copy_text(clean, sizeof clean, unit);
    vvi_unit_name(out->unit, clean, strlen(clean));
    out->role = role_of_name(out->name);
    const bool spatial = out->role >= VVI_ROLE_X && out->role <= VVI_ROLE_Z;
    if (type && strcmp(type, "time") == 0)
        out->role = VVI_ROLE_FRAME;
    else if (type && strcmp(type, "channel") == 0)
        out->role = VVI_ROLE_COMPONENT;
    else if (type && strcmp(type, "space") == 0 && !spatial)
        out->role = VVI_ROLES; /* one of x, y, z: which is said by the others */
    else if (type && strcmp(type, "space") != 0 && spatial)
        out->role = -1;
}

/* Axes of space by other names fill what is left of x, y, z from the last on; a role that is taken twice is none. */
static void settle_roles(vvi_zarr_axis *axis, int n)
{
    unsigned taken = 0;
    for (int i = 0; i < n; i++) {
        if (axis[i].role < 0 || axis[i].role == VVI_ROLES)
            continue;
        if (taken >> axis[i].role & 1)
            axis[i].role = -1;
        else
            taken |= 1u << axis[i].role;
    }
    for (int i = n - 1; i >= 0; i--) {
        if (axis[i].role != VVI_ROLES)
            continue;
        axis[i].role = -1;
        for (int role = VVI_ROLE_X; role <= VVI_ROLE_Z && axis[i].role < 0; role++)
            if (!(taken >> role & 1)) {
                axis[i].role = role;
                taken |= 1u << role;
            }
    }
    for (int i = 0; i < n; i++)
        if (axis[i].role < 0 && !(taken >> VVI_ROLE_COMPONENT & 1)) {
            axis[i].role = VVI_ROLE_COMPONENT;
            taken |= 1u << VVI_ROLE_COMPONENT;
        }
}

static const char *name_of(const json_t *system)
{
    return json_is_string(system) ? json_string_value(system) : vvi_json_text(system, "name");
}

/* From 0.6 on axes belong to coordinate systems. The one to show is that to which the levels lead, which is to be the
 * last; NULL when there are none. */
static const json_t *system_of(const json_t *multiscale)
{
    const json_t *systems = json_object_get(multiscale, "coordinateSystems");
    const json_t *level = json_array_get(json_object_get(multiscale, "datasets"), 0);
    const json_t *steps = json_object_get(level, "coordinateTransformations");
    const size_t n = json_array_size(systems), n_steps = json_array_size(steps);
    const char *to = n_steps > 0 ? name_of(json_object_get(json_array_get(steps, n_steps - 1), "output")) : NULL;
    for (size_t i = 0; to && i < n; i++) {
        const char *name = name_of(json_array_get(systems, i));
        if (name && strcmp(name, to) == 0)
            return json_array_get(systems, i);
    }
    return n > 0 ? json_array_get(systems, n - 1) : NULL;
}

static vv_status read_axes(vvi_zarr_image *image, const json_t *multiscale, const char *name)
{
    const json_t *system = system_of(multiscale);
    const json_t *axes = json_object_get(system ? system : multiscale, "axes");
    const size_t n = json_array_size(axes);
    if (n > VVI_ZARR_AXES)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its image has %zu axes; at most %d can be read", n,
                          VVI_ZARR_AXES);
    image->n_axes = (int)n;
    for (size_t i = 0; i < n; i++)
        read_axis(&image->axis[i], json_array_get(axes, i));
    settle_roles(image->axis, (int)n);
    return VV_OK;
}

/* Images --------------------------------------------------------------------------------------------------------- */

static const json_t *multiscale_of(const vvi_zarr_node *node)
{
    return json_array_get(json_object_get(vvi_zarr_ome(node), "multiscales"), 0);
}

bool vvi_zarr_is_image(const vvi_zarr_node *node)
{
    return node->kind == VVI_ZARR_GROUP && json_array_size(json_object_get(multiscale_of(node), "datasets")) > 0;
}

static vv_status warn_unknown(vv_notes *notes, const char *whose, const char *type)
{
    if (!notes)
        return VV_OK;
    return vvi_notes_warn(notes, "%s coordinate transformation '%s' is not understood and left out", whose,
                          *type ? type : "of no type");
}

/* A level's own transformations and those of the whole image, as far as they are understood. With coordinate systems
 * the image's lead on to others, which are not shown. */
static vv_status place_level(vvi_zarr_image *image, const json_t *multiscale, const json_t *own, vv_notes *notes)
{
    const int at = image->n_levels - 1;
    const json_t *global = json_object_get(multiscale, "coordinateTransformations");
    applying a = {.n = image->n_axes};
    map m;
    vv_status st = VV_OK;
    identity(image->level[at].map);
    if (system_of(multiscale))
        global = NULL;
    for (int i = 0; i < 2 && st == VV_OK; i++) {
        const json_t *list = i == 0 ? own : global;
        if (!list || a.n == 0) /* versions whose axes have no names have no transformations either */
            continue;
        memcpy(m, image->level[at].map, sizeof m);
        if (a.n > 0 && apply_list(m, &a, list, 0)) {
            memcpy(image->level[at].map, m, sizeof m);
            image->level[at].placed = true;
        } else {
            st = warn_unknown(notes, i == 0 ? "the" : "the image's", a.failed);
        }
    }
    return st;
}

static vv_status read_level(vvi_zarr_image *image, const vvi_zarr_node *node, const json_t *multiscale,
                            const json_t *dataset, vv_notes *notes, const char *name)
{
    const char *path = vvi_json_text(dataset, "path");
    const int at = image->n_levels;
    if (!path)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "level %d of its image has no 'path'", at);
    vv_status st = vvi_zarr_join(image->level[at].path, node->path, path);
    if (st != VV_OK)
        return st;
    image->n_levels++;
    return place_level(image, multiscale, json_object_get(dataset, "coordinateTransformations"), notes);
}

/* A version that is not known may mean anything by the same words. */
static vv_status check_version(const vvi_zarr_node *node, const json_t *multiscale, vv_notes *notes)
{
    char version[24];
    const json_t *ome = vvi_zarr_ome(node);
    const char *said = vvi_json_text(ome, "version");
    vvi_json_copy_text(version, sizeof version, said ? said : vvi_json_text(multiscale, "version"));
    const bool number = version[0] == '0' && version[1] == '.';
    if (!*version || (number && version[2] >= '1' && version[2] <= '5' && !version[3]))
        return VV_OK;
    const bool next = number && version[2] == '6' && !isdigit((unsigned char)version[3]);
    return vvi_notes_warn(notes, "is written as OME-Zarr %s; VolVis knows 0.1 to 0.5%s: what has not changed is read",
                          version, next ? " and the coordinate systems of 0.6" : "");
}

/* The coordinate systems of 0.6: the one that is shown first. */
static vv_status note_systems(const json_t *multiscale, vv_notes *notes)
{
    const json_t *shown = system_of(multiscale), *systems = json_object_get(multiscale, "coordinateSystems");
    vv_status st = VV_OK;
    if (!shown || !name_of(shown))
        return VV_OK;
    st = vvi_notes_add(notes, "coordinate_system", name_of(shown));
    for (size_t i = 0; i < json_array_size(systems) && i < VVI_ZARR_LEVELS && st == VV_OK; i++) {
        const json_t *other = json_array_get(systems, i);
        if (other != shown && name_of(other))
            st = vvi_notes_add(notes, "other_coordinate_system", name_of(other));
    }
    return st;
}

vv_status vvi_zarr_image_of(vvi_zarr_image *out, const vvi_zarr_node *node, vv_notes *notes, const char *name)
{
    const json_t *multiscale = multiscale_of(node), *datasets = json_object_get(multiscale, "datasets");
    memset(out, 0, sizeof *out);
    vvi_json_copy_text(out->name, sizeof out->name, vvi_json_text(multiscale, "name"));
    vv_status st = check_version(node, multiscale, notes);
    if (st == VV_OK)
        st = note_systems(multiscale, notes);
    if (st == VV_OK)
        st = read_axes(out, multiscale, name);
    for (size_t i = 0; i < json_array_size(datasets) && i < VVI_ZARR_LEVELS && st == VV_OK; i++)
        st = read_level(out, node, multiscale, json_array_get(datasets, i), i == 0 ? notes : NULL, name);
    return st;
}
