#include "server/audit.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "core/result.h"
#include "server/line_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { OBJECT_MOST = 4096 };

struct vvi_audit {
    vvi_line_file file;
    char *path;
    uint64_t lost; /* lines, since one was written */
};

/* Of our own output, whatever that is: /dev/stderr is a link, and where it is a socket it cannot be opened. Of what is
 * no file (a pipe, a device) nothing waits for a reader: lines that nobody takes are lost, and counted. */
static int open_lines(const char *path)
{
    if (strcmp(path, "/dev/stdout") == 0 || strcmp(path, "/dev/stderr") == 0)
        return fcntl(strcmp(path, "/dev/stdout") == 0 ? STDOUT_FILENO : STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    return open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY, 0600);
}

/* One that was there may be read by a group, as somebody wanted it, but not by everybody. */
static void keep_from_others(int fd)
{
    struct stat info;
    if (fd >= 0 && fstat(fd, &info) == 0 && S_ISREG(info.st_mode) && info.st_uid == geteuid() && (info.st_mode & 07))
        fchmod(fd, info.st_mode & 0770);
}

static const char *reason_of(int error)
{
    return error == ELOOP   ? "it is a symbolic link; name the file itself"
           : error == ENXIO ? "it is a pipe that nobody reads; start its reader first"
                            : strerror(error);
}

vv_status vvi_audit_open(vvi_audit **out, const char *path)
{
    vvi_audit *audit = vvi_calloc(1, sizeof *audit);
    *out = NULL;
    if (!audit)
        return vv_fail_memory(sizeof *audit);
    audit->path = vvi_strdup(path);
    if (!audit->path) {
        free(audit);
        return vv_fail_memory(strlen(path));
    }
    audit->file.fd = open_lines(path);
    keep_from_others(audit->file.fd);
    if (audit->file.fd >= 0) {
        *out = audit;
        return VV_OK;
    }
    const int error = errno;
    free(audit->path);
    free(audit);
    return vv_fail_at(VV_E_WRITE, path, NULL, "the record of what users do cannot be written: %s", reason_of(error));
}

void vvi_audit_close(vvi_audit *audit)
{
    if (!audit)
        return;
    close(audit->file.fd);
    free(audit->path);
    free(audit);
}

static void tell_time(vvi_result *line)
{
    char text[32];
    struct tm parts;
    const time_t now = time(NULL);
    gmtime_r(&now, &parts);
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    vvi_result_string(line, "time", text);
}

static void begin_line(vvi_result *line)
{
    *line = (vvi_result){.compact = true};
    vvi_result_open(line, NULL, '{');
    tell_time(line);
}

static char *end_line(vvi_result *line)
{
    vvi_result_close(line, '}');
    return vvi_text_take(&line->text);
}

/* Lines that are missing are told by the first that can be written again. */
static void put_line(vvi_audit *audit, char *text)
{
    bool fine = true;
    if (audit->lost) {
        vvi_result line;
        begin_line(&line);
        vvi_result_string(&line, "what", "lost");
        vvi_result_unsigned(&line, "lines", audit->lost);
        fine = vvi_line_file_put(&audit->file, end_line(&line));
    }
    if (fine)
        fine = vvi_line_file_put(&audit->file, text);
    else
        free(text);
    audit->lost = fine ? 0 : audit->lost + 1;
}

char *vvi_audit_problem(const vvi_audit *audit)
{
    return audit && audit->lost ? vvi_asprintf("what people do cannot be written down to %s: %s", audit->path,
                                               strerror(audit->file.error))
                                : NULL;
}

void vvi_audit_note(vvi_audit *audit, vvi_actor who, const char *what, const char *object, bool refused)
{
    vvi_result line;
    if (!audit)
        return;
    begin_line(&line);
    vvi_result_string(&line, "address", who.address);
    if (who.client)
        vvi_result_unsigned(&line, "client", who.client);
    vvi_result_string(&line, "what", what);
    if (object)
        vvi_result_string(&line, "object", object);
    if (refused)
        vvi_result_bool(&line, "refused", true);
    put_line(audit, end_line(&line));
}

/* A text of an object that a message has; others, cut off, as JSON. */
static void note_value(vvi_audit *audit, vvi_actor who, const char *what, const json_t *value, bool refused)
{
    char *text = json_is_string(value) ? vvi_strdup(json_string_value(value)) : vvi_json_encode(value, JSON_ENCODE_ANY);
    if (text && strlen(text) > OBJECT_MOST)
        text[OBJECT_MOST] = 0;
    vvi_audit_note(audit, who, what, text, refused);
    free(text);
}

/* Datasets and meshes of a World are files. */
static void note_edits(vvi_audit *audit, vvi_actor who, const json_t *edits, bool refused)
{
    size_t i;
    json_t *edit;
    json_array_foreach(edits, i, edit)
    {
        const char *path = json_string_value(json_object_get(edit, "path"));
        if (path && (strncmp(path, "datasets", 8) == 0 || strncmp(path, "meshes", 6) == 0))
            note_value(audit, who, "edit", json_object_get(edit, "value"), refused);
    }
}

void vvi_audit_message(vvi_audit *audit, vvi_actor who, const json_t *message, bool refused)
{
    static const char *const rows[][2] = {{"open", "path"},   {"save", "path"},     {"browse", "path"},
                                          {"sample", "name"}, {"run", "operation"}, {"picture", "name"}};
    const char *type = json_string_value(json_object_get(message, "type"));
    if (!audit || !type)
        return;
    if (strcmp(type, "edit") == 0)
        note_edits(audit, who, json_object_get(message, "edits"), refused);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (strcmp(type, rows[i][0]) == 0)
            note_value(audit, who, type, json_object_get(message, rows[i][1]), refused);
}
