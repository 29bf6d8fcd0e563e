/* Checkpoints of pictures. The first byte says of what scene; the rest is the file, whose checksums are made right, so
 * that what they guard is reached. */
#include "fuzz.h"
#include "registry.h"
#include "render/checkpoint.h"
#include <stdlib.h>
#include <string.h>

extern const vv_renderer vvi_renderer_raycast, vvi_renderer_surface;

static vv_scene scene_of(uint8_t bits)
{
    return (vv_scene){.width = 9,
                      .height = 7,
                      .samples = bits & 1 ? 9 : 1,
                      .noise = bits & 2 ? 0.01 : 0,
                      .adaptive = bits & 4,
                      .layers = bits & 8 ? 0x1f : VV_LAYER_DEPTH,
                      .renderer = bits & 16 ? &vvi_renderer_surface : &vvi_renderer_raycast};
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    vvi_gathered got;
    vv_source *source;
    uint64_t depends = 0;
    if (n < 1)
        return 0;
    const vv_scene scene = scene_of(data[0]);
    uint8_t *file = malloc(n);
    fuzz_expect(file != NULL);
    memcpy(file, data + 1, n - 1);
    if (data[0] & 32)
        vvi_checkpoint_sign(file, n - 1);
    if (n > 24)
        memcpy(&depends, file + 16, sizeof depends);
    fuzz_expect(vvi_source_memory(&source, file, n - 1, "seed.part", fuzz_job()) == VV_OK);
    const vv_status st = vvi_checkpoint_read(&got, source, &scene, depends, fuzz_job());
    if (st == VV_OK)
        fuzz_expect(got.image && got.done && got.stage <= VVI_STAGE_END && got.passes >= 0 &&
                    (scene.renderer->draw || got.passes <= scene.samples));
    else
        fuzz_expect(*vv_error_last()->message && !got.image && !got.done);
    vvi_gathered_finish(&got);
    vvi_source_close(source);
    free(file);
    return 0;
}
