/* A mesh of your own arrays, measured. */
#include <stdio.h>
#include <volvis/volvis.h>

/* Places, and triangles that are counter-clockwise as seen from outside: a pyramid of height 3 over a square of 2. */
static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 3};
static const uint32_t triangles[] = {0, 2, 1, 0, 3, 2, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};

int main(void)
{
    vv_mesh *mesh = NULL;
    vv_mesh_measures found;
    const vv_mesh_info info = {
        .n_vertices = 5, .n_triangles = 6, .positions = positions, .triangles = triangles, .unit = "cm"};
    vv_status st = vv_mesh_new(&mesh, &info, NULL); /* copies the arrays */
    if (st == VV_OK)
        st = vv_mesh_measure(&found, mesh, NULL, NULL);
    if (st == VV_OK) {
        printf("volume %.6g %s, known to %.1g\n", found.volume.value, found.volume.unit, found.volume.error);
        printf("area %.6g %s, %s\n", found.area.value, found.area.unit, found.closed ? "closed" : "open");
    } else {
        fprintf(stderr, "measure: %s\n", vv_error_last()->message);
    }
    vv_mesh_release(mesh);
    return st != VV_OK;
}
