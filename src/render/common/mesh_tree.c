/* Trees of triangles by Embree, on the thread that asks: what is process-wide in Embree and below it is not used. */
#include "render/common/mesh_tree.h"
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include <math.h>
#include <string.h>

#if VV_HAVE_EMBREE
#include <embree3/rtcore.h>

typedef struct tree {
    vv_mesh *mesh; /* its triangles are the tree's */
    double lo[3], hi[3];
    RTCDevice device;
    RTCScene scene;
    vv_job *job;    /* while it is made; else NULL */
    int64_t bytes;  /* that Embree has */
    size_t counted; /* of them */
    vv_runtime *counted_in;
} tree;

/* What making a tree takes at most: 96 to 115 bytes a triangle, vertices included, in meshes of 10^3 to 4 10^6. */
enum { BYTES_A_TRIANGLE = 120, BYTES_A_VERTEX = 12 };

bool vvi_mesh_tree_exists(void)
{
    return true;
}

const char *vvi_mesh_tree_version(void)
{
    return RTC_VERSION_STRING;
}

static void drop(void *value)
{
    tree *t = value;
    if (t->scene)
        rtcReleaseScene(t->scene);
    if (t->device)
        rtcReleaseDevice(t->device);
    vvi_memory_give_back(t->counted_in, t->counted, VVI_MEM_DERIVED);
    vv_mesh_release(t->mesh);
    vvi_free(t);
}

/* Embree tells of all that it takes and gives back. */
static bool count_memory(void *user, ssize_t bytes, bool after)
{
    tree *t = user;
    (void)after;
    t->bytes += bytes;
    return true;
}

static bool is_wanted(void *user, double share)
{
    const tree *t = user;
    (void)share;
    return vvi_job_poll(t->job) == VV_OK;
}

static vv_status fail(const tree *t)
{
    const enum RTCError error = rtcGetDeviceError(t->device);
    if (vvi_job_poll(t->job) != VV_OK)
        return VV_E_CANCELLED;
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        return vv_fail_memory((size_t)t->bytes);
    return vv_fail(VV_E_UNSUPPORTED, "the triangles of a mesh cannot be sorted for rays: Embree's error %d",
                   (int)error);
}

static void find_box(tree *t)
{
    const vv_mesh_info *m = vv_mesh_get_info(t->mesh);
    double reach = 0;
    for (int a = 0; a < 3; a++)
        t->lo[a] = INFINITY, t->hi[a] = -INFINITY;
    for (size_t i = 0; i < 3 * m->n_vertices; i++) {
        const double p = (double)m->positions[i];
        t->lo[i % 3] = fmin(t->lo[i % 3], p);
        t->hi[i % 3] = fmax(t->hi[i % 3], p);
        reach = fmax(reach, fabs(p));
    }
    for (int a = 0; a < 3; a++) {
        t->lo[a] -= 1e-6 * reach;
        t->hi[a] += 1e-6 * reach;
    }
}

void vvi_mesh_tree_box(double lo[3], double hi[3], const vvi_cached *cached)
{
    const tree *t = vvi_cached_value(cached);
    memcpy(lo, t->lo, sizeof t->lo);
    memcpy(hi, t->hi, sizeof t->hi);
}

static vv_status build(tree *t)
{
    const vv_mesh_info *m = vv_mesh_get_info(t->mesh);
    /* one thread, and none kept: TBB's would be the whole process's */
    if (!(t->device = rtcNewDevice("threads=1,set_affinity=0")))
        return vv_fail(VV_E_UNSUPPORTED, "Embree does not start on this machine: error %d",
                       (int)rtcGetDeviceError(NULL));
    rtcSetDeviceMemoryMonitorFunction(t->device, count_memory, t);
    t->scene = rtcNewScene(t->device);
    RTCGeometry g = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                               m->n_vertices); /* a copy: it has what is read behind the last */
    if (!t->scene || !positions) {
        rtcReleaseGeometry(g);
        return fail(t);
    }
    memcpy(positions, m->positions, 3 * m->n_vertices * sizeof *positions);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m->triangles, 0, 3 * sizeof(uint32_t),
                               m->n_triangles);
    rtcCommitGeometry(g);
    rtcAttachGeometry(t->scene, g);
    rtcReleaseGeometry(g);
    rtcSetSceneFlags(t->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcSetSceneProgressMonitorFunction(t->scene, is_wanted, t);
    rtcCommitScene(t->scene);
    return rtcGetDeviceError(t->device) == RTC_ERROR_NONE && vvi_job_poll(t->job) == VV_OK ? VV_OK : fail(t);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(user);
    vv_status st =
        vvi_memory_plan(job, BYTES_A_TRIANGLE * (uint64_t)m->n_triangles + BYTES_A_VERTEX * (uint64_t)m->n_vertices,
                        "a tree of triangles");
    if (st != VV_OK)
        return st;
    tree *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_DERIVED);
    if (!t)
        return vv_fail_memory(sizeof *t);
    t->mesh = vv_mesh_retain(user);
    t->job = job;
    find_box(t);
    st = build(t);
    t->job = NULL;
    if (st == VV_OK && (st = vvi_memory_take(&t->counted_in, job, (size_t)t->bytes, VVI_MEM_DERIVED)) == VV_OK)
        t->counted = (size_t)t->bytes;
    if (st != VV_OK) {
        drop(t);
        return st;
    }
    *value_out = t;
    *bytes_out = sizeof *t + t->counted;
    return VV_OK;
}

vv_status vvi_mesh_tree_get(vvi_cached **out, const vv_mesh *mesh, vv_job *job)
{
    const vvi_cache_key key = {"mesh tree", 0, vv_mesh_checksum(mesh)};
    return vvi_cache_get(out, &key, make, drop, (void *)mesh, job);
}

/* A ray on its way: Embree hands the first member back. */
typedef struct query {
    struct RTCIntersectContext context;
    vvi_mesh_take_fn *take;
    void *user;
} query;

static void ask(const struct RTCFilterFunctionNArguments *args)
{
    const query *q = (const query *)(const void *)args->context;
    const struct RTCRay *ray = (const struct RTCRay *)(const void *)args->ray; /* of one ray, RTCRayN is this */
    const struct RTCHit *at = (const struct RTCHit *)(const void *)args->hit;
    const vvi_mesh_hit hit = {ray->tfar, at->u, at->v, at->primID};
    if (args->valid[0] == -1 && !q->take(q->user, &hit))
        args->valid[0] = 0;
}

bool vvi_mesh_tree_hit(vvi_mesh_hit *out, const vvi_cached *cached, const vvi_mesh_ray *ray, vvi_mesh_take_fn *take,
                       void *user)
{
    const tree *t = vvi_cached_value(cached);
    query q = {.take = take, .user = user};
    struct RTCRayHit rh = {.ray = {.org_x = ray->origin[0],
                                   .org_y = ray->origin[1],
                                   .org_z = ray->origin[2],
                                   .tnear = ray->near,
                                   .dir_x = ray->direction[0],
                                   .dir_y = ray->direction[1],
                                   .dir_z = ray->direction[2],
                                   .tfar = ray->far,
                                   .mask = ~0u},
                           .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
    rtcInitIntersectContext(&q.context);
    q.context.filter = take ? ask : NULL;
    rtcIntersect1(t->scene, &q.context, &rh);
    if (rh.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    *out = (vvi_mesh_hit){rh.ray.tfar, rh.hit.u, rh.hit.v, rh.hit.primID};
    return true;
}

#else

bool vvi_mesh_tree_exists(void)
{
    return false;
}

const char *vvi_mesh_tree_version(void)
{
    return "";
}

vv_status vvi_mesh_tree_get(vvi_cached **out, const vv_mesh *mesh, vv_job *job)
{
    (void)mesh;
    (void)job;
    *out = NULL;
    return vv_fail(VV_E_UNSUPPORTED, "this build cannot find where rays meet triangles: Embree was missing when it was "
                                     "built; use method=surface");
}

void vvi_mesh_tree_box(double lo[3], double hi[3], const vvi_cached *cached)
{
    (void)lo, (void)hi, (void)cached;
}

bool vvi_mesh_tree_hit(vvi_mesh_hit *out, const vvi_cached *cached, const vvi_mesh_ray *ray, vvi_mesh_take_fn *take,
                       void *user)
{
    (void)out, (void)cached, (void)ray, (void)take, (void)user;
    return false;
}
#endif
