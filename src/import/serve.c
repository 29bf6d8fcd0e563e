#include "serve.h"
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/status.h"
#include "grid/mesh.h"
#include "image/image_layer.h"
#include "import/import.h"
#include "import/import_image.h"
#include "import/import_mesh.h"
#include "import/import_wire.h"
#include "io/file_stream.h"
#include "io/mesh_file.h"
#include "io/sample_writer.h"
#include "lock.h"
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <volvis/image.h>
#include <volvis/runtime.h>
#include <volvis/version.h>

typedef struct server {
    int socket;
    pthread_mutex_t lock; /* of what is sent: log lines and progress come from any thread */
    vv_runtime *runtime;
    vv_job *job;
    vv_file *file;
    vv_mesh *mesh;   /* or this */
    vv_image *image; /* or this */
    char *bytes;     /* of the request */
    vvi_wire_in in;
    int descriptor; /* that came with it; -1: none */
} server;

/* Who asks is gone: nothing is left to do. */
static void hang_up(void)
{
    _exit(0);
}

static void send_message(server *s, vvi_wire_kind kind, vvi_text *body)
{
    pthread_mutex_lock(&s->lock);
    if (!vvi_wire_send(s->socket, kind, body, -1))
        hang_up();
    pthread_mutex_unlock(&s->lock);
    vvi_text_free(body);
}

static void send_failure(server *s)
{
    const vv_error *error = vv_error_last();
    vvi_text body = {0};
    vvi_wire_put_number(&body, error->status == VV_OK ? VV_E_INTERNAL : error->status);
    vvi_wire_put_text(&body, error->message);
    vvi_wire_put_text(&body, error->file);
    vvi_wire_put_text(&body, error->where);
    send_message(s, VVI_WIRE_FAILED, &body);
}

static void on_log(void *user, vv_log_level level, const char *component, const char *text)
{
    vvi_text body = {0};
    (void)component; /* readers say all that is said here */
    vvi_wire_put_number(&body, level);
    vvi_wire_put_text(&body, text);
    send_message(user, VVI_WIRE_LOG, &body);
}

static bool on_progress(void *user, const vv_progress *progress)
{
    vvi_text body = {0};
    vvi_wire_put_number(&body, (int64_t)progress->done);
    vvi_wire_put_number(&body, (int64_t)(progress->total > progress->done ? progress->total : progress->done));
    send_message(user, VVI_WIRE_PROGRESS, &body);
    return true;
}

/* Requests -------------------------------------------------------------------------------------------------------- */

static void keep_descriptor(server *s, struct msghdr *message)
{
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c)) {
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS && c->cmsg_len == CMSG_LEN(sizeof(int)))
            memcpy(&s->descriptor, CMSG_DATA(c), sizeof s->descriptor);
    }
}

static void receive_bytes(server *s, void *out, size_t n)
{
    char control[CMSG_SPACE(sizeof(int))];
    while (n > 0) {
        struct iovec piece = {out, n};
        struct msghdr message = {
            .msg_iov = &piece, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
        const ssize_t got = recvmsg(s->socket, &message, MSG_CMSG_CLOEXEC);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            hang_up();
        keep_descriptor(s, &message);
        out = (char *)out + got;
        n -= (size_t)got;
    }
}

static vvi_wire_kind receive(server *s)
{
    vvi_wire_head head;
    s->descriptor = -1;
    receive_bytes(s, &head, sizeof head);
    if (head.magic != VVI_WIRE_MAGIC || head.n_bytes > (uint64_t)1 << 30)
        hang_up();
    free(s->bytes);
    s->bytes = malloc((size_t)head.n_bytes + 1);
    if (!s->bytes)
        hang_up();
    receive_bytes(s, s->bytes, (size_t)head.n_bytes);
    s->in = (vvi_wire_in){.bytes = s->bytes, .n = (size_t)head.n_bytes};
    return (vvi_wire_kind)head.kind;
}

/* Opening --------------------------------------------------------------------------------------------------------- */

/* Ends the process with who asked, also in the middle of its work. */
static void *watch(void *user)
{
    const server *s = user;
    struct pollfd what = {.fd = s->socket, .events = POLLRDHUP};
    while (poll(&what, 1, -1) < 1 || !(what.revents & (POLLRDHUP | POLLHUP | POLLERR))) {
    }
    hang_up();
    return NULL;
}

/* Everything that may be needed from outside the file is there before the lock falls. */
static vv_status start_runtime(server *s, const vv_registry *registry, const char *path, const char *format)
{
    vv_runtime_options options;
    vv_limits limits;
    pthread_t watcher;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = (int)vvi_wire_take_between(&s->in, 1, 256);
    options.memory_bytes = (uint64_t)vvi_wire_take_between(&s->in, 1, INT64_MAX);
    options.allow_outside = vvi_wire_take_between(&s->in, 0, 1) == 1;
    options.log_level = (vv_log_level)vvi_wire_take_between(&s->in, VV_LOG_ERROR, VV_LOG_DEBUG);
    const bool with_parent = vvi_wire_take_between(&s->in, 0, 1) == 1;
    const bool confined = vvi_wire_take_between(&s->in, 0, 1) == 1;
    vvi_wire_take(&s->in, &limits, sizeof limits);
    if (!vvi_wire_taken(&s->in))
        return vv_fail(VV_E_INTERNAL, "the import program received an unknown request");
    options.limits = &limits;
    options.contain = false; /* it is, here */
    options.registry = registry;
    options.log = on_log;
    options.log_user = s;
    vv_status st = vv_runtime_new(&s->runtime, &options);
    if (st != VV_OK || (st = vv_job_new(&s->job, s->runtime, on_progress, s)) != VV_OK)
        return st;
    vvi_runtime_distrust_all(s->runtime);
    if (with_parent) /* the kernel means the thread that started us, which otherwise may end before its process */
        prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
    const import_file file = {path, format, s->descriptor, confined};
    if (!import_lock_files(&file, s->job, limits.files))
        on_log(s, VV_LOG_INFO, "io", "files that the import program opens cannot be restricted here (no Landlock)");
    import_lock_limits(&limits, options.memory_bytes, options.threads);
    if (!import_lock_calls())
        on_log(s, VV_LOG_INFO, "io",
               "system calls of the import program cannot be restricted here: only its limits apply");
    if (pthread_create(&watcher, NULL, watch, s) != 0)
        return vv_fail(VV_E_MEMORY, "a thread cannot be started in the import program");
    pthread_detach(watcher);
    return VV_OK;
}

static void send_notes(server *s, const vv_notes *notes)
{
    const char *first, *second;
    vv_part part;
    size_t n;
    for (size_t i = 0; vvi_notes_get(notes, i, &first, &second); i++) {
        vvi_text body = {0};
        vvi_wire_put_text(&body, first);
        vvi_wire_put_text(&body, second);
        send_message(s, VVI_WIRE_METADATA, &body);
    }
    for (size_t i = 0; (first = vvi_notes_warning(notes, i)) != NULL; i++) {
        vvi_text body = {0};
        vvi_wire_put_text(&body, first);
        send_message(s, VVI_WIRE_WARNING, &body);
    }
    for (size_t i = 0; vvi_notes_get_part(notes, i, &part); i++) {
        vvi_text body = {0};
        vvi_wire_put_text(&body, part.name);
        vvi_wire_put_text(&body, part.about);
        vvi_wire_put_number(&body, part.chosen);
        send_message(s, VVI_WIRE_PART, &body);
    }
    const vv_channel *channels = vvi_notes_channels(notes, &n);
    for (size_t i = 0; i < n; i++) {
        vvi_text body = {0};
        vvi_wire_put_channel(&body, &channels[i]);
        send_message(s, VVI_WIRE_CHANNEL, &body);
    }
    const vv_label *labels = vvi_notes_labels(notes, &n);
    for (size_t i = 0; i < n; i++) {
        vvi_text body = {0};
        vvi_wire_put_label(&body, &labels[i]);
        send_message(s, VVI_WIRE_LABEL, &body);
    }
    int32_t code;
    const void *bytes;
    for (size_t i = 0; (bytes = vvi_notes_kept(notes, i, &code, &n)) != NULL; i++) {
        vvi_text body = {0};
        vvi_wire_put_number(&body, code);
        vvi_wire_put_number(&body, (int64_t)n);
        vvi_wire_put(&body, bytes, n);
        send_message(s, VVI_WIRE_KEPT, &body);
    }
}

static void send_opened(server *s)
{
    vvi_text body = {0};
    send_notes(s, vvi_file_notes(s->file));
    vvi_wire_put_text(&body, vv_file_format(s->file));
    vvi_wire_put(&body, vv_file_info(s->file), sizeof(vv_field_info));
    vvi_wire_put_number(&body, vv_file_mappable(s->file));
    send_message(s, VVI_WIRE_OPENED, &body);
}

static vv_status take_path(const char **out, server *s)
{
    if (vvi_wire_take_number(&s->in) != VVI_WIRE_VERSION || strcmp(vvi_wire_take_text(&s->in), vv_version()) != 0)
        return vv_fail(VV_E_UNSUPPORTED, "the import program is of another version (%s); install both together",
                       vv_version());
    *out = vvi_wire_take_text(&s->in);
    return VV_OK;
}

static vv_status open_file(server *s, const vv_registry *registry)
{
    const char *path = NULL;
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    if (take_path(&path, s) != VV_OK)
        return vv_error_last()->status;
    options.format = vvi_wire_take_text_or_null(&s->in);
    options.raw = vvi_wire_take_text_or_null(&s->in);
    options.part = vvi_wire_take_text_or_null(&s->in);
    options.finest = vvi_wire_take_between(&s->in, 0, 1) == 1;
    options.any_part = vvi_wire_take_between(&s->in, 0, 1) == 1;
    vv_status st = start_runtime(s, registry, path, options.format);
    return st == VV_OK ? vv_file_open(&s->file, path, &options, s->job) : st;
}

/* Meshes are read at once: no format of theirs tells how large they are before. */
static vv_status open_mesh(server *s, const vv_registry *registry)
{
    const char *path = NULL;
    const vv_mesh_format *format;
    vv_mesh_read_options options;
    vv_notes *notes = NULL;
    vvi_text body = {0};
    vv_mesh_read_options_init(&options, sizeof options);
    if (take_path(&path, s) != VV_OK)
        return vv_error_last()->status;
    options.format = vvi_wire_take_text_or_null(&s->in);
    options.unit = vvi_wire_take_text_or_null(&s->in);
    vv_status st = start_runtime(s, registry, path, options.format);
    if (st == VV_OK)
        st = vvi_notes_new(&notes, s->job);
    if (st == VV_OK)
        st = vvi_mesh_read_noted(&s->mesh, &format, notes, path, &options, s->job);
    if (st == VV_OK) {
        send_notes(s, notes);
        vvi_wire_put_text(&body, format->name);
        vvi_wire_put_mesh(&body, vv_mesh_get_info(s->mesh), vvi_mesh_with(s->mesh));
        send_message(s, VVI_WIRE_OPENED_MESH, &body);
    }
    vvi_notes_free(notes);
    return st;
}

/* Texts of an image, of which the scene is one: it is parsed by who asked. */
static vv_status read_texts(server *s, const vv_registry *registry)
{
    const char *path = NULL;
    vv_text *text = NULL;
    size_t n = 0;
    vvi_text body = {0};
    if (take_path(&path, s) != VV_OK)
        return vv_error_last()->status;
    vv_status st = start_runtime(s, registry, path, NULL);
    if (st == VV_OK)
        st = vv_image_read_text(&text, &n, path, s->job);
    if (st != VV_OK)
        return st;
    vvi_wire_put_number(&body, (int64_t)n);
    for (size_t i = 0; i < n; i++) {
        vvi_wire_put_text(&body, text[i].key);
        vvi_wire_put_text(&body, text[i].value);
    }
    vv_text_free(text, n);
    send_message(s, VVI_WIRE_TEXTS, &body);
    return VV_OK;
}

/* Pixels are read at once, as a mesh is. */
static vv_status open_image(server *s, const vv_registry *registry)
{
    const char *path = NULL;
    vvi_text body = {0};
    if (take_path(&path, s) != VV_OK)
        return vv_error_last()->status;
    vv_status st = start_runtime(s, registry, path, NULL);
    if (st == VV_OK)
        st = vv_image_read(&s->image, NULL, NULL, path, s->job);
    if (st != VV_OK)
        return st;
    vvi_wire_put_number(&body, s->image->width);
    vvi_wire_put_number(&body, s->image->height);
    vvi_wire_put_number(&body, vv_image_layers(s->image));
    send_message(s, VVI_WIRE_OPENED_IMAGE, &body);
    return VV_OK;
}

/* Reading --------------------------------------------------------------------------------------------------------- */

/* Memory that both have, as large as the samples and the guard behind them. */
typedef struct room {
    char *at;
    size_t n, done;
} room;

static vv_status map_room(room *out, int descriptor)
{
    struct stat about;
    if (fstat(descriptor, &about) != 0 || about.st_size <= 0)
        return vv_fail(VV_E_INTERNAL, "there is no memory for the samples");
    const size_t n = (size_t)about.st_size;
    char *memory = mmap(NULL, n, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED)
        return vv_fail(VV_E_MEMORY,
                       "%zu bytes of samples do not fit into the import program: %s; --limit "
                       "import_bytes=N allows more",
                       n, strerror(errno));
    *out = (room){memory, n, 0};
    return VV_OK;
}

static vv_status copy_piece(void *user, void *data, size_t n)
{
    room *to = user;
    if (n > to->n - to->done)
        return vv_fail(VV_E_INTERNAL, "more samples came than were asked for");
    memmove(to->at + to->done, data, n);
    to->done += n;
    return VV_OK;
}

/* *offset_out: where in the file the samples lie as they are, when they may be mapped from there; else they are in the
 * room, most often without being copied, since the reader was lent it. */
static vv_status give_samples(int64_t *offset_out, const vv_field *field, bool may_map, room *to, const server *s)
{
    const vv_box all = vv_field_box(field);
    vv_brick brick;
    uint64_t offset;
    *offset_out = -1;
    vv_status st = vv_field_brick(&brick, field, &all, s->job);
    if (st != VV_OK)
        return st;
    const void *data = brick.data;
    vv_brick_release(&brick);
    if (may_map && vvi_file_mapped_at(s->file, data, &offset) && offset <= INT64_MAX)
        *offset_out = (int64_t)offset;
    else if (data != to->at)
        st = vvi_samples_each(field, -1, copy_piece, to, s->job);
    return st == VV_OK ? vv_field_health(field) : st;
}

static vv_status read_into(vv_field_info *info_out, int64_t *offset_out, room *to, bool may_map, int64_t frame,
                           const vv_box *box, server *s)
{
    vv_field *field;
    vvi_job_lend_room(s->job, to->at, to->n);
    vv_status st = vv_file_read(&field, s->file, frame, box, s->job);
    vvi_job_lend_room(s->job, NULL, 0);
    if (st != VV_OK)
        return st;
    *info_out = *vv_field_get_info(field);
    st = give_samples(offset_out, field, may_map, to, s);
    vv_field_release(field);
    return st;
}

static vv_status read_samples(server *s, vv_field_info *info_out, int64_t *offset_out)
{
    vv_box box;
    room to;
    const bool repeatable = vvi_wire_take_between(&s->in, 0, 1) == 1;
    const unsigned follow = (unsigned)vvi_wire_take_between(&s->in, 0, VVI_FOLLOW_SLABS | VVI_FOLLOW_FRAMES);
    const bool may_map = vvi_wire_take_between(&s->in, 0, 1) == 1;
    const int64_t frame = vvi_wire_take_number(&s->in);
    const bool has_box = vvi_wire_take_between(&s->in, 0, 1) == 1;
    vvi_wire_take(&s->in, &box, sizeof box);
    if (!vvi_wire_taken(&s->in) || s->descriptor < 0 || !s->file)
        return vv_fail(VV_E_INTERNAL, "the import program received an unknown request");
    vvi_file_follow(s->file, follow);
    vv_status st = repeatable ? vvi_file_make_repeatable(s->file, s->job) : VV_OK;
    if (st != VV_OK || (st = map_room(&to, s->descriptor)) != VV_OK)
        return st;
    st = read_into(info_out, offset_out, &to, may_map, frame, has_box ? &box : NULL, s);
    munmap(to.at, to.n); /* before the answer: who asked seals it then, which nobody's mapping may hinder */
    return st;
}

static void answer_read(server *s)
{
    vv_field_info info;
    int64_t offset = -1;
    vvi_text body = {0};
    const vv_status st = read_samples(s, &info, &offset);
    if (s->descriptor >= 0)
        close(s->descriptor);
    if (st != VV_OK) {
        send_failure(s);
        return;
    }
    vvi_wire_put(&body, &info, sizeof info);
    vvi_wire_put_number(&body, vv_job_damaged(s->job));
    vvi_wire_put_number(&body, offset);
    send_message(s, VVI_WIRE_DONE, &body);
}

static void put(const room *to, uint64_t at, const void *data, size_t bytes)
{
    if (data && bytes > 0)
        memcpy(to->at + at, data, bytes);
}

static void put_pixels(const room *to, uint64_t at, const vv_mesh_info *m)
{
    for (size_t i = 0; i < m->n_textures; i++) {
        const size_t n = 4 * (size_t)m->textures[i].width * (size_t)m->textures[i].height;
        put(to, at, m->textures[i].pixels, n);
        at += (n + 7) / 8 * 8;
    }
}

static vv_status copy_mesh(server *s)
{
    room to;
    if (s->descriptor < 0 || !s->mesh)
        return vv_fail(VV_E_INTERNAL, "the import program was asked what it does not understand");
    const vv_status st = map_room(&to, s->descriptor);
    if (st != VV_OK)
        return st;
    const vv_mesh_info *m = vv_mesh_get_info(s->mesh);
    const vvi_mesh_room r = vvi_mesh_room_of(m, vvi_mesh_with(s->mesh));
    const bool fits = r.end <= to.n;
    if (fits) {
        put(&to, r.positions, m->positions, 3 * m->n_vertices * sizeof *m->positions);
        put(&to, r.normals, m->normals, 3 * m->n_vertices * sizeof *m->normals);
        put(&to, r.values, m->values, m->n_vertices * sizeof *m->values);
        put(&to, r.colors, m->colors, 4 * m->n_vertices);
        put(&to, r.triangles, m->triangles, 3 * m->n_triangles * sizeof *m->triangles);
        put(&to, r.parts, m->parts, m->n_parts * sizeof *m->parts);
        put(&to, r.coordinates, m->coordinates, 2 * m->n_coordinates * sizeof *m->coordinates);
        put(&to, r.coordinate_of, m->coordinate_of, 3 * m->n_triangles * sizeof *m->coordinate_of);
        put_pixels(&to, r.pixels, m);
    }
    munmap(to.at, to.n);
    return fits ? VV_OK : vv_fail(VV_E_INTERNAL, "the mesh is larger than the room for it");
}

static vv_status copy_image(server *s)
{
    room to;
    const vv_image *image = s->image;
    if (s->descriptor < 0 || !image)
        return vv_fail(VV_E_INTERNAL, "the import program was asked what it does not understand");
    const vv_status st = map_room(&to, s->descriptor);
    if (st != VV_OK)
        return st;
    const size_t n = (size_t)image->width * (size_t)image->height;
    const vvi_image_room r = vvi_image_room_of(image->width, image->height, vv_image_layers(image));
    const bool fits = r.end <= to.n;
    if (fits)
        put(&to, r.rgba, image->rgba, 4 * n * sizeof *image->rgba);
    for (size_t i = 0; fits && i < VV_LAYER_COUNT; i++)
        put(&to, r.layer[i], vvi_image_layer(image, i), n * vvi_layer_nth(i)->channels * sizeof(float));
    munmap(to.at, to.n);
    return fits ? VV_OK : vv_fail(VV_E_INTERNAL, "the image is larger than the room for it");
}

/* Of what was read when it was opened. */
static void answer_copy(server *s, vv_status (*copy)(server *s))
{
    vvi_text body = {0};
    const vv_status st = copy(s);
    if (s->descriptor >= 0)
        close(s->descriptor);
    if (st == VV_OK)
        send_message(s, VVI_WIRE_DONE, &body);
    else
        send_failure(s);
}

int import_serve(int socket, const vv_registry *registry)
{
    static server s;
    s = (server){.socket = socket, .descriptor = -1};
    if (pthread_mutex_init(&s.lock, NULL) != 0)
        return 1;
    for (;;) {
        const vvi_wire_kind kind = receive(&s);
        if (kind == VVI_WIRE_OPEN && !s.runtime) {
            if (open_file(&s, registry) == VV_OK)
                send_opened(&s);
            else
                send_failure(&s);
        } else if (kind == VVI_WIRE_READ) {
            answer_read(&s);
        } else if (kind == VVI_WIRE_OPEN_MESH && !s.runtime) {
            if (open_mesh(&s, registry) != VV_OK)
                send_failure(&s);
        } else if (kind == VVI_WIRE_READ_MESH) {
            answer_copy(&s, copy_mesh);
        } else if (kind == VVI_WIRE_OPEN_IMAGE && !s.runtime) {
            if (open_image(&s, registry) != VV_OK)
                send_failure(&s);
        } else if (kind == VVI_WIRE_READ_IMAGE) {
            answer_copy(&s, copy_image);
        } else if (kind == VVI_WIRE_READ_TEXTS && !s.runtime) {
            if (read_texts(&s, registry) != VV_OK)
                send_failure(&s);
        } else {
            return 1;
        }
    }
}
