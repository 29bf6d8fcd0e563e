/* What an import program that an image has taken over might say. The name of the file that it should read says which
 * lie; up to that it says what is right: 3 x 2 pixels with their depth. */
#include "import/import_image.h"
#include "import_liar.h"
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

static bool is(const char *lie, const char *what)
{
    return strcmp(lie, what) == 0;
}

static void open_image(const char *lie)
{
    vvi_text body = {0};
    vvi_wire_put_number(&body, is(lie, "width") ? 0 : is(lie, "wide") ? 65537 : is(lie, "huge") ? 65536 : 3);
    vvi_wire_put_number(&body, is(lie, "height") ? -1 : is(lie, "tall") ? INT64_MAX : is(lie, "huge") ? 65536 : 2);
    vvi_wire_put_number(&body, is(lie, "layers") ? 1 << VV_LAYER_COUNT : VV_LAYER_DEPTH);
    if (is(lie, "rest"))
        vvi_wire_put_number(&body, 1);
    vvi_wire_send(VVI_IMPORT_SOCKET, is(lie, "kind") ? VVI_WIRE_OPENED_MESH : VVI_WIRE_OPENED_IMAGE, &body, -1);
}

static void fill(const char *lie)
{
    const vvi_image_room r = vvi_image_room_of(3, 2, VV_LAYER_DEPTH);
    float *at = mmap(NULL, r.end, PROT_READ | PROT_WRITE, MAP_SHARED, shared, 0);
    for (size_t i = 0; i < r.end / sizeof *at; i++)
        at[i] = (float)i;
    if (!is(lie, "held"))
        munmap(at, r.end);
}

int main(void)
{
    size_t n;
    vvi_text nothing = {0};
    vvi_wire_in in = {.bytes = take_message(&n)};
    in.n = n;
    vvi_wire_take_number(&in);
    vvi_wire_take_text(&in);
    const char *path = vvi_wire_take_text(&in), *slash = strrchr(path, '/');
    const char *lie = slash ? slash + 1 : path;
    open_image(lie);
    free(take_message(&n));
    fill(lie);
    if (is(lie, "done"))
        vvi_wire_put_number(&nothing, 3);
    vvi_wire_send(VVI_IMPORT_SOCKET, VVI_WIRE_DONE, &nothing, -1);
    take_message(&n);
}
