#include "segment/connectivity.h"

#include <stddef.h>

const char *const vvi_connectivity_names[] = {"6", "18", "26", NULL};
const char *const vvi_connectivity_aliases[] = {"4",     "6",  "8",       "26", "faces", "6",
                                                "edges", "18", "corners", "26", NULL};
