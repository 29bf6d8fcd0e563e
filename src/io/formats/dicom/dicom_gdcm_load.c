/* The module is never given back: what it has allocated stays reachable, and its code is in use on other threads. */
#include "core/installed.h"
#include "io/formats/dicom/dicom_gdcm.h"
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const vvi_gdcm *loaded;
static char problem[2048];

static void load(void)
{
    char path[4096];
    if (!vvi_installed_find(path, sizeof path, VVI_GDCM_MODULE, R_OK)) {
        snprintf(problem, sizeof problem,
                 "there is no " VVI_GDCM_MODULE " beside the program nor in its libexec (last looked for: %.1024s)",
                 path);
        return;
    }
    void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const vvi_gdcm *table = module ? dlsym(module, VVI_GDCM_TABLE) : NULL;
    if (table && table->api == VVI_GDCM_API)
        loaded = table;
    else if (table)
        snprintf(problem, sizeof problem, "%.1024s is of another release of VolVis", path);
    else
        snprintf(problem, sizeof problem, "it cannot be loaded (%.1900s)", dlerror());
}

const vvi_gdcm *vvi_gdcm_load(void)
{
    pthread_once(&once, load);
    return loaded;
}

const char *vvi_gdcm_problem(void)
{
    return vvi_gdcm_load() ? NULL : problem;
}

bool vvi_gdcm_is_there(void)
{
    char path[4096];
    return vvi_installed_find(path, sizeof path, VVI_GDCM_MODULE, R_OK);
}
