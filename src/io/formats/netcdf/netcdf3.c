/* netCDF-3, the classic format, is not HDF5: it is known by its first bytes and refused with what to do. */
#include "io/formats/netcdf/netcdf.h"
#include <string.h>

bool vvi_netcdf3_magic(const uint8_t *head, size_t n)
{
    return n >= 4 && memcmp(head, "CDF", 3) == 0 && (head[3] == 1 || head[3] == 2 || head[3] == 5);
}

static bool holds(const uint8_t *head, size_t n, const char *word)
{
    return memmem(head, n, word, strlen(word)) != NULL;
}

vv_status vvi_netcdf3_refuse(vv_source *source)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    const char *name = vvi_source_name(source);
    if (!head)
        return vv_error_last()->status;
    if (holds(head, n, "num_nod_per_el") || holds(head, n, "num_nodes"))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "is an Exodus II mesh, and only regular grids are read; resample it to an image in ParaView "
                          "and save that as .vti");
    if (holds(head, n, "xspace"))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "is MINC 1, which is not read; 'mincconvert -2 IN.mnc OUT.mnc' makes MINC 2 of it");
    return vv_fail_at(
        VV_E_UNSUPPORTED, name, NULL,
        "is a classic netCDF-3 file, which is not read; 'nccopy -k nc4 IN.nc OUT.nc' makes netCDF-4 of it");
}
