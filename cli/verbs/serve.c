#include "core/memory.h"
#include "edits.h"
#include "server/secret_file.h"
#include "serving.h"
#include "verbs.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

typedef struct serve_options {
    vv_object base;
    char *listen, *host_name, *token, *token_file, *tls_cert, *tls_key, *root;
    int64_t clients;
    bool read_only;
    double upload;
} serve_options;

static const vv_property rows[] = {
    {VV_PROP(serve_options, listen), .kind = VV_KIND_STRING, .unit = "ADDRESS", .automatic = "127.0.0.1",
     .doc = "address to listen on; 0.0.0.0 means all addresses of this machine"},
    {VV_PROP(serve_options, host_name), .kind = VV_KIND_STRING, .unit = "NAME", .automatic = "none",
     .doc = "a host name under which browsers reach this server"},
    {VV_PROP(serve_options, token), .kind = VV_KIND_STRING, .unit = "TEXT", .automatic = "a random one",
     .doc = "token that a browser must present, of 128 bits or more (32 hex digits); other users of this machine may "
            "see it while the "
            "program starts"},
    {VV_PROP(serve_options, token_file), .kind = VV_KIND_PATH, .automatic = "none",
     .doc = "file with the token in its first line; only its owner may be able to read it"},
    {VV_PROP(serve_options, tls_cert), .kind = VV_KIND_PATH, .automatic = "none",
     .doc = "certificate (PEM): the page is served over https"},
    {VV_PROP(serve_options, tls_key), .kind = VV_KIND_PATH, .automatic = "in the certificate's file",
     .doc = "its key (PEM); only its owner may be able to read the file"},
    {VV_PROP(serve_options, root), .kind = VV_KIND_PATH, .automatic = "the folder that the program was started in",
     .doc = "folder outside which no files are opened or written, but for the INPUTs, wherever they are"},
    {VV_PROP(serve_options, read_only), .kind = VV_KIND_BOOL,
     .doc = "users can look, and change nothing but their camera"},
    {VV_PROP(serve_options, clients), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 2000, .def = 200,
     .doc = "number of users at the same time, at most"},
    {VV_PROP(serve_options, upload), .kind = VV_KIND_F64, .quantity = VV_Q_BYTES, .limited = true, .min = 0,
     .max = 1e15, .def = 4294967296.0, .doc = "largest file accepted from a page, as in 4G; 0: none"},
    {0},
};

static const vv_class options_class = {
    .name = "serve",
    .doc = "options of serve",
    .size = sizeof(serve_options),
    .properties = rows,
};

/* The first line of a file that its owner alone can read. */
static vv_status read_token(char out[256], const char *path)
{
    struct stat info = {0};
    FILE *file = fopen(path, "re");
    const bool fine = file && fstat(fileno(file), &info) == 0 && fgets(out, 256, file);
    if (file)
        fclose(file);
    if (!fine)
        return vv_fail_at(VV_E_READ, path, NULL, "cannot be read, or is empty: it should hold the token");
    const vv_status st = vvi_secret_file_check(&info, path, "token");
    out[strcspn(out, "\r\n")] = 0;
    return st;
}

static vv_status run(cli_command *command)
{
    const serve_options *o = cli_command_options(command, &options_class);
    char token[256];
    cli_serving serving = {.listen = o->listen,
                           .token = o->token,
                           .certificate = o->tls_cert,
                           .key = o->tls_key,
                           .host = o->host_name,
                           .root = o->root ? o->root : ".",
                           .read_only = o->read_only,
                           .clients = (int)o->clients,
                           .upload_most = o->upload};
    cli_args_hide(&command->args, "token");
    if (o->token && o->token_file)
        return vv_fail(VV_E_ARGUMENT, "--token and --token-file: give one of them");
    if (o->token_file) {
        const vv_status st = read_token(token, o->token_file);
        if (st != VV_OK)
            return st;
        serving.token = token;
    }
    if (o->listen && strncmp(o->listen, "127.", 4) != 0 && strcmp(o->listen, "::1") != 0 && !o->tls_cert)
        serving.note = "other machines can reach this server, and the connection can be read by others: "
                       "give --tls-cert, or put an https proxy in front of it";
    return cli_serve(command, &serving);
}

static const char *const examples[] = {"volvis serve head.nrrd --root . --read-only --dry-run", NULL};

const cli_verb cli_verb_serve = {
    .name = "serve",
    .doc = "the same page for users on other machines",
    .about =
        "Like view, but for a machine that others can reach: it opens no browser, and reads and writes nothing "
        "outside --root but the INPUTs that it is given. Whoever has the link can do what the page can; with "
        "--read-only they can only look. "
        "Volumes and meshes are read as with --safe; --no-safe reads them in the program, where large ones need no "
        "memory of their own.",
    .words = "INPUT ...",
    .choices = "files",
    .max_words = 16,
    .options = {&options_class, &cli_session_class, &cli_look_class, &cli_reading_class},
    .examples = examples,
    .safe = true,
    .world = true,
    .run = run,
};
