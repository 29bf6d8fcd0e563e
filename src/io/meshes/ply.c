/* The row of PLY. */
#include "io/meshes/ply.h"
#include "registry.h"

#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= 4 && memcmp(head, "ply", 3) == 0 && (head[3] == '\n' || head[3] == '\r') ? 2 : 0;
}

static const char *const suffixes[] = {".ply", NULL};
static const char *const encodings[] = {"binary", "big-endian", "ascii", NULL};

const vv_mesh_format vvi_mesh_format_ply = {
    .api = VV_MESH_FORMAT_API,
    .name = "ply",
    .doc = "Stanford PLY: normals, values, colours, parts and units; images on triangles in files next to it",
    .beside = true,
    .suffixes = suffixes,
    .encodings = encodings,
    .holds = VV_MESH_HOLDS_NORMALS | VV_MESH_HOLDS_VALUES | VV_MESH_HOLDS_COLORS | VV_MESH_HOLDS_PARTS |
             VV_MESH_HOLDS_PART_COLORS | VV_MESH_HOLDS_UNIT | VV_MESH_HOLDS_DOUBLES | VV_MESH_HOLDS_TEXTURES,
    .probe = probe,
    .read = vvi_ply_read,
    .write = vvi_ply_write,
    .up = VV_UP_Y,
};
