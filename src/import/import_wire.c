#include "import/import_wire.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "image/image_layer.h"
#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

void vvi_wire_put(vvi_text *out, const void *data, size_t n)
{
    vvi_text_add_n(out, data, n);
}

void vvi_wire_put_number(vvi_text *out, int64_t number)
{
    vvi_wire_put(out, &number, sizeof number);
}

void vvi_wire_put_text(vvi_text *out, const char *text)
{
    vvi_wire_put_number(out, text ? (int64_t)strlen(text) + 1 : 0);
    if (text)
        vvi_wire_put(out, text, strlen(text) + 1);
}

static void put_color(vvi_text *out, bool there, const vv_color *color)
{
    vvi_wire_put_number(out, there);
    vvi_wire_put(out, color, sizeof *color);
}

void vvi_wire_put_channel(vvi_text *out, const vv_channel *channel)
{
    vvi_wire_put(out, channel->name, sizeof channel->name);
    put_color(out, channel->has_color, &channel->color);
    vvi_wire_put(out, &channel->lo, sizeof channel->lo);
    vvi_wire_put(out, &channel->hi, sizeof channel->hi);
}

void vvi_wire_put_label(vvi_text *out, const vv_label *label)
{
    vvi_wire_put_number(out, label->value);
    vvi_wire_put(out, label->name, sizeof label->name);
    put_color(out, label->has_color, &label->color);
    vvi_wire_put_number(out, label->layer);
    vvi_wire_put_number(out, label->codes != NULL);
    if (label->codes)
        vvi_wire_put(out, label->codes, VV_LABEL_CODES * sizeof *label->codes);
}

void vvi_wire_put_mesh(vvi_text *out, const vv_mesh_info *mesh, unsigned with)
{
    vvi_wire_put_number(out, (int64_t)mesh->n_vertices);
    vvi_wire_put_number(out, (int64_t)mesh->n_triangles);
    vvi_wire_put_number(out, (int64_t)mesh->n_parts);
    vvi_wire_put_number(out, with);
    vvi_wire_put_number(out, mesh->space);
    vvi_wire_put_number(out, mesh->up);
    vvi_wire_put(out, &mesh->origin, sizeof mesh->origin);
    vvi_wire_put(out, mesh->unit, sizeof mesh->unit);
    vvi_wire_put(out, mesh->value_name, sizeof mesh->value_name);
    vvi_wire_put(out, mesh->value_unit, sizeof mesh->value_unit);
    vvi_wire_put_number(out, (int64_t)mesh->n_coordinates);
    vvi_wire_put_number(out, (int64_t)mesh->n_textures);
    for (size_t i = 0; i < mesh->n_textures; i++) {
        const vv_mesh_texture *t = &mesh->textures[i];
        vvi_wire_put(out, t->name, sizeof t->name);
        vvi_wire_put_number(out, t->width);
        vvi_wire_put_number(out, t->height);
        vvi_wire_put_number(out, t->wrap[0]);
        vvi_wire_put_number(out, t->wrap[1]);
    }
}

/* Taking ---------------------------------------------------------------------------------------------------------- */

const void *vvi_wire_take_bytes(vvi_wire_in *in, size_t n)
{
    if (in->bad || n > in->n - in->at) {
        in->bad = true;
        return NULL;
    }
    in->at += n;
    return in->bytes + in->at - n;
}

void vvi_wire_take(vvi_wire_in *in, void *out, size_t n)
{
    if (in->bad || n > in->n - in->at) {
        in->bad = true;
        memset(out, 0, n);
        return;
    }
    memcpy(out, in->bytes + in->at, n);
    in->at += n;
}

int64_t vvi_wire_take_number(vvi_wire_in *in)
{
    int64_t number;
    vvi_wire_take(in, &number, sizeof number);
    return number;
}

int64_t vvi_wire_take_between(vvi_wire_in *in, int64_t lo, int64_t hi)
{
    const int64_t number = vvi_wire_take_number(in);
    if (number >= lo && number <= hi)
        return number;
    in->bad = true;
    return lo;
}

const char *vvi_wire_take_text_or_null(vvi_wire_in *in)
{
    const int64_t n = vvi_wire_take_between(in, 0, INT64_MAX);
    if (in->bad || n == 0)
        return NULL;
    const char *text = in->bytes + in->at;
    if ((uint64_t)n > in->n - in->at || memchr(text, 0, (size_t)n) != text + n - 1) {
        in->bad = true;
        return NULL;
    }
    in->at += (size_t)n;
    return text;
}

const char *vvi_wire_take_text(vvi_wire_in *in)
{
    const char *text = vvi_wire_take_text_or_null(in);
    if (text)
        return text;
    in->bad = true;
    return "";
}

static void take_name(vvi_wire_in *in, char *out, size_t n)
{
    vvi_wire_take(in, out, n);
    if (!memchr(out, 0, n))
        in->bad = true;
    out[n - 1] = 0;
}

/* Any bytes may stand for a double; a colour or a range of what is not finite means nothing. */
static double take_finite(vvi_wire_in *in)
{
    double number;
    vvi_wire_take(in, &number, sizeof number);
    return isfinite(number) ? number : 0;
}

static vv_color take_color(vvi_wire_in *in, bool *there)
{
    vv_color color;
    *there = vvi_wire_take_between(in, 0, 1) == 1;
    color.r = take_finite(in);
    color.g = take_finite(in);
    color.b = take_finite(in);
    color.a = take_finite(in);
    return color;
}

vv_channel vvi_wire_take_channel(vvi_wire_in *in)
{
    vv_channel channel = {0};
    take_name(in, channel.name, sizeof channel.name);
    channel.color = take_color(in, &channel.has_color);
    channel.lo = take_finite(in);
    channel.hi = take_finite(in);
    return channel;
}

static void take_codes(vvi_wire_in *in, vv_code codes[VV_LABEL_CODES])
{
    for (int c = 0; c < VV_LABEL_CODES; c++) {
        take_name(in, codes[c].scheme, sizeof codes[c].scheme);
        take_name(in, codes[c].value, sizeof codes[c].value);
        take_name(in, codes[c].meaning, sizeof codes[c].meaning);
    }
}

vv_label vvi_wire_take_label(vvi_wire_in *in, vv_code codes[VV_LABEL_CODES])
{
    vv_label label = {.value = vvi_wire_take_number(in)};
    take_name(in, label.name, sizeof label.name);
    label.color = take_color(in, &label.has_color);
    label.layer = (int)vvi_wire_take_between(in, 0, INT32_MAX);
    if (vvi_wire_take_between(in, 0, 1) == 1) {
        take_codes(in, codes);
        label.codes = codes;
    }
    return label;
}

/* Yours to free(); NULL: there are none, or the message is bad. */
static vv_mesh_texture *take_textures(vvi_wire_in *in, size_t n)
{
    vv_mesh_texture *all = in->bad || n == 0 ? NULL : vvi_calloc(n, sizeof *all);
    in->bad |= n > 0 && !all;
    for (size_t i = 0; i < n && !in->bad; i++) {
        take_name(in, all[i].name, sizeof all[i].name);
        all[i].width = (int32_t)vvi_wire_take_between(in, 1, VVI_IMAGE_SIDE_MOST);
        all[i].height = (int32_t)vvi_wire_take_between(in, 1, VVI_IMAGE_SIDE_MOST);
        all[i].wrap[0] = (int)vvi_wire_take_between(in, VV_WRAP_REPEAT, VV_WRAP_CLAMP);
        all[i].wrap[1] = (int)vvi_wire_take_between(in, VV_WRAP_REPEAT, VV_WRAP_CLAMP);
    }
    return all;
}

vv_mesh_info vvi_wire_take_mesh(vvi_wire_in *in, unsigned *with_out)
{
    vv_mesh_info mesh = {.n_vertices = (size_t)vvi_wire_take_between(in, 0, UINT32_MAX)};
    mesh.n_triangles = (size_t)vvi_wire_take_between(in, 0, UINT32_MAX);
    mesh.n_parts = (size_t)vvi_wire_take_between(in, 0, UINT32_MAX);
    *with_out = (unsigned)vvi_wire_take_between(in, 0, VVI_MESH_ALL);
    mesh.space = (vv_space)vvi_wire_take_between(in, VV_SPACE_PLAIN, VV_SPACE_RAS);
    mesh.up = (vv_up)vvi_wire_take_between(in, VV_UP_Z, VV_UP_Y);
    mesh.origin.x = take_finite(in);
    mesh.origin.y = take_finite(in);
    mesh.origin.z = take_finite(in);
    take_name(in, mesh.unit, sizeof mesh.unit);
    take_name(in, mesh.value_name, sizeof mesh.value_name);
    take_name(in, mesh.value_unit, sizeof mesh.value_unit);
    mesh.n_coordinates = (size_t)vvi_wire_take_between(in, 0, UINT32_MAX);
    mesh.n_textures = (size_t)vvi_wire_take_between(in, 0, (int64_t)((in->n - in->at) / sizeof mesh.textures->name));
    mesh.textures = take_textures(in, mesh.n_textures);
    return mesh;
}

bool vvi_wire_taken(const vvi_wire_in *in)
{
    return !in->bad && in->at == in->n;
}

/* Sending --------------------------------------------------------------------------------------------------------- */

static bool send_all(int socket, const char *data, size_t n)
{
    while (n > 0) {
        const ssize_t sent = send(socket, data, n, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR)
            return false;
        data += sent > 0 ? sent : 0;
        n -= sent > 0 ? (size_t)sent : 0;
    }
    return true;
}

/* The head goes in one piece, the descriptor with it. */
static bool send_head(int socket, vvi_wire_head *head, int descriptor)
{
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {0};
    struct iovec piece = {head, sizeof *head};
    struct msghdr message = {.msg_iov = &piece, .msg_iovlen = 1};
    if (descriptor >= 0) {
        message.msg_control = control.room;
        message.msg_controllen = sizeof control.room;
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET;
        c->cmsg_type = SCM_RIGHTS;
        c->cmsg_len = CMSG_LEN(sizeof(int));
        memcpy(CMSG_DATA(c), &descriptor, sizeof descriptor);
    }
    ssize_t sent;
    do {
        sent = sendmsg(socket, &message, MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    return sent > 0 && send_all(socket, (const char *)head + sent, sizeof *head - (size_t)sent);
}

bool vvi_wire_send(int socket, vvi_wire_kind kind, const vvi_text *body, int descriptor)
{
    vvi_wire_head head = {VVI_WIRE_MAGIC, (uint32_t)kind, body->n};
    return !body->bad && send_head(socket, &head, descriptor) && send_all(socket, body->s, body->n);
}
