/* What an import program that a file has taken over might say. The name of the file that it should open says which
 * lie; up to that it says what is right: 4 x 3 x 2 u8. */
#include "import_liar.h"
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

static void say(uint32_t magic, uint32_t kind, uint64_t n, const vvi_text *body)
{
    const vvi_wire_head head = {magic, kind, n};
    if (send(VVI_IMPORT_SOCKET, &head, sizeof head, MSG_NOSIGNAL) < 0 ||
        (body && body->n > 0 && send(VVI_IMPORT_SOCKET, body->s, body->n, MSG_NOSIGNAL) < 0))
        _exit(0);
}

static void tell(vvi_wire_kind kind, vvi_text *body)
{
    say(VVI_WIRE_MAGIC, kind, body->n, body);
    vvi_text_free(body);
}

static vv_field_info right_info(void)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 4;
    info.grid.dims[1] = 3;
    info.grid.dims[2] = 2;
    return info;
}

static void opened(const char *format, const vv_field_info *info)
{
    vvi_text body = {0};
    vvi_wire_put_text(&body, format);
    vvi_wire_put(&body, info, sizeof *info);
    vvi_wire_put_number(&body, 1);
    tell(VVI_WIRE_OPENED, &body);
}

static int64_t offset = -1; /* of the samples in the file, as it says */

static void done(const vv_field_info *info, int64_t damaged)
{
    vvi_text body = {0};
    vvi_wire_put(&body, info, sizeof *info);
    vvi_wire_put_number(&body, damaged);
    vvi_wire_put_number(&body, offset);
    tell(VVI_WIRE_DONE, &body);
}

static void note(vvi_wire_kind kind, const char *first, const char *second)
{
    vvi_text body = {0};
    vvi_wire_put_text(&body, first);
    if (second)
        vvi_wire_put_text(&body, second);
    tell(kind, &body);
}

static void failed(int64_t status, const char *message)
{
    vvi_text body = {0};
    vvi_wire_put_number(&body, status);
    vvi_wire_put_text(&body, message);
    vvi_wire_put_text(&body, NULL);
    vvi_wire_put_text(&body, NULL);
    tell(VVI_WIRE_FAILED, &body);
}

static void wait_for_ever(void)
{
    for (;;)
        pause();
}

/* Lies before the file is open. */
static void lie_at_open(const char *lie)
{
    vv_field_info info = right_info();
    vvi_text body = {0};
    if (strcmp(lie, "magic") == 0)
        say(0x12345678, VVI_WIRE_OPENED, 0, NULL);
    if (strcmp(lie, "kind") == 0)
        say(VVI_WIRE_MAGIC, 99, 0, NULL);
    if (strcmp(lie, "length") == 0)
        say(VVI_WIRE_MAGIC, VVI_WIRE_METADATA, UINT64_MAX, NULL);
    if (strcmp(lie, "half") == 0) {
        say(VVI_WIRE_MAGIC, VVI_WIRE_METADATA, 1000, NULL);
        wait_for_ever();
    }
    if (strcmp(lie, "cut") == 0) {
        say(VVI_WIRE_MAGIC, VVI_WIRE_METADATA, 1000, NULL);
        _exit(0);
    }
    if (strcmp(lie, "empty") == 0)
        say(VVI_WIRE_MAGIC, VVI_WIRE_OPENED, 0, NULL);
    if (strcmp(lie, "format") == 0)
        opened("no-such-format", &info);
    if (strcmp(lie, "done") == 0)
        done(&info, 0);
    if (strcmp(lie, "dims") == 0)
        info.grid.dims[1] = 0;
    if (strcmp(lie, "huge") == 0)
        info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = INT64_MAX / 4;
    if (strcmp(lie, "many") == 0)
        info.grid.dims[0] = INT64_C(1) << 40;
    if (strcmp(lie, "type") == 0)
        info.type = (vv_type)77;
    if (strcmp(lie, "components") == 0)
        info.components = -1;
    if (strcmp(lie, "nan") == 0)
        info.grid.index_to_world.origin.x = NAN;
    if (strcmp(lie, "unit") == 0)
        memset(info.grid.unit, 'x', sizeof info.grid.unit);
    if (strcmp(lie, "name") == 0)
        memset(info.name, 'x', sizeof info.name);
    if (strcmp(lie, "status") == 0)
        failed(0, "no failure");
    if (strcmp(lie, "endless") == 0) {
        for (;;)
            note(VVI_WIRE_WARNING, "again", NULL);
    }
    if (strcmp(lie, "text") == 0) { /* does not end */
        vvi_wire_put_number(&body, 5);
        vvi_wire_put(&body, "abcde", 5);
        tell(VVI_WIRE_WARNING, &body);
    }
    if (strcmp(lie, "longtext") == 0) { /* longer than the message */
        vvi_wire_put_number(&body, INT64_MAX);
        vvi_wire_put(&body, "abcd", 5);
        tell(VVI_WIRE_WARNING, &body);
    }
    if (strcmp(lie, "rest") == 0) { /* more than it should hold */
        vvi_wire_put_text(&body, "a");
        vvi_wire_put_text(&body, "b");
        vvi_wire_put_text(&body, "c");
        tell(VVI_WIRE_METADATA, &body);
    }
    if (strcmp(lie, "bool") == 0) {
        vv_label label = {.value = 1};
        vvi_wire_put_label(&body, &label);
        body.s[8 + sizeof label.name] = 2;
        tell(VVI_WIRE_LABEL, &body);
    }
    if (strcmp(lie, "label") == 0) {
        vv_label label = {.value = 1};
        memset(label.name, 'x', sizeof label.name);
        vvi_wire_put_label(&body, &label);
        tell(VVI_WIRE_LABEL, &body);
    }
    if (strcmp(lie, "control") == 0) /* escape codes for the terminal */
        failed(VV_E_FORMAT, "a\033[2Jb\nc");
    opened("raw", &info);
}

/* Lies instead of the samples. */
static void lie_at_read(const char *lie)
{
    vv_field_info info = right_info();
    const size_t n = 24;
    char *memory = mmap(NULL, n, PROT_READ | PROT_WRITE, MAP_SHARED, shared, 0);
    memset(memory, 7, n);
    if (strcmp(lie, "shrink") == 0 && ftruncate(shared, 0) == 0)
        _exit(9); /* the seal should have refused it */
    if (strcmp(lie, "grow") == 0 && ftruncate(shared, 1 << 20) == 0)
        _exit(9);
    if (strcmp(lie, "held") != 0)
        munmap(memory, n);
    offset = strcmp(lie, "mapped") == 0 ? 0 : strcmp(lie, "beyond") == 0 ? 1000 : strcmp(lie, "before") == 0 ? -2 : -1;
    if (strcmp(lie, "otherdims") == 0)
        info.grid.dims[0] = 5;
    if (strcmp(lie, "othertype") == 0)
        info.type = VV_TYPE_F64;
    if (strcmp(lie, "scale") == 0)
        info.value_scale = NAN;
    if (strcmp(lie, "notes") == 0)
        note(VVI_WIRE_METADATA, "late", "note");
    if (strcmp(lie, "again") == 0)
        opened("raw", &info);
    if (strcmp(lie, "silent") == 0)
        wait_for_ever();
    done(&info, strcmp(lie, "damaged") == 0 ? 2 : 0);
    if (strcmp(lie, "after") == 0) { /* tries to change what was handed over */
        for (int i = 0; i < 100000; i++) {
            if (pwrite(shared, "xxxxxxxx", 8, 0) > 0)
                continue;
        }
    }
}

int main(void)
{
    size_t n;
    vvi_wire_in in = {.bytes = take_message(&n)};
    in.n = n;
    vvi_wire_take_number(&in);
    vvi_wire_take_text(&in);
    const char *path = vvi_wire_take_text(&in), *slash = strrchr(path, '/');
    const char *lie = slash ? slash + 1 : path;
    lie_at_open(lie);
    for (;;) {
        free(take_message(&n));
        lie_at_read(lie);
        close(shared);
    }
}
