#include "gfx/kernels.h"
#include "gfx/project_simd.h"
#include "gfx/raster_simd.h"
#include "gfx/shade_simd.h"

const vvi_gfx_kernels VV_KERNEL_TABLE(vvi_gfx_kernels) = {
    .needs = VV_ISA_NEEDS,
    .isa = VV_ISA_NAME,
    .project = project,
    .sort = sort,
    .raster = raster,
    .shade = shade,
};
