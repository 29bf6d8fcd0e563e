#include "render/recipe.h"
#include "core/memory.h"
#include "core/text.h"
#include "model/file_path.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>
#include <volvis/version.h>

static const char *find(const vv_text *text, size_t n, const char *key)
{
    for (size_t i = 0; i < n; i++) {
        if (strcmp(text[i].key, key) == 0)
            return text[i].value;
    }
    return NULL;
}

/* Whether it is an image, and whether a scene is in it. */
static bool look(bool *scene_out, const char *path, vv_job *job)
{
    vv_text *text = NULL;
    size_t n = 0;
    *scene_out = false;
    if (vv_image_read_text(&text, &n, path, job) != VV_OK)
        return false;
    *scene_out = find(text, n, VVI_KEY_SCENE) != NULL;
    vv_text_free(text, n);
    return true;
}

bool vvi_recipe_is_missing(const char *path, vv_job *job)
{
    bool scene;
    return look(&scene, path, job) && !scene;
}

bool vvi_recipe_is_there(const char *path, vv_job *job)
{
    bool scene;
    return look(&scene, path, job) && scene;
}

vv_status vvi_recipe_read(vv_world **world_out, vvi_recipe *recipe_out, const char *path, vv_job *job)
{
    vv_text *text = NULL;
    size_t n = 0;
    vv_status st;
    *world_out = NULL;
    *recipe_out = (vvi_recipe){0};
    if ((st = vv_image_read_text(&text, &n, path, job)) != VV_OK)
        return st;
    const char *scene = find(text, n, VVI_KEY_SCENE);
    const char *view = find(text, n, VVI_KEY_VIEW), *bits = find(text, n, VVI_KEY_BITS);
    char *folder = vvi_folder_of(path);
    if (view)
        snprintf(recipe_out->view, sizeof recipe_out->view, "%s", view);
    if (bits)
        recipe_out->bits = strcmp(bits, "32") == 0 ? 32 : strcmp(bits, "16") == 0 ? 16 : 8;
    if (!scene)
        st = vv_fail_at(VV_E_FORMAT, path, NULL, "the picture holds no scene: it was not made by VolVis");
    else if (!folder)
        st = vv_fail_memory(strlen(path));
    else
        st = vv_scene_parse(world_out, scene, strlen(scene), path, folder, job);
    free(folder);
    vv_text_free(text, n);
    return st;
}

static vv_status checksum_of(uint32_t *out, const vv_dataset *dataset, vv_job *job)
{
    vv_field *field = NULL;
    vv_mesh *mesh = NULL;
    vv_status st;
    if (vv_dataset_is_mesh(dataset, job)) {
        if ((st = vv_dataset_mesh(&mesh, NULL, dataset, job)) == VV_OK)
            *out = vv_mesh_checksum(mesh);
        vv_mesh_release(mesh);
        return st;
    }
    if ((st = vv_dataset_field(&field, NULL, dataset, NULL, 0, job)) == VV_OK)
        st = vv_field_checksum(out, field, job);
    vv_field_release(field);
    return st;
}

static vv_status add_checksum(vv_object **world, const vv_entry *entry, vv_job *job)
{
    const vv_dataset *dataset = (const vv_dataset *)(const void *)entry->object;
    char path[160], value[32];
    uint32_t crc = 0;
    vv_status st;
    if (!dataset->path)
        return VV_OK;
    if ((st = checksum_of(&crc, dataset, job)) == VV_OK) {
        snprintf(path, sizeof path, "datasets.%s.checksum", entry->id);
        snprintf(value, sizeof value, "crc32:%08" PRIx32, crc);
        st = vv_path_set(world, path, value, NULL);
    }
    return st;
}

vv_status vvi_recipe_fix(vv_world **out, vv_world *world, const char *view, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_world *fixed = NULL;
    vv_status st;
    *out = NULL;
    if ((st = vv_scene_resolve(&scene, world, view, job)) != VV_OK)
        return st;
    if ((st = vv_scene_fix(&fixed, scene)) == VV_OK) {
        vv_object *root = &fixed->base;
        for (size_t i = 0; i < world->datasets->n && st == VV_OK; i++)
            st = add_checksum(&root, &world->datasets->entry[i], job);
        fixed = (vv_world *)(void *)root;
    }
    vv_scene_release(scene);
    if (st == VV_OK)
        *out = fixed;
    else if (fixed)
        vv_object_release(&fixed->base);
    return st;
}

static void list_checksums(vvi_text *out, const vv_world *world)
{
    for (size_t i = 0; i < world->datasets->n; i++) {
        const vv_entry *entry = &world->datasets->entry[i];
        const vv_dataset *dataset = (const vv_dataset *)(const void *)entry->object;
        if (dataset->checksum)
            vvi_text_printf(out, "%s%s %s", out->n ? ", " : "", entry->id, dataset->checksum);
    }
}

static bool put(vv_text *text, size_t *n, const char *key, const char *value)
{
    text[*n] = (vv_text){vvi_strdup(key), vvi_strdup(value ? value : "")};
    (*n)++;
    return text[*n - 1].key && text[*n - 1].value;
}

vv_status vvi_recipe_text(vv_text **out, size_t *n_out, const vv_world *fixed, const vvi_recipe *recipe,
                          const char *path)
{
    enum { MOST = 8 };
    char software[32], seed[32], bits[16];
    const bool to_stream = strcmp(path, "-") == 0;
    char *scene = NULL, *folder = to_stream ? NULL : vvi_folder_of(path);
    vvi_text data = {0};
    vv_text *text = vvi_calloc(MOST, sizeof *text);
    size_t n = 0;
    vv_status st = text && (folder || to_stream) ? vv_scene_print(&scene, fixed, folder) : vv_fail_memory(strlen(path));
    list_checksums(&data, fixed);
    snprintf(software, sizeof software, "VolVis %s", vv_version());
    snprintf(seed, sizeof seed, "%" PRId64, fixed->seed);
    snprintf(bits, sizeof bits, "%d", recipe->bits);
    if (st == VV_OK &&
        !(!data.bad && put(text, &n, "Software", software) && put(text, &n, VVI_KEY_VERSION, vv_version()) &&
          put(text, &n, VVI_KEY_VIEW, recipe->view) && put(text, &n, VVI_KEY_SEED, seed) &&
          (recipe->bits == 0 || put(text, &n, VVI_KEY_BITS, bits)) && put(text, &n, VVI_KEY_RAYS, recipe->rays) &&
          put(text, &n, VVI_KEY_DATA, data.s) && put(text, &n, VVI_KEY_SCENE, scene)))
        st = vv_fail_memory(MOST * sizeof *text);
    vvi_text_free(&data);
    free(scene);
    free(folder);
    if (st != VV_OK) {
        vv_text_free(text, n);
        return st;
    }
    *out = text;
    *n_out = n;
    return VV_OK;
}
