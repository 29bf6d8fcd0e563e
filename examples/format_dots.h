#ifndef EXAMPLE_FORMAT_DOTS_H
#define EXAMPLE_FORMAT_DOTS_H
#include <volvis/sys/registry.h>

extern const vv_format format_dots;
#endif
