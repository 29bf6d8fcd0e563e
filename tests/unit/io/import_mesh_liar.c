/* What an import program that a mesh has taken over might say. The name of the file that it should read says which lie;
 * up to that it says what is right: a tetrahedron in two parts. */
#include "grid/mesh.h"
#include "import/import_mesh.h"
#include "import_liar.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

static bool is(const char *lie, const char *what)
{
    return strcmp(lie, what) == 0;
}

static vv_mesh_info opened(const char *lie)
{
    vv_mesh_info mesh = {.n_vertices = 4, .n_triangles = 4, .n_parts = 2, .unit = "mm"};
    static vv_mesh_texture texture = {.width = 2, .height = 3};
    vvi_text body = {0};
    mesh.n_textures = 1;
    mesh.textures = &texture;
    if (is(lie, "image"))
        texture.width = 0;
    if (is(lie, "wrap"))
        texture.wrap[1] = 3;
    if (is(lie, "vertices"))
        mesh.n_vertices = (size_t)1 << 40;
    if (is(lie, "negative"))
        mesh.n_triangles = SIZE_MAX;
    if (is(lie, "huge"))
        mesh.n_triangles = UINT32_MAX;
    if (is(lie, "space"))
        mesh.space = (vv_space)9;
    if (is(lie, "unit"))
        memset(mesh.unit, 'x', sizeof mesh.unit);
    vvi_wire_put_text(&body, is(lie, "format") ? "none" : "ply");
    vvi_wire_put_mesh(&body, &mesh, is(lie, "with") ? VVI_MESH_ALL + 1 : VVI_MESH_NORMALS);
    if (is(lie, "rest"))
        vvi_wire_put_number(&body, 1);
    vvi_wire_send(VVI_IMPORT_SOCKET, is(lie, "kind") ? VVI_WIRE_OPENED : VVI_WIRE_OPENED_MESH, &body, -1);
    return mesh;
}

static void fill(const char *lie, const vv_mesh_info *mesh)
{
    static const uint32_t triangles[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
    const vvi_mesh_room r = vvi_mesh_room_of(mesh, VVI_MESH_NORMALS);
    char *at = mmap(NULL, r.end, PROT_READ | PROT_WRITE, MAP_SHARED, shared, 0);
    float *positions = (float *)(void *)(at + r.positions), *normals = (float *)(void *)(at + r.normals);
    vv_mesh_part *parts = (vv_mesh_part *)(void *)(at + r.parts);
    for (int v = 1; v < 4; v++)
        positions[3 * v + v - 1] = normals[3 * v + v - 1] = 1;
    memcpy(at + r.triangles, triangles, sizeof triangles);
    parts[0].n_triangles = 1;
    parts[1] = (vv_mesh_part){.first_triangle = 1, .n_triangles = 3};
    if (is(lie, "index"))
        ((uint32_t *)(void *)(at + r.triangles))[11] = 4;
    if (is(lie, "nan"))
        positions[5] = NAN;
    if (is(lie, "normal"))
        normals[5] = INFINITY;
    if (is(lie, "gap"))
        parts[1].first_triangle = 2;
    if (is(lie, "long"))
        parts[1].n_triangles = SIZE_MAX;
    if (is(lie, "short"))
        parts[1].n_triangles = 2;
    if (is(lie, "name"))
        memset(parts[0].name, 'x', sizeof parts[0].name);
    if (is(lie, "color"))
        parts[0].color.g = NAN;
    if (is(lie, "texture"))
        parts[0].texture = 2;
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
    const vv_mesh_info mesh = opened(lie);
    free(take_message(&n));
    fill(lie, &mesh);
    if (is(lie, "done"))
        vvi_wire_put_number(&nothing, 3);
    vvi_wire_send(VVI_IMPORT_SOCKET, VVI_WIRE_DONE, &nothing, -1);
    take_message(&n);
}
