/* render --dry-run: what would be read and made, and the memory that it takes. */
#include "render_plan.h"
#include "core/memory.h"
#include "core/units.h"
#include "pipeline.h"
#include "render/picture.h"
#include "scene/resolve.h"
#include "value.h"
#include <inttypes.h>
#include <volvis/render.h>

/* What the method makes of each volume that shows a dataset. */
static uint64_t made_bytes(const vv_renderer *renderer, const vv_world *world, const vv_view *view, const char *data,
                           const vv_field_info *info)
{
    const vv_collection *methods = ((const vv_render_choice *)(const void *)view->render)->methods;
    const vv_object *params = vv_collection_find(methods, renderer->name);
    uint64_t bytes = 0;
    for (size_t i = 0; i < world->volumes->n && renderer->memory; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        const char *shown = vvi_volume_dataset_id(world, volume);
        vv_object *own = NULL;
        if (!volume->visible || !shown || strcmp(shown, data) != 0 || vvi_volume_params(&own, params, volume) != VV_OK)
            continue;
        bytes += renderer->memory(own, volume, info);
        vv_object_release(own);
    }
    return bytes;
}

/* Meshes are read to know how large they are. */
static vv_status plan_mesh(uint64_t *bytes, const vv_world *world, const vv_dataset *dataset, cli_command *command)
{
    vv_mesh *mesh;
    const vv_status st = vv_dataset_mesh(&mesh, world, dataset, command->job);
    if (st != VV_OK)
        return st;
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    cli_command_line(command, "reads", "%s: %zu %s", dataset->path ? dataset->path : "(memory)", m->n_triangles,
                     cli_plural(m->n_triangles, "triangle", "triangles"));
    *bytes += 40 * (uint64_t)m->n_vertices + 28 * (uint64_t)m->n_triangles; /* and places on the picture */
    vv_mesh_release(mesh);
    return VV_OK;
}

/* Of a picture that is made part by part, its middle tells. */
enum { PART_ROWS = 4 * VVI_TILE };

static void tell_times(cli_command *command, const vv_render_report *report, double render_s)
{
    char all[32], load[32], prepare[32], render[32];
    cli_value_duration(all, report->load_s + report->prepare_s + render_s);
    cli_value_duration(load, report->load_s);
    cli_value_duration(prepare, report->prepare_s);
    cli_value_duration(render, render_s);
    cli_command_line(command, "takes",
                     "about %s on %d %s, an estimate from a few tiles: %s to read, %s to prepare, %s to render", all,
                     report->threads, cli_plural((size_t)report->threads, "thread", "threads"), load, prepare, render);
}

/* Data are read for it: what does not fit is refused. */
static vv_status tell_time(cli_command *command, vv_world *world, const vv_view *view, const char *id, bool in_parts)
{
    double render_s = 0;
    vv_render_report report;
    vv_picture *picture;
    const int32_t height = (int32_t)view->height, top = height / 2 / VVI_TILE * VVI_TILE;
    const int32_t rows = height - top < PART_ROWS ? height - top : PART_ROWS;
    vv_status st = in_parts ? vvi_picture_new_rows(&picture, world, id, top, rows, command->job)
                            : vv_picture_new(&picture, world, id, false, command->job);
    if (st != VV_OK)
        return st;
    st = vv_picture_estimate(&render_s, picture, command->job);
    render_s *= in_parts ? (double)height / rows : 1;
    vv_picture_report(&report, picture);
    vv_picture_free(picture);
    if (st != VV_OK)
        return st;
    tell_times(command, &report, render_s);
    vvi_result_number(&command->json, "estimated_s", report.load_s + report.prepare_s + render_s);
    vvi_result_number(&command->json, "estimated_render_s", render_s);
    return VV_OK;
}

vv_status cli_render_plan(cli_command *command, vv_world *world, const char *view_id, const char *output, bool in_parts)
{
    const vv_view *view = vvi_view_named(world, view_id);
    const vv_renderer *renderer = vv_registry_renderer(command->registry, vvi_method_of(world, view, command->job));
    vv_status st = VV_OK;
    char needed[32];
    if (!renderer)
        return vv_error_last()->status;
    uint64_t picture, bytes;
    bool at_once;
    if ((st = vv_render_memory(&picture, &at_once, world, view_id, command->job)) != VV_OK)
        return st;
    bytes = picture;
    for (size_t i = 0; i < world->datasets->n && st == VV_OK; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        vv_field_info info;
        uint64_t samples = 0;
        char about[128];
        const bool made = vv_dataset_is_made(dataset), mesh = vv_dataset_is_mesh(dataset, command->job);
        if (made && mesh) {
            cli_command_line(command, "works out", "%s: a mesh, by %s", world->datasets->entry[i].id,
                             dataset->operation);
            continue;
        }
        if (mesh) {
            st = plan_mesh(&bytes, world, dataset, command);
            continue;
        }
        if ((st = vv_dataset_info(&info, world, dataset, command->job)) != VV_OK ||
            (st = vv_field_info_bytes(&samples, &info)) != VV_OK)
            return st;
        vvi_samples_print(about, &info, info.n_frames);
        if (made)
            cli_command_line(command, "works out", "%s: %s, by %s", world->datasets->entry[i].id, about,
                             dataset->operation);
        else
            cli_command_line(command, "reads", "%s: %s", dataset->path ? dataset->path : "(memory)", about);
        bytes += samples + made_bytes(renderer, world, view, world->datasets->entry[i].id, &info);
    }
    const uint64_t limit = vv_runtime_memory_limit(command->runtime);
    const bool limited = bytes > limit; /* part by part, and from bricks; what cannot is refused below */
    bytes = limited ? limit : bytes;
    vvi_print_bytes(needed, bytes);
    cli_command_line(command, "makes", "%s: %" PRId64 " x %" PRId64 " pixels", output, view->width, view->height);
    cli_command_line(command, "needs", "at most %s%s for samples, what is made of them, and picture", needed,
                     limited ? ", the limit," : "");
    vvi_result_string(&command->json, "output", output);
    vvi_result_integer(&command->json, "width", view->width);
    vvi_result_integer(&command->json, "height", view->height);
    vvi_result_unsigned(&command->json, "memory_bytes", bytes);
    vvi_result_bool(&command->json, "dry_run", true);
    if (in_parts)
        cli_command_line(command, "", "the picture is made part by part, within the memory limit");
    else
        st = vvi_memory_plan(command->job, picture, "the picture");
    vvi_result_bool(&command->json, "in_parts", in_parts);
    return st == VV_OK ? tell_time(command, world, view, view_id, in_parts) : st;
}
