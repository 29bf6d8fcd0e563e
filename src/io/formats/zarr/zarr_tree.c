/* Nodes of a hierarchy. A node's own files come first; where they are missing, consolidated metadata at the root may
 * know it. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr.h"
#include <string.h>

vv_status vvi_zarr_join(char out[VVI_ZARR_PATH], const char *a, const char *b)
{
    const char *parts[2] = {a, b};
    size_t n = 0;
    char joined[VVI_ZARR_PATH];
    for (int p = 0; p < 2; p++)
        for (const char *at = parts[p]; *at;) {
            const size_t m = strcspn(at, "/");
            const bool empty = m == 0 || (m == 1 && at[0] == '.');
            if (!empty && n + m + 2 > sizeof joined)
                return vv_fail(VV_E_LIMIT, "the path '%.100s...' has more than %d bytes", a, VVI_ZARR_PATH - 1);
            if (!empty) {
                if (n > 0)
                    joined[n++] = '/';
                memcpy(joined + n, at, m);
                n += m;
            }
            at += m + (at[m] == '/');
        }
    joined[n] = 0;
    memcpy(out, joined, n + 1);
    return VV_OK;
}

/* Metadata that is gathered in one file: {"metadata": {path: ...}}. Takes nothing, keeps a reference. */
static json_t *gathered(const json_t *file)
{
    json_t *all = json_object_get(file, "metadata");
    return json_is_object(all) ? json_incref(all) : NULL;
}

vv_status vvi_zarr_tree_open(vvi_zarr_tree *out, vv_source *folder, vv_job *job)
{
    json_t *file;
    *out = (vvi_zarr_tree){.folder = folder, .job = job};
    vv_status st = vvi_json_read_beside(&file, folder, ".zmetadata", job);
    if (st != VV_OK)
        return st;
    out->v2 = gathered(file);
    json_decref(file);
    if ((st = vvi_json_read_beside(&file, folder, "zarr.json", job)) != VV_OK)
        return st;
    out->v3 = gathered(json_object_get(file, "consolidated_metadata"));
    json_decref(file);
    return VV_OK;
}

void vvi_zarr_tree_close(vvi_zarr_tree *tree)
{
    json_decref(tree->v2);
    json_decref(tree->v3);
    *tree = (vvi_zarr_tree){0};
}

/* A file of the node, or what was gathered of it; *out is yours, NULL when there is none. */
static vv_status load(json_t **out, const vvi_zarr_tree *tree, const char *path, const char *file)
{
    char name[VVI_ZARR_PATH];
    vv_status st = vvi_zarr_join(name, path, file);
    if (st != VV_OK || (st = vvi_json_read_beside(out, tree->folder, name, tree->job)) != VV_OK || *out)
        return st;
    json_t *known = json_object_get(tree->v2, name);
    if (strcmp(file, "zarr.json") == 0)
        known = *path ? json_object_get(tree->v3, path) : NULL;
    *out = json_is_object(known) ? json_incref(known) : NULL;
    return VV_OK;
}

static vv_status check_version(const vvi_zarr_node *node, const vvi_zarr_tree *tree)
{
    int64_t version = 0;
    const json_t *said = json_object_get(node->meta, "zarr_format");
    if (vvi_json_whole(&version, said) && version == node->version)
        return VV_OK;
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(tree->folder), node->path, "its 'zarr_format' is not %d",
                      node->version);
}

static vv_status use_v3(vvi_zarr_node *node, const vvi_zarr_tree *tree)
{
    const char *type = vvi_json_text(node->meta, "node_type");
    node->version = 3;
    node->kind = type && strcmp(type, "array") == 0   ? VVI_ZARR_ARRAY
                 : type && strcmp(type, "group") == 0 ? VVI_ZARR_GROUP
                                                      : VVI_ZARR_NOTHING;
    json_t *attributes = json_object_get(node->meta, "attributes");
    node->attributes = json_is_object(attributes) ? json_incref(attributes) : NULL;
    if (node->kind == VVI_ZARR_NOTHING)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(tree->folder), node->path,
                          "its 'node_type' is neither array nor group");
    return check_version(node, tree);
}

static vv_status find_v2(vvi_zarr_node *node, const vvi_zarr_tree *tree)
{
    node->version = 2;
    vv_status st = load(&node->meta, tree, node->path, ".zarray");
    node->kind = node->meta ? VVI_ZARR_ARRAY : VVI_ZARR_GROUP;
    if (st == VV_OK && !node->meta)
        st = load(&node->meta, tree, node->path, ".zgroup");
    if (st != VV_OK || !node->meta) {
        node->kind = VVI_ZARR_NOTHING;
        return st;
    }
    st = check_version(node, tree);
    return st == VV_OK ? load(&node->attributes, tree, node->path, ".zattrs") : st;
}

vv_status vvi_zarr_node_open(vvi_zarr_node *out, const vvi_zarr_tree *tree, const char *path)
{
    memset(out, 0, sizeof *out);
    vv_status st = vvi_zarr_join(out->path, "", path);
    if (st == VV_OK)
        st = load(&out->meta, tree, out->path, "zarr.json");
    if (st != VV_OK)
        return st;
    return out->meta ? use_v3(out, tree) : find_v2(out, tree);
}

void vvi_zarr_node_close(vvi_zarr_node *node)
{
    json_decref(node->meta);
    json_decref(node->attributes);
    node->meta = node->attributes = NULL;
    node->kind = VVI_ZARR_NOTHING;
}

vv_status vvi_zarr_children(vvi_names *out, const vvi_zarr_tree *tree, const char *path)
{
    return vvi_source_list_folders(out, tree->folder, path, tree->job);
}

const json_t *vvi_zarr_ome(const vvi_zarr_node *node)
{
    const json_t *ome = json_object_get(node->attributes, "ome");
    return json_is_object(ome) ? ome : node->attributes;
}
