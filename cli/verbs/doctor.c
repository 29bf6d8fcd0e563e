#include "command.h"
#include "config.h"
#include "core/limits.h"
#include "core/units.h"
#include "limit_words.h"
#include "verbs.h"
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <volvis/file.h>
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

static void say_mark(cli_command *command, const char *name, bool ok, const char *mark, const char *text)
{
    vvi_result_open(&command->json, NULL, '{');
    vvi_result_string(&command->json, "check", name);
    vvi_result_bool(&command->json, "ok", ok);
    vvi_result_string(&command->json, "found", text);
    vvi_result_close(&command->json, '}');
    cli_command_line(command, name, "%s%s", ok ? "" : mark, text);
}

static void say(cli_command *command, const char *name, bool ok, const char *text)
{
    say_mark(command, name, ok, "MISSING: ", text);
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

static void check_defaults(cli_command *command)
{
    bool named;
    char text[4600], *path = cli_defaults_path(&named);
    cli_defaults defaults;
    const vv_status st = cli_defaults_take(&defaults, NULL, NULL, command->registry);
    if (st != VV_OK)
        snprintf(text, sizeof text, "%s", vv_error_last()->message);
    else if (defaults.path)
        snprintf(text, sizeof text, "from %.4096s", defaults.path);
    else if (path)
        snprintf(text, sizeof text, "none; %.4096s would hold them", path);
    else
        snprintf(text, sizeof text, "none are read");
    say_mark(command, "defaults", st == VV_OK, "WRONG: ", text);
    cli_defaults_free(&defaults);
    free(path);
}

static void check_libraries(cli_command *command)
{
    vv_library library;
    char text[2600];
    for (size_t i = 0; vv_library_nth(&library, i, true); i++) {
        const char *problem = *library.version ? library.problem : NULL;
        if (problem)
            snprintf(text, sizeof text, "no %s: %s; install VolVis again", library.purpose, problem);
        else if (*library.version)
            snprintf(text, sizeof text, "%s: %s", library.version, library.purpose);
        else
            snprintf(text, sizeof text, "built without it, so no %s", library.purpose);
        say(command, library.name, *library.version && !problem, text);
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

/* A volume of eight samples in a temporary file; where it lies is its path. */
static vv_status write_tiny_file(char *path, size_t room)
{
    static const char nrrd[] = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n\1\2\3\4\5\6\7\10";
    const char *folder = getenv("TMPDIR");
    const int n = snprintf(path, room, "%s/volvis-doctor-XXXXXX.nrrd", folder && *folder ? folder : "/tmp");
    const int fd = n > 0 && (size_t)n < room ? mkstemps(path, 5) : -1;
    if (fd < 0)
        return vv_fail(VV_E_WRITE, "no temporary file can be made: %s; set TMPDIR", strerror(errno));
    const ssize_t wanted = (ssize_t)sizeof nrrd - 1;
    const bool written = write(fd, nrrd, (size_t)wanted) == wanted;
    close(fd);
    if (written)
        return VV_OK;
    unlink(path);
    return vv_fail(VV_E_WRITE, "a temporary file cannot be written: %s; set TMPDIR", strerror(errno));
}

static vv_status read_first_frame(const char *path, vv_job *job)
{
    vv_file *file;
    vv_field *field = NULL;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    st = vv_file_read(&field, file, 0, NULL, job);
    vv_field_release(field);
    vv_file_close(file);
    return st;
}

/* As --safe reads a file, whether or not it was given here. */
static vv_status read_safely(const char *path)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.safe = true;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st != VV_OK)
        return st;
    if ((st = vv_job_new(&job, runtime, NULL, NULL)) == VV_OK)
        st = read_first_frame(path, job);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st;
}

/* A build or a system without seccomp is no failure: limits on memory and time are there nevertheless. */
static void check_lock(cli_command *command)
{
    const bool kernel = prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0;
    const char *text = !VV_HAVE_SECCOMP
                           ? "built without libseccomp, so under --safe only memory, time and files are limited"
                       : !kernel ? "not in this kernel, so under --safe only memory, time and files are limited"
                                 : "under --safe no program, no network and no writing";
    say(command, "seccomp", VV_HAVE_SECCOMP && kernel, text);
}

/* The version of the kernel's Landlock, which locks the import program out of other files. */
static void check_landlock(cli_command *command)
{
    char text[160];
    const long version = syscall(444 /* landlock_create_ruleset */, NULL, 0, 1 /* its version */);
    if (version > 0)
        snprintf(text, sizeof text,
                 "version %ld: the import program opens what it was handed, and what a header may name beside it",
                 version);
    else
        snprintf(text, sizeof text,
                 "not in this kernel (5.13 has it), or turned off: the import program may read any file of yours");
    say(command, "landlock", version > 0, text);
}

static void check_import(cli_command *command)
{
    char text[512], path[4096];
    vv_status st = write_tiny_file(path, sizeof path);
    if (st == VV_OK) {
        st = read_safely(path);
        unlink(path);
    }
    if (st == VV_OK)
        snprintf(text, sizeof text, "volvis-import reads a test file: HDF5, and all with --safe");
    else
        snprintf(text, sizeof text, "so no --safe, and HDF5 is read without it: %s", vv_error_last()->message);
    say(command, "import", st == VV_OK, text);
    if (st != VV_OK && st != VV_E_UNSUPPORTED) /* it is there and does not work */
        command->exit_code = CLI_EXIT_FAILED;
    check_lock(command);
    check_landlock(command);
}

static void print_limit(char out[32], size_t index, uint64_t value)
{
    if (vvi_limits_of_bytes(index))
        vvi_print_bytes(out, value);
    else
        snprintf(out, 32, "%" PRIu64, value);
}

/* Name, value, whether it is another than the default, meaning. */
static vv_status report_limits(cli_command *command)
{
    vv_limits limits, defaults;
    const char *name, *doc;
    char text[32];
    uint64_t value, normal;
    vv_status st = cli_limits_read(&limits, command->common);
    if (st != VV_OK)
        return st;
    vv_limits_init(&defaults, sizeof defaults);
    vvi_result_open(&command->json, "limits", '{');
    for (size_t i = 0; vv_limits_get(&limits, i, &name, &doc, &value); i++) {
        vv_limits_get(&defaults, i, &name, &doc, &normal);
        vvi_result_unsigned(&command->json, name, value);
        print_limit(text, i, value);
        vvi_text_printf(&command->text, "%-16s %20s  %s", name, text, doc);
        print_limit(text, i, normal);
        if (value != normal)
            vvi_text_printf(&command->text, " (changed; the default is %s)", text);
        vvi_text_add(&command->text, "\n");
    }
    vvi_result_close(&command->json, '}');
    return VV_OK;
}

static vv_status run(cli_command *command)
{
    const doctor_options *options = cli_command_options(command, &options_class);
    vv_status st;
    if (options->limits)
        return report_limits(command);
    if ((st = cli_command_start(command)) != VV_OK)
        return st;
    vvi_result_string(&command->json, "version", vv_version());
    vvi_result_open(&command->json, "checks", '[');
    check_machine(command);
    check_defaults(command);
    check_libraries(command);
    check_import(command);
    st = check_picture(command);
    vvi_result_close(&command->json, ']');
    return st;
}

static const char *const examples[] = {"volvis doctor", "volvis doctor --limits", NULL};

const cli_verb cli_verb_doctor = {
    .name = "doctor",
    .doc = "checks the installation and says what is missing for what",
    .options = {&options_class},
    .examples = examples,
    .plain = true,
    .run = run,
};
