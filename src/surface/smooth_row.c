/* Smooth: a mesh without its steps and noise, of the same size, as an operation. */
#include "registry.h"
#include "surface/smooth.h"

typedef struct smooth_params {
    vv_object base;
    int64_t iterations;
    double pass_band;
    bool fix_border;
} smooth_params;

static const vv_property properties[] = {
    {VV_PROP(smooth_params, iterations), .kind = VV_KIND_I64, .def = 20, .limited = true, .min = 0, .max = 1000,
     .doc = "pairs of steps: the more, the sharper the cut-off between long and short waves"},
    {VV_PROP(smooth_params, pass_band), .kind = VV_KIND_F64, .def = 0.1, .limited = true, .min = 0.001, .max = 1.9,
     .doc = "waves up to this frequency are kept; 0.1: waves of about 15 edges and longer"},
    {VV_PROP(smooth_params, fix_border), .kind = VV_KIND_BOOL, .doc = "vertices at open edges stay in place"},
    {0},
};

static const vv_class smooth_class = {
    .name = "smooth",
    .doc = "parameters of smooth",
    .size = sizeof(smooth_params),
    .properties = properties,
};

static vv_status make(vv_data *out, const vv_data *inputs, size_t n_inputs, const vv_object *params, vv_job *job)
{
    const smooth_params *p = (const smooth_params *)params;
    vvi_smooth_options options = vvi_smooth_options_default();
    options.iterations = (int)p->iterations;
    options.pass_band = p->pass_band;
    options.fix_border = p->fix_border;
    return vvi_mesh_smooth(&out->mesh, inputs[0].mesh, &options, job);
}

const vv_operation vvi_operation_smooth = {
    .api = VV_OPERATION_API,
    .name = "smooth",
    .component = "surface",
    .group = "surfaces",
    .doc = "a smoother mesh, without steps and noise and without shrinking (maximally flat filter)",
    .example = "volvis smooth skin.ply -o smooth.ply --iterations 10",
    .params = &smooth_class,
    .inputs = VV_ONE_MESH,
    .make = make,
    .makes = VV_IS_MESH,
};
