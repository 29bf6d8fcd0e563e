#include "edits.h"
#include "serving.h"
#include "verbs.h"

typedef struct view_options {
    vv_object base;
    bool no_browser;
} view_options;

static const vv_property rows[] = {
    {VV_PROP(view_options, no_browser), .kind = VV_KIND_BOOL, .doc = "print the link, and open no browser"},
    {0},
};

static const vv_class options_class = {
    .name = "view",
    .doc = "options of view",
    .size = sizeof(view_options),
    .properties = rows,
};

static vv_status run(cli_command *command)
{
    const view_options *o = cli_command_options(command, &options_class);
    const cli_serving serving = {.root = "/", .clients = 200, .opens_browser = !o->no_browser, .upload_most = 64e9};
    return cli_serve(command, &serving);
}

static const char *const examples[] = {"volvis view head.nrrd --no-browser --dry-run",
                                       "volvis view --bindings bindings.json --print-bindings", NULL};

const cli_verb cli_verb_view = {
    .name = "view",
    .doc = "view volumes, meshes and scenes in the browser, and work on them",
    .about = "Opens a page that only this machine can reach, and only with its link. INPUT and the options for the "
             "look of the picture are those of render; without INPUT the page offers files. Through ssh: ssh -L "
             "8080:localhost:8080 machine volvis view --port 8080 --no-browser FILE, and open the link here; on a "
             "machine shared with others, ssh -L 8080:SOCKET and --socket SOCKET keep them out. Ctrl-C ends it. "
             "Changes are saved as they are made: after a crash the same command continues where it was.",
    .words = "INPUT ...",
    .choices = "files",
    .max_words = 16,
    .options = {&options_class, &cli_session_class, &cli_look_class, &cli_reading_class},
    .examples = examples,
    .world = true,
    .run = run,
};
