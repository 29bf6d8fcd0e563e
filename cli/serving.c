#include "serving.h"
#include "core/memory.h"
#include "edits.h"
#include "input.h"
#include "input/bindings.h"
#include "server/gate.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { TRIES = 16, PAGE_NAME = 26, PAGE_SECONDS = 3600 };
extern char **environ;

static const vv_property rows[] = {
    {VV_PROP(cli_session_options, port), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = 65535,
     .automatic = "one that is free",
     .doc = "port of the page; with --socket the port at the near end of the tunnel, or 8080"},
    {VV_PROP(cli_session_options, socket), .kind = VV_KIND_PATH, .automatic = "a port",
     .doc = "Unix socket to listen on, which only you can reach; for ssh -L 8080:SOCKET"},
    {VV_PROP(cli_session_options, fresh), .kind = VV_KIND_BOOL,
     .doc = "start over instead of continuing an interrupted session on the same inputs"},
    {VV_PROP(cli_session_options, record), .kind = VV_KIND_PATH, .automatic = "not recorded",
     .doc = "record what the pages do, for 'volvis replay'"},
    {VV_PROP(cli_session_options, audit), .kind = VV_KIND_PATH, .automatic = "not written down",
     .doc = "file to which users and the files they open are logged, one line of JSON each"},
    {VV_PROP(cli_session_options, bindings), .kind = VV_KIND_PATH, .automatic = "those of VolVis",
     .doc = "JSON file that says what buttons and keys do, in addition to the defaults"},
    {VV_PROP(cli_session_options, print_bindings), .kind = VV_KIND_BOOL,
     .doc = "print what buttons and keys do, in the form of such a file, and exit"},
    {0},
};

const vv_class cli_session_class = {
    .name = "session",
    .doc = "options of verbs that serve a page",
    .size = sizeof(cli_session_options),
    .properties = rows,
};

static uint64_t hash(uint64_t h, const char *text)
{
    for (; *text; text++)
        h = (h ^ (unsigned char)*text) * UINT64_C(1099511628211);
    return (h ^ 0xff) * UINT64_C(1099511628211);
}

/* Where nobody has a home: a folder that is this user's alone, and not one that somebody has put in its place. */
static vv_status private_folder(char **out)
{
    struct stat info;
    char *path = vvi_asprintf("/tmp/volvis-%lu", (unsigned long)getuid());
    if (!path)
        return vv_fail_memory(64);
    if ((mkdir(path, 0700) == 0 || errno == EEXIST) && lstat(path, &info) == 0 && S_ISDIR(info.st_mode) &&
        info.st_uid == getuid() && !(info.st_mode & 077)) {
        *out = path;
        return VV_OK;
    }
    const vv_status st = vv_fail_at(VV_E_WRITE, path, NULL,
                                    "is not a folder of yours alone, and there is no HOME for what a "
                                    "session keeps: set HOME or XDG_STATE_HOME");
    free(path);
    return st;
}

vv_status cli_state_root(char **out)
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    *out = NULL;
    if (state && *state == '/')
        *out = vvi_asprintf("%s/volvis", state);
    else if (home && *home == '/')
        *out = vvi_asprintf("%s/.local/state/volvis", home);
    else
        return private_folder(out);
    return *out ? VV_OK : vv_fail_memory(256);
}

/* What a session on these inputs keeps for the case of a crash; number: of several at once. Yours to free(). */
static char *state_folder(const cli_command *command, const char *root, int number)
{
    uint64_t h = UINT64_C(14695981039346656037);
    char suffix[16] = "";
    for (size_t i = 0; i < command->args.n_words; i++) {
        char *real = realpath(command->args.words[i], NULL);
        h = hash(h, real ? real : command->args.words[i]);
        free(real);
    }
    if (number > 1)
        snprintf(suffix, sizeof suffix, "-%d", number);
    return vvi_asprintf("%s/%016" PRIx64 "%s", root, h, suffix);
}

/* A session of the same inputs that runs already has its folder: the next one is tried. */
static vv_status open_server(vvi_server **out, vvi_server_options *options, const cli_command *command,
                             const char *root)
{
    vv_status st = VV_OK;
    for (int number = 1; number <= TRIES; number++) {
        char *state = state_folder(command, root, number);
        if (!state)
            return vv_fail_memory(256);
        options->session.state = state;
        st = vvi_server_new(out, options);
        const bool taken = st != VV_OK && strstr(vv_error_last()->message, "another server uses") != NULL;
        free(state);
        if (!taken)
            return st;
    }
    return st;
}

static vv_status world_of_words(vv_world **out, cli_command *command)
{
    vvi_recipe recipe;
    vv_object *empty = NULL;
    if (command->args.n_words)
        return cli_edited_world(out, &recipe, command);
    const vv_status st = vv_object_new(&empty, &vv_world_class, NULL);
    *out = (vv_world *)(void *)empty;
    return st;
}

static void start_browser(const char *path)
{
    char program[] = "xdg-open";
    char *words[] = {program, (char *)path, NULL};
    pid_t child;
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", 1, 0);
    if (posix_spawnp(&child, program, &quiet, NULL, words, environ) == 0)
        waitpid(child, NULL, WNOHANG);
    posix_spawn_file_actions_destroy(&quiet);
}

/* A page that leads to another one. */
static bool write_page(const char *path, const char *link)
{
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    FILE *file = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (!file)
        return false;
    fprintf(file,
            "<!doctype html><meta charset=utf-8><title>VolVis</title><meta name=referrer content=no-referrer>"
            "<meta http-equiv=refresh content=\"0;url=%s\">\n",
            link);
    return fclose(file) == 0;
}

/* Of servers that were killed before anybody used the link. */
static void clear_pages(const char *root)
{
    DIR *dir = opendir(root);
    for (const struct dirent *e; dir && (e = readdir(dir)) != NULL;) {
        struct stat info;
        const size_t n = strlen(e->d_name);
        if (n == PAGE_NAME && strncmp(e->d_name, "open-", 5) == 0 && strcmp(e->d_name + n - 5, ".html") == 0 &&
            fstatat(dirfd(dir), e->d_name, &info, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(info.st_mode) &&
            info.st_mtime + PAGE_SECONDS < time(NULL))
            unlinkat(dirfd(dir), e->d_name, 0);
    }
    if (dir)
        closedir(dir);
}

/* Everybody on this machine sees what programs are started with: so the browser is given a file that this user alone
 * can read, with a link that lets in once. */
static void open_browser(vvi_server *server, const char *root)
{
    char name[VVI_TOKEN_TEXT], link[512];
    if ((!getenv("DISPLAY") && !getenv("WAYLAND_DISPLAY")) || vvi_token_make(name) != VV_OK)
        return;
    clear_pages(root);
    char *path = vvi_asprintf("%s/open-%.16s.html", root, name);
    if (path && vvi_server_launch(link, server, path) == VV_OK && write_page(path, link))
        start_browser(path);
    free(path);
}

/* At once: whoever started the program waits for this line. */
static void print_link(void *user, const char *link)
{
    cli_command *command = user;
    command->verbatim = command->common->json; /* this is all that it says */
    if (command->common->json)
        printf("{\"link\": \"%s\"}\n", link);
    else
        printf("VolVis is at %s\n", link);
    fflush(stdout);
}

static vv_status begin(vvi_server *server, cli_command *command)
{
    vvi_session *session = vvi_server_session(server);
    vv_world *world = NULL;
    if (vvi_session_kept(session))
        cli_command_note(command, "%s", vvi_session_kept(session));
    if (vvi_session_restored(session) > 0) {
        cli_command_note(command, "the interrupted session continues (%" PRIu64 " changes); --fresh starts over",
                         vvi_session_restored(session));
        if (vvi_session_lost(session) > 0)
            cli_command_note(command, "%" PRIu64 " later change%s lost", vvi_session_lost(session),
                             vvi_session_lost(session) == 1 ? " is" : "s are");
        return VV_OK;
    }
    vv_status st = world_of_words(&world, command);
    if (st == VV_OK)
        st = vvi_session_begin(session, world);
    if (st == VV_OK && command->args.n_words == 1)
        vvi_session_shows(session, command->args.words[0]);
    if (world)
        vv_object_release(&world->base);
    return st;
}

static vv_status describe(cli_command *command, const cli_serving *serving, const cli_session_options *o)
{
    vv_world *world = NULL;
    const vv_status st = world_of_words(&world, command);
    if (st == VV_OK)
        cli_command_line(command, "serves", "a World of %zu volume%s on %s, port %d%s; files of %s%s",
                         world->volumes->n, world->volumes->n == 1 ? "" : "s",
                         o->socket         ? o->socket
                         : serving->listen ? serving->listen
                                           : "this machine alone",
                         (int)o->port,
                         o->port     ? ""
                         : o->socket ? " (8080)"
                                     : " (one that is free)",
                         serving->root, serving->read_only ? "; nobody changes it" : "");
    if (world)
        vv_object_release(&world->base);
    return st;
}

static vv_status run_server(vvi_server *server, cli_command *command, bool opens_browser, const char *root)
{
    const vv_status st = begin(server, command);
    if (st != VV_OK)
        return st;
    print_link(command, vvi_server_link(server));
    if (opens_browser)
        open_browser(server, root);
    return vvi_server_run(server, command->job);
}

static vv_status serve(cli_command *command, const cli_serving *serving, const cli_session_options *o,
                       const char *bindings)
{
    vvi_server *server = NULL;
    vv_status st;
    if (o->print_bindings) {
        vvi_text_add(&command->text, bindings);
        command->verbatim = true;
        return VV_OK;
    }
    vvi_server_options options = {
        .session = {.runtime = command->runtime,
                    .root = serving->root,
                    .read_only = serving->read_only,
                    .fresh = o->fresh,
                    .record = o->record,
                    .bindings = bindings,
                    .audit = o->audit,
                    .clients_most = serving->clients},
        .listen = serving->listen,
        .port = (int)o->port,
        .socket = o->socket,
        .token = serving->token,
        .host = serving->host,
        .certificate = serving->certificate,
        .key = serving->key,
        .upload_most = (uint64_t)serving->upload_most,
        .renewed = print_link,
        .user = command,
    };
    char *root = NULL;
    if ((st = vvi_server_options_check(&options)) != VV_OK)
        return st;
    if (serving->note)
        cli_command_note(command, "%s", serving->note);
    if (command->common->dry_run)
        return describe(command, serving, o);
    if ((st = cli_state_root(&root)) != VV_OK)
        return st;
    if ((st = open_server(&server, &options, command, root)) == VV_OK)
        st = run_server(server, command, serving->opens_browser, root);
    free(root);
    command->served = st == VV_OK;
    if (st == VV_OK)
        return vvi_server_free(server, false);
    vvi_error_copy why;
    vvi_error_take(&why);
    vvi_server_free(server, false);
    return vvi_error_put(&why);
}

vv_status cli_serve(cli_command *command, const cli_serving *serving)
{
    const cli_session_options *o = cli_command_options(command, &cli_session_class);
    char *bindings = NULL;
    if (o->socket && serving->listen)
        return vv_fail(VV_E_ARGUMENT, "--socket and --listen: give one of them");
    vv_status st = cli_command_start(command);
    if (st == VV_OK && o->bindings)
        st = vvi_bindings_read(&bindings, o->bindings, command->job);
    else if (st == VV_OK && !(bindings = vvi_bindings_default()))
        st = vv_fail_memory(256);
    if (st == VV_OK)
        st = serve(command, serving, o, bindings);
    free(bindings);
    return st;
}
