#include "scene/presets.h"
#include "core/names.h"
#include "scene/colormaps.h"
#include <math.h>
#include <string.h>

#define ROWS(array) (array), sizeof(array) / sizeof(array)[0]

static const double bone_opacity[][2] = {{130, 0}, {220, 0.04}, {450, 0.35}, {1500, 0.85}};
static const double bone_color[][4] = {
    {130, 0.42, 0.14, 0.07}, {260, 0.72, 0.45, 0.26}, {600, 0.88, 0.78, 0.62}, {1500, 1, 0.97, 0.92}};

static const double skin_opacity[][2] = {{-600, 0}, {-350, 0.4}, {-100, 0.85}, {1500, 0.95}};
static const double skin_color[][4] = {
    {-600, 0.45, 0.17, 0.1}, {-200, 0.74, 0.4, 0.27}, {120, 0.78, 0.47, 0.34}, {400, 0.93, 0.87, 0.76}};

static const double lungs_opacity[][2] = {{-980, 0}, {-900, 0.012}, {-700, 0.035}, {-550, 0.012},
                                          {-450, 0}, {150, 0},      {350, 0.03},   {1200, 0.25}};
static const double lungs_color[][4] = {{-980, 0.2, 0.4, 0.75},
                                        {-700, 0.5, 0.62, 0.8},
                                        {-450, 0.8, 0.45, 0.4},
                                        {150, 0.8, 0.6, 0.45},
                                        {700, 0.95, 0.93, 0.88}};

static const double vessels_opacity[][2] = {{110, 0}, {160, 0.05}, {240, 0.4}, {500, 0.55}, {1500, 0.8}};
static const double vessels_color[][4] = {{110, 0.45, 0.02, 0.02},
                                          {240, 0.75, 0.06, 0.04},
                                          {420, 0.85, 0.3, 0.18},
                                          {650, 0.9, 0.8, 0.66},
                                          {1500, 1, 0.97, 0.92}};

static const double muscle_opacity[][2] = {{-20, 0}, {20, 0.04}, {60, 0.28}, {120, 0.24}, {200, 0.3}, {1000, 0.7}};
static const double muscle_color[][4] = {{-20, 0.3, 0.03, 0.02},
                                         {60, 0.5, 0.07, 0.05},
                                         {140, 0.62, 0.2, 0.14},
                                         {300, 0.9, 0.8, 0.68},
                                         {1000, 1, 0.97, 0.92}};

static const double head_opacity[][2] = {{0.04, 0}, {0.12, 0.04}, {0.3, 0.3}, {0.7, 0.5}, {1, 0.8}};
static const double brain_opacity[][2] = {{0.25, 0}, {0.4, 0.02}, {0.6, 0.2}, {0.8, 0.5}, {1, 0.7}};
static const double fog_opacity[][2] = {{0, 0}, {1, 0.03}};
static const double ramp_opacity[][2] = {{0, 0}, {1, 0.35}};
static const double surface_opacity[][2] = {{0.28, 0}, {0.36, 0.9}, {1, 0.97}};
static const double core_opacity[][2] = {{0, 0}, {0.15, 0.004}, {0.65, 0.01}, {0.75, 0.45}, {1, 0.8}};

static const vvi_preset presets[] = {
    {{"bone", "bones in CT; skin and muscle are transparent", "transfer", "HU"},
     ROWS(bone_opacity),
     ROWS(bone_color),
     NULL},
    {{"skin", "the skin in CT, closed", "transfer", "HU"}, ROWS(skin_opacity), ROWS(skin_color), NULL},
    {{"lungs", "lungs and airways in CT; ribs faint", "transfer", "HU"}, ROWS(lungs_opacity), ROWS(lungs_color), NULL},
    {{"vessels", "vessels with contrast agent in CT angiography, and bones", "transfer", "HU"},
     ROWS(vessels_opacity),
     ROWS(vessels_color),
     NULL},
    {{"muscle", "muscles and organs in CT over bones", "transfer", "HU"},
     ROWS(muscle_opacity),
     ROWS(muscle_color),
     NULL},
    {{"head", "a head in MR: skin first", "transfer", NULL}, ROWS(head_opacity), NULL, 0, "tissue"},
    {{"brain", "brain in MR: bright tissue, the rest translucent", "transfer", NULL},
     ROWS(brain_opacity),
     NULL,
     0,
     "tissue"},
    {{"fog", "everything, as a thin fog", "transfer", NULL}, ROWS(fog_opacity), NULL, 0, "viridis"},
    {{"ramp", "opacity rises linearly with the value", "transfer", NULL}, ROWS(ramp_opacity), NULL, 0, "viridis"},
    {{"surface", "opaque from a third of the range on", "transfer", NULL}, ROWS(surface_opacity), NULL, 0, "gray"},
    {{"core", "the largest values inside a faint shell", "transfer", NULL}, ROWS(core_opacity), NULL, 0, "inferno"},
    {{"fitted", "opacity rises where the background ends; used when nothing is chosen", "proposal", NULL},
     .propose = NULL},
    {{"boundaries", "boundaries between materials, where the gradient is largest; the inner ones more opaque",
      "proposal", NULL},
     .propose = vvi_propose_boundaries},
    {{"outside", "the outermost surface, closed", "proposal", NULL}, .propose = vvi_propose_outside},
    {{"dense", "the highest values, in a faint fog of the rest", "proposal", NULL}, .propose = vvi_propose_dense},
    {{"bands", "a colour for each peak of the histogram", "proposal", NULL}, .propose = vvi_propose_bands},
};
#define COUNT (sizeof presets / sizeof presets[0])

const vv_preset *vv_preset_nth(size_t index)
{
    return index < COUNT ? &presets[index].head : vvi_colormap_row(index - COUNT);
}

const vvi_preset *vvi_preset_find(const char *name, const char *path)
{
    const char *names[COUNT];
    for (size_t i = 0; i < COUNT; i++) {
        names[i] = presets[i].head.name;
        if (strcmp(names[i], name) == 0)
            return &presets[i];
    }
    if (vvi_colormap_find(name) >= 0) {
        vv_fail_at(VV_E_NOT_FOUND, NULL, path, "'%s' is a colour map, not a transfer function: set colormap=%s", name,
                   name);
        return NULL;
    }
    vvi_fail_name(VV_E_NOT_FOUND, NULL, path, name, &(vvi_known){names, COUNT, "volvis presets", NULL},
                  "there is no preset '%s'", name);
    return NULL;
}

/* Raw CT numbers, 0 for air and 1024 for water: the highest peak above 500 is soft tissue. */
static bool raw_ct(const vv_field_info *info, const vv_statistics *s)
{
    int peak = -1;
    if (vv_type_is_float(info->type) || vv_type_bytes(info->type) < 2 || s->min < 0 || s->max < 1500 || s->max > 8191)
        return false;
    const double width = (s->histogram_hi - s->histogram_lo) / s->n_bins;
    for (int b = 0; b < s->n_bins; b++)
        if (s->histogram_lo + b * width > 500 && (peak < 0 || s->histogram[b] > s->histogram[peak]))
            peak = b;
    const double value = s->histogram_lo + (peak + 0.5) * width;
    return value > 950 && value < 1200;
}

vvi_preset_map vvi_preset_place(const vvi_preset *preset, const vv_field_info *info, const vv_statistics *s, double lo,
                                double hi)
{
    static const double first = -1000, last = 1500; /* HU: air, and all but the densest bone */
    const double range = hi > lo ? hi - lo : 1;
    if (!preset->head.value_unit)
        return (vvi_preset_map){range, lo, false};
    if (strcmp(info->value_unit, "HU") == 0 || (!*info->value_unit && s->min < -200 && s->max > 200))
        return (vvi_preset_map){1, 0, false};
    if (!*info->value_unit && raw_ct(info, s))
        return (vvi_preset_map){1, 1024, false};
    return (vvi_preset_map){range / (last - first), lo - first * range / (last - first), true};
}
