#include "core/cpu.h"
#include "config.h"
#include "core/cpu_select.h"
#include "core/runtime.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#if defined(__x86_64__)
static bool has_all(uint32_t bits, uint32_t wanted)
{
    return (bits & wanted) == wanted;
}

/* Registers that the operating system saves: xmm and ymm are bits 1, 2; the AVX-512 ones 5, 6, 7. */
static uint32_t saved_registers(void)
{
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

static uint32_t machine_bits(void)
{
    uint32_t a, b, c, d, c1;
    if (!__get_cpuid(1, &a, &b, &c1, &d) || !(c1 & bit_OSXSAVE) || !__get_cpuid_count(7, 0, &a, &b, &c, &d))
        return 0;
    const uint32_t saved = saved_registers();
    const bool avx2 =
        has_all(saved, 0x6) && has_all(c1, bit_AVX | bit_FMA | bit_F16C) && has_all(b, bit_AVX2 | bit_BMI2);
    const bool avx512 =
        avx2 && has_all(saved, 0xe6) && has_all(b, bit_AVX512F | bit_AVX512BW | bit_AVX512DQ | bit_AVX512VL);
    return (avx2 ? VVI_CPU_AVX2 : 0u) | (avx512 ? VVI_CPU_AVX512 : 0u);
}
#elif defined(__aarch64__)
static uint32_t machine_bits(void)
{
    return VVI_CPU_NEON; /* part of every 64-bit Arm */
}
#else
static uint32_t machine_bits(void)
{
    return 0;
}
#endif

/* Best last: the name of a set of bits is that of the last row that is wholly in it. */
static const struct row {
    const char *name;
    uint32_t bits;
    bool built;
} rows[] = {
    {"base", 0, true},
#ifdef VV_HAVE_AVX2
    {"avx2", VVI_CPU_AVX2, true},
#else
    {"avx2", VVI_CPU_AVX2, false},
#endif
#ifdef VV_HAVE_AVX512
    {"avx512", VVI_CPU_AVX2 | VVI_CPU_AVX512, true},
#else
    {"avx512", VVI_CPU_AVX2 | VVI_CPU_AVX512, false},
#endif
#ifdef VV_HAVE_NEON
    {"neon", VVI_CPU_NEON, true},
#else
    {"neon", VVI_CPU_NEON, false},
#endif
};
enum { N_ROWS = sizeof rows / sizeof *rows };

static const struct row *find_row(const char *name)
{
    for (size_t i = 0; i < N_ROWS; i++)
        if (strcmp(rows[i].name, name) == 0)
            return &rows[i];
    return NULL;
}

const char *vvi_cpu_name(uint32_t bits)
{
    const char *name = rows[0].name;
    for (size_t i = 0; i < N_ROWS; i++)
        if (rows[i].built && (rows[i].bits & bits) == rows[i].bits)
            name = rows[i].name;
    return name;
}

vv_status vvi_cpu_select(uint32_t *bits_out, const char *name)
{
    const char *place = name ? "cpu" : "VOLVIS_CPU";
    if (!name)
        name = getenv("VOLVIS_CPU");
    *bits_out = machine_bits();
    if (!name || !*name)
        return VV_OK;
    const struct row *row = find_row(name);
    if (!row)
        return vv_fail(VV_E_ARGUMENT, "%s: no instruction set is named '%s'; there are base, avx2, avx512, neon", place,
                       name);
    if ((row->bits & *bits_out) != row->bits)
        return vv_fail(VV_E_UNSUPPORTED, "%s: this CPU does not have %s; the best it has is %s", place, name,
                       vvi_cpu_name(*bits_out));
    *bits_out = row->bits;
    return VV_OK;
}

uint32_t vvi_cpu_detect(void)
{
    const char *name = getenv("VOLVIS_CPU");
    const struct row *row = name ? find_row(name) : NULL;
    return row ? machine_bits() & row->bits : machine_bits();
}

uint32_t vvi_job_cpu(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime ? runtime->cpu : vvi_cpu_detect();
}
