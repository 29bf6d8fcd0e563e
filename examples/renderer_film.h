#ifndef EXAMPLE_RENDERER_FILM_H
#define EXAMPLE_RENDERER_FILM_H
#include <volvis/sys/registry.h>

extern const vv_renderer renderer_film;
#endif
