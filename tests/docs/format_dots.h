#ifndef VVI_TESTS_FORMAT_DOTS_H
#define VVI_TESTS_FORMAT_DOTS_H
#include <volvis/sys/registry.h>

extern const vv_format vvi_format_dots;
#endif
