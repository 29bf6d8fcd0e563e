/** @file
 * The threads that render: they take what each view wishes to show, in turn, and leave the newest frame of each as a
 * picture file. All functions are for one other thread.
 *
 * One thread makes quick frames: of views that move, and drafts of views that show nothing yet while the other thread
 * is busy. The other makes pictures at rest, one at a time, however large; all other threads leave its picture for
 * quick frames (vvi_job_set_urgent()), and it goes on from where it was. So a newcomer waits for one quick frame, and a
 * hand that moves for none but those of other hands.
 */
#ifndef VVI_SERVER_PAINTER_H
#define VVI_SERVER_PAINTER_H
#include "server/camera.h"
#include "server/warnings.h"
#include <volvis/model.h>

enum { VVI_PAINTER_VIEWS = 2048, VVI_VIEW_NAME = 64 };

/** What a view wishes to show. */
typedef struct vvi_wish {
    vv_world *world; /**< retained by the painter */
    uint64_t commit; /**< its number */
    uint64_t scene;  /**< number of the last commit that was more than a camera: it is worked out and told once */
    uint64_t number; /**< of the wish, yours: its frames have it too */
    char view[VVI_VIEW_NAME];
    bool has_pose; /**< else the World's camera, and the frame tells its pose */
    vvi_pose pose;
    int32_t width, height; /**< of the viewport */
    int32_t frame_size[2]; /**< while it moves; at rest it is the viewport's */
    bool moving;           /**< one quick frame; else ever better ones */
    bool plane;            /**< as urgent as what moves, and exact at once: its frames are full size, and final */
    bool coarse;           /**< coarse pictures first, or a draft: nothing like it is on the screen yet */
    bool unseen;           /**< no picture: the camera and what is worked out are told */
    int64_t event;         /**< when the newest input that it shows came, nanoseconds; 0: none */
    size_t bytes_most;     /**< of a picture at rest; a larger one, and those before the last of more than a
                                  fifth of it, are made JPEG of that, as well as it goes. 0: any */
} vvi_wish;

typedef enum vvi_picture_kind { VVI_PICTURE_JPEG = 1, VVI_PICTURE_PNG = 2 } vvi_picture_kind;

/** What came of a wish; zeros: nothing. */
typedef struct vvi_painted {
    uint8_t *bytes; /**< of a picture file; NULL: it failed */
    size_t n;
    vvi_picture_kind kind;
    int32_t size[2], full[2];
    int level;
    int64_t passes;
    bool final, moving;
    bool reduced; /**< for a thin line; it would have had `whole` bytes */
    size_t whole;
    uint64_t commit, number;
    int64_t event;
    double seconds; /**< that rendering and encoding took */
    bool has_stand; /**< the camera was the World's: */
    vvi_stand stand;
    const char *method;    /**< a row of the renderer table */
    char *resolved;        /**< the scene with all that was worked out, as JSON; NULL: as it was */
    char *error;           /**< one sentence */
    char *where;           /**< the property of the World that the error is about; NULL: none is known */
    vvi_warnings warnings; /**< of files that were read; with a frame, or without one */
} vvi_painted;

/** Rays of all pictures at rest so far. */
typedef struct vvi_painter_rays {
    uint64_t cast; /**< now */
    uint64_t kept; /**< before, for a picture that depends on the same things */
} vvi_painter_rays;

typedef struct vvi_painter vvi_painter;

/** wake(user) is called on the painter's thread when a frame is there. */
vv_status vvi_painter_new(vvi_painter **out, vv_runtime *runtime, void (*wake)(void *user), void *user);
void vvi_painter_free(vvi_painter *painter); /* NULL is fine */
/** The wish of view `slot` (below VVI_PAINTER_VIEWS) from now on; rendering at rest for an older one stops. */
void vvi_painter_want(vvi_painter *painter, int slot, const vvi_wish *wish);
/** The view wishes nothing for now; rendering at rest stops. */
void vvi_painter_rest(vvi_painter *painter, int slot);
/** Whether nothing is rendered for it, not even for one that is gone. */
bool vvi_painter_is_free(vvi_painter *painter, int slot);
/** The view is gone: its wish and its frame too. */
void vvi_painter_forget(vvi_painter *painter, int slot);
void vvi_painter_count_rays(vvi_painter_rays *out, vvi_painter *painter);
/** Takes the frame of a view; false where there is no new one. Free it with vvi_painted_free(). */
bool vvi_painter_take(vvi_painted *out, vvi_painter *painter, int slot);
void vvi_painted_free(vvi_painted *painted);
#endif
