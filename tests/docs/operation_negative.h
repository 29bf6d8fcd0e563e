#ifndef VVI_TESTS_OPERATION_NEGATIVE_H
#define VVI_TESTS_OPERATION_NEGATIVE_H
#include <volvis/sys/registry.h>

extern const vv_operation vvi_operation_negative;
#endif
