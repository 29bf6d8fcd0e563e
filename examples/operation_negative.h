#ifndef EXAMPLE_OPERATION_NEGATIVE_H
#define EXAMPLE_OPERATION_NEGATIVE_H
#include <volvis/sys/registry.h>

extern const vv_operation operation_negative;
#endif
