#include "import/import_mesh.h"
#include "core/job.h"
#include "grid/mesh.h"
#include "import/import_listen.h"
#include "import/import_room.h"
#include "io/mesh_file.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static uint64_t take(uint64_t *end, bool there, uint64_t n, uint64_t bytes)
{
    const uint64_t at = *end;
    *end += there ? (n * bytes + 7) / 8 * 8 : 0;
    return at;
}

vvi_mesh_room vvi_mesh_room_of(const vv_mesh_info *m, unsigned with)
{
    vvi_mesh_room r = {0};
    r.positions = take(&r.end, true, m->n_vertices, 3 * sizeof(float));
    r.normals = take(&r.end, with & VVI_MESH_NORMALS, m->n_vertices, 3 * sizeof(float));
    r.values = take(&r.end, with & VVI_MESH_VALUES, m->n_vertices, sizeof(float));
    r.colors = take(&r.end, with & VVI_MESH_COLORS, m->n_vertices, 4);
    r.triangles = take(&r.end, true, m->n_triangles, 3 * sizeof(uint32_t));
    r.parts = take(&r.end, true, m->n_parts, sizeof(vv_mesh_part));
    r.coordinates = take(&r.end, with & VVI_MESH_COORDINATES, m->n_coordinates, 2 * sizeof(float));
    r.coordinate_of = take(&r.end, with & VVI_MESH_CORNERS, m->n_triangles, 3 * sizeof(uint32_t));
    r.pixels = r.end;
    for (size_t i = 0; i < m->n_textures; i++)
        take(&r.end, true, (uint64_t)m->textures[i].width * (uint64_t)m->textures[i].height, 4);
    return r;
}

/* Reading -----------------------------------------------------------------------------------------------------------
 */

static void copy(void *out, const char *from, uint64_t at, uint64_t bytes)
{
    if (out && bytes > 0)
        memcpy(out, from + at, (size_t)bytes);
}

static vv_status textures_of_room(vv_mesh *mesh, const vv_mesh_info *m, uint64_t at, const char *from, vv_job *job)
{
    vvi_mesh_textures *textures;
    vv_mesh_texture *t = (vv_mesh_texture *)(uintptr_t)m->textures;
    for (size_t i = 0; i < m->n_textures; i++) {
        t[i].pixels = (const uint8_t *)from + at;
        take(&at, true, (uint64_t)t[i].width * (uint64_t)t[i].height, 4);
    }
    const vv_status st = vvi_mesh_textures_copy(&textures, m, job);
    vvi_mesh_set_textures(mesh, textures);
    return st;
}

static vv_status mesh_of_room(vv_mesh **out, const vv_mesh_info *m, unsigned with, const char *from, vv_job *job)
{
    const vvi_mesh_room r = vvi_mesh_room_of(m, with);
    vvi_mesh_arrays a;
    const vv_status st = vvi_mesh_new(out, &a, m, with, job);
    if (st != VV_OK)
        return st;
    copy(a.positions, from, r.positions, 3 * sizeof(float) * (uint64_t)m->n_vertices);
    copy(a.normals, from, r.normals, 3 * sizeof(float) * (uint64_t)m->n_vertices);
    copy(a.values, from, r.values, sizeof(float) * (uint64_t)m->n_vertices);
    copy(a.colors, from, r.colors, 4 * (uint64_t)m->n_vertices);
    copy(a.triangles, from, r.triangles, 3 * sizeof(uint32_t) * (uint64_t)m->n_triangles);
    copy(a.parts, from, r.parts, sizeof(vv_mesh_part) * (uint64_t)m->n_parts);
    copy(a.coordinates, from, r.coordinates, 2 * sizeof(float) * (uint64_t)m->n_coordinates);
    copy(a.coordinate_of, from, r.coordinate_of, 3 * sizeof(uint32_t) * (uint64_t)m->n_triangles);
    return textures_of_room(*out, m, r.pixels, from, job);
}

static vv_status fill_room(vvi_import_process *p, vvi_import_room *room, int fd, vv_job *job)
{
    const vvi_text nothing = {0};
    vvi_wire_in in;
    vv_status st = vvi_import_room_count(room, job);
    if (st != VV_OK || (st = vvi_import_ask(p, VVI_WIRE_READ_MESH, &nothing, fd)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_DONE, &in, NULL, job)) != VV_OK)
        return st;
    if (!vvi_wire_taken(&in))
        return vvi_import_nonsense(p, "a message that does not hold what it should");
    return vvi_import_room_seal(room, fd) ? VV_OK : vvi_import_nonsense(p, "arrays that it still holds");
}

/* Checked in copies, which nobody else can change. */
static vv_status fail_arrays(vvi_import_process *p)
{
    char flaw[256];
    snprintf(flaw, sizeof flaw, "%s", vv_error_last()->message);
    return vvi_import_nonsense(p, flaw);
}

static vv_status take_arrays(vv_mesh **out, vvi_import_process *p, const vv_mesh_info *m, unsigned with, vv_job *job)
{
    vvi_import_room *room;
    int fd;
    const vvi_mesh_room r = vvi_mesh_room_of(m, with);
    vv_status st = vvi_import_room_new(&room, &fd, r.end + 8);
    if (st != VV_OK)
        return st;
    st = fill_room(p, room, fd, job);
    close(fd);
    if (st == VV_OK)
        st = mesh_of_room(out, m, with, room->data, job);
    vvi_import_room_free(room);
    return st == VV_OK && vvi_mesh_check(vv_mesh_get_info(*out)) != VV_OK ? fail_arrays(p) : st;
}

static vv_status ask_to_open(vvi_import_process *p, const char *path, const vv_mesh_read_options *options, vv_job *job)
{
    int fd;
    vvi_text body = {0};
    vv_status st = vvi_import_open_place(&fd, path, job);
    if (st != VV_OK)
        return st;
    vvi_import_put_file(&body, path, job);
    vvi_wire_put_text(&body, options->format);
    vvi_wire_put_text(&body, options->unit);
    vvi_import_put_terms(&body, job);
    st = vvi_import_ask(p, VVI_WIRE_OPEN_MESH, &body, fd);
    vvi_text_free(&body);
    if (fd >= 0)
        close(fd);
    return st;
}

static vv_status read_mesh(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, vvi_import_process *p,
                           const char *path, const vv_mesh_read_options *options, vv_job *job)
{
    vvi_wire_in in;
    unsigned with;
    vv_status st = vvi_import_start(p, job);
    if (st != VV_OK || (st = ask_to_open(p, path, options, job)) != VV_OK ||
        (st = vvi_import_listen(p, VVI_WIRE_OPENED_MESH, &in, notes, job)) != VV_OK)
        return st;
    const char *format = vvi_wire_take_text(&in);
    *format_out = vvi_mesh_format_find(format, vvi_job_registry(job));
    const vv_mesh_info mesh = vvi_wire_take_mesh(&in, &with);
    if (!vvi_wire_taken(&in) || !*format_out)
        st = vvi_import_nonsense(p, "a mesh of no format");
    else
        st = take_arrays(out, p, &mesh, with, job);
    free((void *)(uintptr_t)mesh.textures);
    return st;
}

vv_status vvi_import_mesh(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, const char *path,
                          const vv_mesh_read_options *options, vv_job *job)
{
    vvi_import_process p = {.socket = -1, .input = -1, .endless = strcmp(path, "-") == 0};
    *out = NULL;
    if (vvi_job_registry(job) != vv_registry_builtin() && !vvi_job_import_program(job))
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "the import program knows the formats that are built in and no others");
    p.name = p.endless ? "standard input" : path;
    const vv_status st = read_mesh(out, format_out, notes, &p, path, options, job);
    vvi_import_stop(&p);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
