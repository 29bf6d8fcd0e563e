#ifndef VVI_TESTS_RENDERER_FILM_H
#define VVI_TESTS_RENDERER_FILM_H
#include <volvis/sys/registry.h>

extern const vv_renderer vvi_renderer_film;
#endif
