/** @file
 * What every public header needs: export marks, C++ guards, exact integer types.
 */
#ifndef VOLVIS_BASE_H
#define VOLVIS_BASE_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define VV_BEGIN_DECLS extern "C" {
#define VV_END_DECLS }
#else
#define VV_BEGIN_DECLS
#define VV_END_DECLS
#endif

#if defined(__GNUC__)
#define VV_API __attribute__((visibility("default")))
#define VV_PRINTF(format_at, first) __attribute__((format(printf, format_at, first)))
#else
#define VV_API
#define VV_PRINTF(format_at, first)
#endif

#endif
