/* Zarr and OME-Zarr: the reader's row. Its source is a folder. */
#include "io/formats/zarr/zarr.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr_write.h"
#include "registry.h"
#include <string.h>

typedef struct plan {
    vvi_zarr_array array;
    vvi_zarr_axes axes;
    char path[VVI_ZARR_PATH];
} plan;

static int probe_folder(vv_source *folder, vv_job *job)
{
    static const char *const files[] = {"zarr.json", ".zgroup", ".zarray", ".zmetadata"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        vv_source *file;
        if (vvi_source_find_beside(&file, folder, files[i], job) != VV_OK)
            return 1; /* it is there, and what is wrong with it is said later */
        const bool there = file != NULL;
        vvi_source_close(file);
        if (there)
            return 2;
    }
    return 0;
}

/* Attributes that are text or numbers are for people; those that are structures have readers of their own. */
static vv_status add_attributes(const json_t *attributes, vv_notes *notes)
{
    const char *key;
    json_t *value;
    vv_status st = VV_OK;
    json_object_foreach((json_t *)attributes, key, value)
    {
        char number[64];
        if (st != VV_OK)
            break;
        if (json_is_integer(value))
            snprintf(number, sizeof number, "%lld", (long long)json_integer_value(value));
        else if (json_is_real(value))
            snprintf(number, sizeof number, "%.17g", json_real_value(value));
        else if (json_is_boolean(value))
            snprintf(number, sizeof number, "%s", json_is_true(value) ? "true" : "false");
        else if (!json_is_string(value))
            continue;
        st = vvi_notes_add(notes, key, json_is_string(value) ? json_string_value(value) : number);
    }
    return st;
}

static vv_status add_notes(const vvi_zarr_choice *c, vv_notes *notes)
{
    vv_status st = vvi_notes_add(notes, "zarr_format", c->array_node.version == 2 ? "2" : "3");
    const json_t *ome = vvi_zarr_ome(&c->image_node);
    const char *version = vvi_json_text(ome, "version");
    if (!version)
        version = vvi_json_text(json_array_get(json_object_get(ome, "multiscales"), 0), "version");
    if (st == VV_OK && version)
        st = vvi_notes_add(notes, "ome_zarr_version", version);
    if (st == VV_OK && c->image && c->image->name[0])
        st = vvi_notes_add(notes, "image_name", c->image->name);
    if (st == VV_OK)
        st = add_attributes(c->image_node.attributes, notes);
    return st == VV_OK ? add_attributes(c->array_node.attributes, notes) : st;
}

static vv_status use_choice(vv_field_info *info, plan *p, const vvi_zarr_choice *c, const vvi_zarr_tree *tree,
                            vv_notes *notes)
{
    const vv_source *source = tree->folder;
    vv_job *job = tree->job;
    p->array = c->array;
    memcpy(p->path, c->array_node.path, sizeof p->path);
    vv_status st = vvi_zarr_place(info, &p->axes, &p->array, c->image, c->level, notes, vvi_source_name(source));
    if (st == VV_OK && c->image)
        st = vvi_zarr_describe(info, &c->image_node, notes, job);
    if (st == VV_OK && !c->image)
        st = vvi_zarr_lines(info, &p->array, &p->axes, tree, p->path, notes);
    if (st == VV_OK)
        st = vvi_zarr_take_cf(info, &p->array, &c->array_node, notes);
    return st == VV_OK ? add_notes(c, notes) : st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    vvi_zarr_tree tree;
    vvi_zarr_choice choice = {0};
    *plan_out = NULL;
    if (!vvi_source_is_folder(source))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "is a file; a Zarr is a folder: name that");
    plan *p = vvi_alloc(job, sizeof *p, VVI_MEM_MODEL);
    if (!p)
        return vv_fail_memory(sizeof *p);
    vv_status st = vvi_zarr_tree_open(&tree, source, job);
    tree.finest = options->finest;
    if (st == VV_OK)
        st = vvi_zarr_choose(&choice, &tree, options->part, notes);
    if (st == VV_OK)
        st = use_choice(info, p, &choice, &tree, notes);
    vvi_zarr_choice_close(&choice);
    vvi_zarr_tree_close(&tree);
    if (st != VV_OK)
        vvi_free(p);
    else
        *plan_out = p;
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan_in, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const plan *p = plan_in;
    return vvi_zarr_read(out, info, &p->array, &p->axes, source, p->path, frame, region, job);
}

static void free_plan(void *plan_in)
{
    vvi_free(plan_in);
}

static const char *const suffixes[] = {".ome.zarr", ".zarr", NULL};

const vv_format vvi_format_ome_zarr = {
    .beside = true,
    .boxes = true,
    .api = VV_FORMAT_API,
    .name = "ome-zarr",
    .doc = "Zarr 2 and 3 folders and OME-Zarr images in them; written as OME-Zarr 0.4",
    .suffixes = suffixes,
    .probe_folder = probe_folder,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .encodings = vvi_zarr_encodings,
    .write = vvi_zarr_write_0_4,
    .folder_file = vvi_zarr_folder_file,
};
