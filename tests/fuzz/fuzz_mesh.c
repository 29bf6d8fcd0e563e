/* The first byte chooses among the mesh formats, unless the rest is certainly one of them. */
#include "core/job.h"
#include "fuzz.h"
#include "io/mesh_file.h"
#include "io/source.h"

static void check(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vv_mesh_topology topology;
    for (size_t i = 0; i < 3 * m->n_triangles; i++)
        fuzz_expect(m->triangles[i] < m->n_vertices);
    size_t next = 0;
    for (size_t i = 0; i < m->n_parts; i++) {
        fuzz_expect(m->parts[i].first_triangle == next);
        next += m->parts[i].n_triangles;
    }
    fuzz_expect(m->n_parts == 0 || next == m->n_triangles);
    for (size_t i = 0; i < m->n_parts; i++)
        fuzz_expect(m->parts[i].texture <= m->n_textures);
    for (size_t i = 0; m->coordinate_of && i < 3 * m->n_triangles; i++)
        fuzz_expect(m->coordinate_of[i] < m->n_coordinates);
    fuzz_expect(!m->coordinates || m->coordinate_of || m->n_coordinates == m->n_vertices);
    const vv_status st = vv_mesh_count_topology(&topology, mesh, fuzz_job());
    fuzz_expect(st != VV_OK || topology.n_edges <= 3 * m->n_triangles);
}

static void read_as(const vv_mesh_format *format, const uint8_t *data, size_t n)
{
    vv_source *source;
    vv_notes *notes = NULL;
    vv_mesh *mesh = NULL;
    const vv_mesh_read_options options = {.size = sizeof options, .unit = "mm"};
    if (vvi_source_memory(&source, data, n, "bytes", fuzz_job()) != VV_OK)
        return;
    vv_status st = vvi_notes_new(&notes, fuzz_job());
    if (st == VV_OK)
        st = format->read(&mesh, source, &options, notes, fuzz_job());
    fuzz_expect(st != VV_OK || mesh);
    fuzz_expect(st == VV_OK || vv_error_last()->message[0]);
    if (mesh)
        check(mesh);
    vv_mesh_release(mesh);
    vvi_notes_free(notes);
    vvi_source_close(source);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    const vv_registry *registry = vv_registry_builtin();
    const vv_mesh_format *format;
    size_t n_formats = 0;
    if (n == 0)
        return 0;
    while (registry->mesh_formats[n_formats])
        n_formats++;
    if (vvi_mesh_format_of_head(&format, data, n < 4096 ? n : 4096, "bytes", registry) > 0)
        read_as(format, data, n);
    else
        read_as(registry->mesh_formats[data[0] % n_formats], data + 1, n - 1);
    return 0;
}
