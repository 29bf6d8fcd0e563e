/* Data that are made, for whoever works on files: samples by time step, and what is known of channels and labels. */
#include "core/memory.h"
#include "io/data_file.h"
#include "run/made.h"
#include "scene/load.h"
#include <stdlib.h>

typedef struct origin {
    vv_world *world; /* held */
    const vv_dataset *dataset;
} origin;

static vv_status read_frame(vv_field **out, void *user, int64_t frame, vv_job *job)
{
    const origin *o = user;
    return vv_dataset_field(out, o->world, o->dataset, NULL, frame, job);
}

static void drop(void *user)
{
    origin *o = user;
    vv_object_release(&o->world->base);
    free(o);
}

static vv_status take_words(vv_notes *notes, const vvi_words *words)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < words->options.n_channels && st == VV_OK; i++)
        st = vvi_notes_channel(notes, &words->options.channels[i]);
    for (size_t i = 0; i < words->options.n_labels && st == VV_OK; i++)
        st = vvi_notes_label(notes, &words->options.labels[i]);
    return st;
}

vv_status vvi_made_open_file(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made made;
    vv_field_info info;
    vv_notes *notes = NULL;
    vvi_words words = {.n = 0};
    origin *o = NULL;
    *out = NULL;
    const char *id = "";
    vv_status st = vvi_made_behind(&dataset, &id, world, job);
    if (st != VV_OK)
        return st;
    if (!vv_dataset_is_made(dataset))
        return vvi_dataset_open(out, world, dataset, job);
    if ((st = vvi_made_open(&made, world, dataset, job)) == VV_OK)
        st = vv_dataset_info(&info, world, dataset, job);
    if (st == VV_OK && (st = vvi_words_open(&words, world, dataset, job)) == VV_OK &&
        (st = vvi_notes_new(&notes, job)) == VV_OK)
        st = take_words(notes, &words);
    if (st == VV_OK && !(o = vvi_calloc(1, sizeof *o)))
        st = vv_fail_memory(sizeof *o);
    if (st == VV_OK) {
        *o = (origin){(vv_world *)(void *)vv_object_retain(&world->base), dataset};
        const vvi_data_source source = {read_frame, drop, o};
        st = vvi_file_of_data(out, made.id, &info, notes, &source, job);
    } else {
        vvi_notes_free(notes);
    }
    if (st == VV_OK && words.file) {
        vvi_file_take_origin(*out, words.file, words.options.new_values);
        words.file = NULL; /* it is the other's */
    }
    vvi_words_close(&words);
    vvi_made_close(&made);
    return st;
}
