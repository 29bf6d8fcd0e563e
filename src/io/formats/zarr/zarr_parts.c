/* What a hierarchy holds, and which of it is read. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr.h"
#include <string.h>

#define PARTS_MOST 4096

typedef struct walk {
    const vvi_zarr_tree *tree;
    vv_notes *notes;    /* NULL: only to find */
    const char *chosen; /* path that is read */
    size_t n;           /* parts seen */
    bool full;
    char best[VVI_ZARR_PATH]; /* the first image, or the array of most samples */
    bool best_is_image;
    uint64_t best_samples;
} walk;

static void describe_array(char *out, size_t room, const vvi_zarr_array *a)
{
    size_t n = 0;
    out[0] = 0;
    for (int i = a->n_axes - 1; i >= 0 && n < room; i--)
        n += (size_t)snprintf(out + n, room - n, "%s%lld", n ? " x " : "", (long long)a->shape[i]);
    if (n < room)
        snprintf(out + n, room - n, " %s", vv_type_name(a->type.type));
}

static vv_status add_part(walk *w, const char *path, const char *about)
{
    if (w->n++ >= PARTS_MOST) {
        w->full = true;
        return VV_OK;
    }
    if (!w->notes)
        return VV_OK;
    return vvi_notes_part(w->notes, path, about, strcmp(path, w->chosen) == 0);
}

/* Each of these looks at a node and at those below it. */
static vv_status visit(walk *w, const char *path, int depth);

static vv_status visit_children(walk *w, const char *path, int depth)
{
    vvi_names names;
    if ((uint64_t)depth >= vvi_job_limits(w->tree->job)->nesting)
        return VV_OK;
    vv_status st = vvi_zarr_children(&names, w->tree, path);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < names.n && st == VV_OK && !w->full; i++) {
        char child[VVI_ZARR_PATH];
        if (vvi_zarr_join(child, "", names.name[i]) != VV_OK)
            continue; /* too long to be named */
        if ((st = vvi_job_poll(w->tree->job)) == VV_OK)
            st = visit(w, child, depth + 1);
    }
    vvi_names_free(&names);
    return st;
}

static vv_status visit_array(walk *w, const vvi_zarr_node *node)
{
    vvi_zarr_array array;
    char about[160] = "";
    uint64_t samples = 1;
    if (vvi_zarr_array_of(&array, node, w->tree) != VV_OK) {
        snprintf(about, sizeof about, "cannot be read");
    } else {
        describe_array(about, sizeof about, &array);
        for (int i = 0; i < array.n_axes; i++)
            samples *= (uint64_t)array.shape[i];
        if (!w->best_is_image && samples > w->best_samples) {
            memcpy(w->best, node->path, sizeof w->best);
            w->best_samples = samples;
        }
    }
    return add_part(w, node->path, about);
}

/* The wells of a plate are groups that list images. */
static vv_status visit_image(walk *w, const vvi_zarr_node *node, int depth)
{
    char below[VVI_ZARR_PATH], about[80];
    const json_t *multiscale = json_array_get(json_object_get(vvi_zarr_ome(node), "multiscales"), 0);
    if (!w->best_is_image) {
        memcpy(w->best, node->path, sizeof w->best);
        w->best_is_image = true;
    }
    vvi_json_copy_text(about, sizeof about, vvi_json_text(multiscale, "name"));
    vv_status st = add_part(w, node->path, about);
    if (st == VV_OK && (st = vvi_zarr_join(below, node->path, "labels")) == VV_OK)
        st = visit_children(w, below, depth);
    return st;
}

static vv_status visit(walk *w, const char *path, int depth)
{
    vvi_zarr_node node;
    vv_status st = vvi_zarr_node_open(&node, w->tree, path);
    if (st == VV_E_FORMAT || st == VV_E_READ || node.kind == VVI_ZARR_NOTHING)
        st = st == VV_E_FORMAT || st == VV_E_READ ? VV_OK : st; /* what cannot be read is no part */
    else if (st == VV_OK && node.kind == VVI_ZARR_ARRAY)
        st = visit_array(w, &node);
    else if (st == VV_OK && vvi_zarr_is_image(&node))
        st = visit_image(w, &node, depth);
    else if (st == VV_OK)
        st = visit_children(w, path, depth);
    vvi_zarr_node_close(&node);
    return st;
}

/* Levels --------------------------------------------------------------------------------------------------------- */

static vv_status open_array(vvi_zarr_choice *c, const vvi_zarr_tree *tree, const char *path)
{
    vvi_zarr_node_close(&c->array_node);
    vv_status st = vvi_zarr_node_open(&c->array_node, tree, path);
    if (st == VV_OK && c->array_node.kind != VVI_ZARR_ARRAY)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(tree->folder), NULL,
                        "has no array '%.200s', which its image names", path);
    return st == VV_OK ? vvi_zarr_array_of(&c->array, &c->array_node, tree) : st;
}

/* Bytes of one frame of a level. */
static uint64_t frame_bytes(const vvi_zarr_choice *c)
{
    uint64_t bytes = vv_type_bytes(c->array.type.type);
    for (int i = 0; i < c->array.n_axes; i++)
        if (i >= c->image->n_axes || c->image->axis[i].role != VVI_ROLE_FRAME)
            bytes *= (uint64_t)c->array.shape[i];
    return bytes;
}

/* The finest level that memory has room for. */
static vv_status choose_level(vvi_zarr_choice *c, const vvi_zarr_tree *tree, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (c->level = 0; c->level < c->image->n_levels; c->level++) {
        if ((st = open_array(c, tree, c->image->level[c->level].path)) != VV_OK)
            return st;
        const uint64_t bytes = frame_bytes(c);
        if (tree->finest || c->level == c->image->n_levels - 1 ||
            vvi_memory_plan(tree->job, bytes + bytes / 4, "volume") == VV_OK)
            break;
    }
    if (c->level == 0)
        return VV_OK;
    return vvi_notes_warn(notes,
                          "level 0 of %d does not fit into memory: level %d ('%.200s') is read; raise --memory, "
                          "or name a level with FILE:NAME",
                          c->image->n_levels, c->level, c->image->level[c->level].path);
}

static vv_status add_levels(walk *w, const vvi_zarr_choice *c)
{
    vv_status st = VV_OK;
    for (int i = 0; i < c->image->n_levels && st == VV_OK; i++) {
        vvi_zarr_node node;
        vvi_zarr_array array;
        char about[160] = "cannot be read";
        st = vvi_zarr_node_open(&node, w->tree, c->image->level[i].path);
        if (st == VV_OK && node.kind == VVI_ZARR_ARRAY && vvi_zarr_array_of(&array, &node, w->tree) == VV_OK)
            describe_array(about, sizeof about, &array);
        vvi_zarr_node_close(&node);
        st = st == VV_E_FORMAT || st == VV_E_READ ? VV_OK : st;
        if (st == VV_OK)
            st = add_part(w, c->image->level[i].path, about);
    }
    return st;
}

/* Choosing ------------------------------------------------------------------------------------------------------- */

static vv_status use_image(vvi_zarr_choice *c, const vvi_zarr_tree *tree, vv_notes *notes)
{
    c->image = vvi_alloc(tree->job, sizeof *c->image, VVI_MEM_SCRATCH);
    if (!c->image)
        return vv_fail_memory(sizeof *c->image);
    return vvi_zarr_image_of(c->image, &c->image_node, notes, vvi_source_name(tree->folder));
}

/* The image of which an array is a level: in a group above it. */
static vv_status find_image(vvi_zarr_choice *c, const vvi_zarr_tree *tree, const char *path, vv_notes *notes)
{
    char above[VVI_ZARR_PATH];
    memcpy(above, path, sizeof above);
    while (*above) {
        char *slash = strrchr(above, '/');
        *(slash ? slash : above) = 0;
        vv_status st = vvi_zarr_node_open(&c->image_node, tree, above);
        if (st == VV_OK && vvi_zarr_is_image(&c->image_node)) {
            if ((st = use_image(c, tree, notes)) != VV_OK)
                return st;
            for (c->level = 0; c->level < c->image->n_levels; c->level++)
                if (strcmp(c->image->level[c->level].path, path) == 0)
                    return VV_OK;
            vvi_free(c->image);
            c->image = NULL;
        }
        vvi_zarr_node_close(&c->image_node);
        if (st != VV_OK && st != VV_E_FORMAT && st != VV_E_READ)
            return st;
    }
    c->level = 0;
    return VV_OK;
}

static vv_status list_parts(const vvi_zarr_choice *c, const vvi_zarr_tree *tree, const char *path, vv_notes *notes)
{
    vvi_zarr_node root;
    walk *w = vvi_alloc_zeroed(tree->job, sizeof *w, VVI_MEM_SCRATCH);
    if (!w)
        return vv_fail_memory(sizeof *w);
    w->tree = tree;
    w->notes = notes;
    w->chosen = path;
    vv_status st = vvi_zarr_node_open(&root, tree, "");
    const bool single = st == VV_OK && vvi_zarr_is_image(&root);
    if (st == VV_OK && c->image && (single || c->image->n_levels > 1 || *c->image_node.path)) {
        w->chosen = c->array_node.path;
        st = add_levels(w, c);
        w->chosen = "";
    }
    if (st == VV_OK && root.kind == VVI_ZARR_GROUP)
        st = visit_children(w, single ? "labels" : "", 0);
    vvi_zarr_node_close(&root);
    if (st == VV_OK && w->full)
        st = vvi_notes_warn(notes, "holds more than %d arrays; only so many are listed", PARTS_MOST);
    vvi_free(w);
    return st;
}

/* With the names of those that there are. */
static vv_status fail_unknown(const vvi_zarr_tree *tree, const char *path, vv_notes *notes)
{
    static const vvi_zarr_choice none = {0};
    const vv_status st = list_parts(&none, tree, "", notes);
    if (st != VV_OK)
        return st;
    return vvi_notes_fail_part(notes, VV_E_NOT_FOUND, vvi_source_name(tree->folder), "array or group", path);
}

static vv_status fail_empty(const vvi_zarr_tree *tree, const char *path)
{
    const char *name = vvi_source_name(tree->folder);
    if (!*path)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is a Zarr group without arrays that can be read");
    return vv_fail_at(VV_E_FORMAT, name, NULL, "its group '%.200s' has no arrays that can be read", path);
}

/* A group that is no image: the first image in it, or the array of most samples. */
static vv_status choose_below(char path[VVI_ZARR_PATH], const vvi_zarr_tree *tree, vv_notes *notes)
{
    walk *w = vvi_alloc_zeroed(tree->job, sizeof *w, VVI_MEM_SCRATCH);
    if (!w)
        return vv_fail_memory(sizeof *w);
    w->tree = tree;
    w->chosen = "";
    vv_status st = visit_children(w, path, 0);
    if (st == VV_OK && !*w->best)
        st = fail_empty(tree, path);
    if (st == VV_OK && w->n > 1)
        st = vvi_notes_warn(notes, "holds %zu arrays or images; '%.200s' is read; name another with FILE:NAME", w->n,
                            w->best);
    memcpy(path, w->best, sizeof w->best);
    vvi_free(w);
    return st;
}

static vv_status open_chosen(vvi_zarr_choice *c, const vvi_zarr_tree *tree, char path[VVI_ZARR_PATH], vv_notes *notes)
{
    vv_status st = vvi_zarr_node_open(&c->array_node, tree, path);
    if (st == VV_OK && c->array_node.kind == VVI_ZARR_GROUP && !vvi_zarr_is_image(&c->array_node)) {
        vvi_zarr_node_close(&c->array_node);
        if ((st = choose_below(path, tree, notes)) == VV_OK)
            st = vvi_zarr_node_open(&c->array_node, tree, path);
    }
    if (st != VV_OK)
        return st;
    if (c->array_node.kind == VVI_ZARR_NOTHING)
        return fail_unknown(tree, path, notes);
    if (c->array_node.kind == VVI_ZARR_ARRAY) {
        st = find_image(c, tree, path, notes);
        return st == VV_OK ? vvi_zarr_array_of(&c->array, &c->array_node, tree) : st;
    }
    c->image_node = c->array_node;
    memset(&c->array_node, 0, sizeof c->array_node);
    st = use_image(c, tree, notes);
    return st == VV_OK ? choose_level(c, tree, notes) : st;
}

vv_status vvi_zarr_choose(vvi_zarr_choice *out, const vvi_zarr_tree *tree, const char *part, vv_notes *notes)
{
    char path[VVI_ZARR_PATH];
    memset(out, 0, sizeof *out);
    vv_status st = vvi_zarr_join(path, "", part ? part : "");
    if (st == VV_OK)
        st = open_chosen(out, tree, path, notes);
    return st == VV_OK ? list_parts(out, tree, path, notes) : st;
}

void vvi_zarr_choice_close(vvi_zarr_choice *choice)
{
    vvi_zarr_node_close(&choice->array_node);
    vvi_zarr_node_close(&choice->image_node);
    vvi_free(choice->image);
    choice->image = NULL;
}
