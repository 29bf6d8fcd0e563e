/* render --dry-run: what would be read and made, and the memory that it takes. */
#include "render_plan.h"
#include "core/memory.h"
#include "core/units.h"
#include "pipeline.h"
#include <inttypes.h>

/* Colour and depth of a pixel, and the same once more for a coarse picture; colours of a pass, of the mean of passes,
 * and of half of them; once these are gone, what decorations need, and then the file; least and largest values by
 * cells: a twentieth of the samples, and never nothing; the threads' own. */
enum { PIXEL_BYTES = 20, COARSE_BYTES = 20, PASSES_BYTES = 32, NOISE_BYTES = 16, AFTER_BYTES = 8 };
enum { CELLS_BYTES = 2 << 20, THREADS_BYTES = 4 << 20 };

static uint64_t picture_bytes(const vv_view *view)
{
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)view->render;
    uint64_t bytes = 0;
    const bool coarse =
        vv_object_is_set(&choice->base, "adaptive") ? choice->adaptive : choice->quality == VV_QUALITY_DRAFT;
    const bool one = vv_object_is_set(&choice->base, "samples") ? choice->samples == 1 : coarse;
    if (!one || choice->noise > 0 || choice->budget > 0)
        bytes += PASSES_BYTES;
    else if (coarse)
        bytes += COARSE_BYTES;
    if (choice->noise > 0)
        bytes += NOISE_BYTES;
    bytes = PIXEL_BYTES + (bytes > AFTER_BYTES ? bytes : AFTER_BYTES);
    return (uint64_t)view->width * (uint64_t)view->height * bytes + THREADS_BYTES;
}

/* Meshes are read to know how large they are. */
static vv_status plan_mesh(uint64_t *bytes, const vv_dataset *dataset, cli_command *command)
{
    vv_mesh *mesh;
    const vv_status st = vv_dataset_mesh(&mesh, dataset, command->job);
    if (st != VV_OK)
        return st;
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    cli_command_line(command, "reads", "%s: %zu triangles", dataset->path ? dataset->path : "(memory)", m->n_triangles);
    *bytes += 40 * (uint64_t)m->n_vertices + 28 * (uint64_t)m->n_triangles; /* and places on the picture */
    vv_mesh_release(mesh);
    return VV_OK;
}

vv_status cli_render_plan(cli_command *command, const vv_world *world, const vv_view *view, const char *output)
{
    const uint64_t picture = picture_bytes(view);
    uint64_t bytes = picture;
    char needed[32];
    vv_status st = VV_OK;
    for (size_t i = 0; i < world->datasets->n && st == VV_OK; i++) {
        const vv_dataset *dataset = (const vv_dataset *)(const void *)world->datasets->entry[i].object;
        vv_field_info info;
        uint64_t samples = 0;
        char about[128];
        if (vv_dataset_is_mesh(dataset, command->job)) {
            st = plan_mesh(&bytes, dataset, command);
            continue;
        }
        if ((st = vv_dataset_info(&info, dataset, command->job)) != VV_OK ||
            (st = vv_field_info_bytes(&samples, &info)) != VV_OK)
            return st;
        cli_describe_info(about, &info, info.n_frames);
        cli_command_line(command, "reads", "%s: %s", dataset->path ? dataset->path : "(memory)", about);
        bytes += samples + samples / 20 + CELLS_BYTES;
    }
    vvi_print_bytes(needed, bytes);
    cli_command_line(command, "makes", "%s: %" PRId64 " x %" PRId64 " pixels", output, view->width, view->height);
    cli_command_line(command, "needs", "at most %s for samples, what is made of them, and picture", needed);
    vvi_result_string(&command->json, "output", output);
    vvi_result_integer(&command->json, "width", view->width);
    vvi_result_integer(&command->json, "height", view->height);
    vvi_result_unsigned(&command->json, "memory_bytes", bytes);
    vvi_result_bool(&command->json, "dry_run", true);
    return vvi_memory_plan(command->job, picture, "the picture");
}
