#include "filter/mean_lines.h"

#include <string.h>

#define AT_ONCE 256 /* numbers that stay in the first-level cache */

#define NUMBER int32_t
#define NAME(x) x##_i32
#include "filter/mean_body.h"

#define NUMBER int64_t
#define NAME(x) x##_i64
#include "filter/mean_body.h"

#define NUMBER double
#define NAME(x) x##_f64
#include "filter/mean_body.h"
