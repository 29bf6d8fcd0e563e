#include "command.h"
#include "core/units.h"
#include "io/source.h"
#include "libraries.h"
#include "verbs.h"
#include <inttypes.h>
#include <stdio.h>
#include <volvis/render.h>
#include <volvis/version.h>

typedef struct doctor_options {
    vv_object base;
    bool limits;
} doctor_options;

static const vv_property rows[] = {
    {VV_PROP(doctor_options, limits), .kind = VV_KIND_BOOL, .doc = "the limits on what comes from outside"},
    {0},
};

static const vv_class options_class = {
    .name = "doctor",
    .doc = "options of doctor",
    .size = sizeof(doctor_options),
    .properties = rows,
};

static void say(cli_command *command, const char *name, bool ok, const char *text)
{
    cli_json_open(&command->json, NULL, '{');
    cli_json_string(&command->json, "check", name);
    cli_json_bool(&command->json, "ok", ok);
    cli_json_string(&command->json, "found", text);
    cli_json_close(&command->json, '}');
    cli_command_line(command, name, "%s%s", ok ? "" : "MISSING: ", text);
}

static void check_machine(cli_command *command)
{
    char text[160], memory[32];
    vvi_print_bytes(memory, vv_runtime_memory_limit(command->runtime));
    snprintf(text, sizeof text, "%s kernels", vv_runtime_isa(command->runtime));
    say(command, "CPU", true, text);
    snprintf(text, sizeof text, "%d", vv_runtime_threads(command->runtime));
    say(command, "threads", true, text);
    snprintf(text, sizeof text, "at most %s are held (--memory changes it)", memory);
    say(command, "memory", true, text);
}

static void check_libraries(cli_command *command)
{
    cli_library library;
    char text[160];
    for (size_t i = 0; cli_library_nth(&library, i); i++) {
        if (*library.version)
            snprintf(text, sizeof text, "%s: %s", library.version, library.purpose);
        else
            snprintf(text, sizeof text, "built without it, so no %s", library.purpose);
        say(command, library.name, *library.version != 0, text);
    }
}

/* A ball of 16 samples: file formats apart, everything that a picture needs has to work for it. */
static vv_status render_ball(cli_command *command, size_t *lit_out)
{
    enum { N = 16 };
    vv_field_info info = vv_field_info_default();
    vv_field *field = NULL;
    vv_world *world = NULL;
    vv_image *image = NULL;
    void *data = NULL;
    vv_status st;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N;
    if ((st = vv_field_new_empty(&field, &data, &info, command->job)) != VV_OK)
        return st;
    for (int i = 0; i < N * N * N; i++) {
        const int x = 2 * (i % N) - 15, y = 2 * (i / N % N) - 15, z = 2 * (i / N / N) - 15;
        ((uint8_t *)data)[i] = x * x + y * y + z * z < 12 * 12 ? 200 : 0;
    }
    if ((st = vv_world_for_field(&world, "ball", field, command->job)) == VV_OK &&
        (st = vv_render(&image, NULL, world, NULL, NULL, command->job)) == VV_OK) {
        for (int64_t p = 0; p < (int64_t)image->width * image->height; p++)
            *lit_out += image->rgba[4 * p] > 0 || image->rgba[4 * p + 1] > 0 || image->rgba[4 * p + 2] > 0;
    }
    vv_image_release(image);
    if (world)
        vv_object_release(&world->base);
    vv_field_release(field);
    return st;
}

static vv_status check_picture(cli_command *command)
{
    char text[256];
    size_t lit = 0;
    const vv_status st = render_ball(command, &lit);
    if (st == VV_E_CANCELLED)
        return st;
    if (st != VV_OK)
        snprintf(text, sizeof text, "a test picture failed: %s", vv_error_last()->message);
    else if (lit == 0)
        snprintf(text, sizeof text, "a test picture came out empty");
    else
        snprintf(text, sizeof text, "a test picture shows its ball");
    say(command, "rendering", st == VV_OK && lit > 0, text);
    if (st != VV_OK || lit == 0)
        command->exit_code = CLI_EXIT_FAILED;
    return VV_OK;
}

static void report_limits(cli_command *command)
{
    const vvi_limits *l = &vvi_limits_default;
    const struct {
        const char *name, *about;
        uint64_t value;
    } limits[] = {
        {"dim", "samples along one axis", l->dim},
        {"voxels", "samples of one volume", l->voxels},
        {"header_bytes", "bytes of a header", l->header_bytes},
        {"metadata_keys", "entries of metadata", l->metadata_keys},
        {"string_bytes", "bytes of one text", l->string_bytes},
        {"files", "data files of one header", l->files},
        {"expansion_gzip", "times that gzip data may grow", l->expansion_gzip},
        {"expansion_zstd", "times that zstd data may grow", l->expansion_zstd},
    };
    cli_json_open(&command->json, "limits", '{');
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        cli_json_unsigned(&command->json, limits[i].name, limits[i].value);
        vvi_text_printf(&command->text, "%-16s %20" PRIu64 "  %s\n", limits[i].name, limits[i].value, limits[i].about);
    }
    cli_json_close(&command->json, '}');
}

static vv_status run(cli_command *command)
{
    const doctor_options *options = cli_command_options(command, &options_class);
    vv_status st;
    if (options->limits) {
        report_limits(command);
        return VV_OK;
    }
    if ((st = cli_command_start(command)) != VV_OK)
        return st;
    cli_json_string(&command->json, "version", vv_version());
    cli_json_open(&command->json, "checks", '[');
    check_machine(command);
    check_libraries(command);
    st = check_picture(command);
    cli_json_close(&command->json, ']');
    return st;
}

static const char *const examples[] = {"volvis doctor", "volvis doctor --limits", NULL};

const cli_verb cli_verb_doctor = {
    .name = "doctor",
    .doc = "checks the installation and says what is missing for what",
    .options = {&options_class},
    .examples = examples,
    .run = run,
};
